import { create } from '@bufbuild/protobuf';
import { expect, it, describe } from 'vitest';
import { RunSchema, Run_State } from '@/api/gen/driftwise/v1/run_pb';
import { wantedForce } from '@/parts/run_words';
import { zeroDrift } from '@/parts/zero_plot';
import { matches } from '@/views/runs/list';
import { rowsOf } from '@/views/runs/points_tab';
import { rowsText, rowsTyped } from '@/views/runs/row_ranges';
import { fakeAttempts, fakePoints, fakeRun } from '../fake/cell';

describe('rows as people write them', () => {
  it('count from 1, as the daemon does', () => {
    const ranges = rowsTyped('12-15, 40', 100);
    expect(ranges).toEqual([{ firstRow: 12n, lastRow: 15n }, { firstRow: 40n, lastRow: 40n }]);
    expect(rowsText(ranges as never)).toBe('12-15, 40');
  });
  it.each([['', 'Rows like'], ['3-x', '"3-x" is no row'], ['0', 'from 1 to 9'], ['4-11', 'from 1 to 9'], ['7-5', 'from 1 to 9']])('%s is refused', (text, words) =>
    expect(rowsTyped(text, 9)).toContain(words));
});

it('a run is found by every word that is typed', () => {
  expect(matches(fakeRun, 'cal anna', '')).toBe(true);
  expect(matches(fakeRun, 'cal ben', '')).toBe(false);
  expect(matches(fakeRun, '17', 'running')).toBe(true);
  expect(matches(fakeRun, '', 'done')).toBe(false);
});

it('a row keeps all its attempts and the one point that came of them', () => {
  const rows = rowsOf({ points: fakePoints, passages: [], attempts: fakeAttempts });
  expect(rows.length).toBe(612);
  expect(rows[40].attempts.map((one) => one.number)).toEqual([1, 2]);
  expect(rows[40].point?.row).toBe(40n);
});

it('a passage is a row after those of the plan, by a word of its own', () => {
  const passage = { ...fakePoints[0], id: 9000n, row: 613n, passage: true };
  const rows = rowsOf({ points: fakePoints, passages: [passage], attempts: fakeAttempts });
  expect(rows.length).toBe(613);
  expect(rows[612].point?.passage).toBe(true);
  expect(rows[612].attempts).toEqual([]);
});

it('drift of the zero starts at zero with every datum', () => {
  const two = fakePoints.slice(0, 100).map((point, i) => ({ ...point, datumId: i < 50 ? 3n : 4n }));
  const drift = zeroDrift(two, 0, ['x_mm']);
  const firstOfSecond = two.filter((point) => point.zero).findIndex((point) => point.datumId === 4n);
  expect(drift.nm[0][0]).toBe(0);
  expect(drift.nm[0][firstOfSecond]).toBe(0);
  expect(drift.nm[0][firstOfSecond - 1]).not.toBe(0);
});

it('the force to hang is read from the daemon’s sentence', () => {
  const waits = (reason: string) => wantedForce(create(RunSchema, { state: Run_State.WAITING, reason }));
  expect(waits('hang 0.768 N (78 g)')).toBe(0.768);
  expect(waits('take every weight off: 0 N')).toBe(0);
  expect(waits('laser-x does not answer')).toBeUndefined();
});
