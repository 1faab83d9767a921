import { create } from '@bufbuild/protobuf';
import { beforeEach, describe, expect, it, vi } from 'vitest';
import { GetStatusResponseSchema } from '@/api/gen/driftwise/v1/cell_service_pb';
import { ChannelLayoutSchema, ValuesUpdateSchema } from '@/api/gen/driftwise/v1/watch_service_pb';
import { channel, onValues, paintChannels, resetCellTime, takeCellTime, takeLayout, takeValues } from '@/live/channels';
import { connection } from '@/live/connection';
import { cell } from '@/live/state';

const second = 1000;
const layoutOf = (revision: bigint, ...names: string[]) =>
  create(ChannelLayoutSchema, { revision, columns: names.map((name) => ({ channel: name, unit: 'degC', staleAfterS: 30 })) });

beforeEach(() => {
  resetCellTime();
  connection.value = { phase: 'live' };
  takeLayout(layoutOf(1n, 't01_degC', 't02_degC'));
});

const take = (atMs: number, values: number[], ageMs: bigint[]) => {
  takeCellTime(atMs);
  takeValues(create(ValuesUpdateSchema, { layoutRevision: 1n, values, ageMs }), atMs);
  paintChannels();
};

describe('a channel', () => {
  it('is stale by the daemon’s time, whatever this computer’s clock says', () => {
    take(100 * second, [21.5, 22], [0n, 31_000n]);
    expect(channel('t01_degC')!.stale.value).toBe(false);
    expect(channel('t02_degC')!.stale.value).toBe(true);
    takeCellTime(131 * second); // heartbeats without values
    paintChannels();
    expect(channel('t01_degC')!.stale.value).toBe(true);
    expect(channel('t01_degC')!.ageS.value).toBe(31);
  });
  it('keeps its age when the daemon’s clock is set back, and goes on ageing', () => {
    const hour = 3600 * second;
    const ages: number[] = [];
    for (const [atMs, value] of [[10 * hour, 21], [9 * hour, 22], [9.5 * hour, 23]]) {
      take(atMs, [value, value], [200n, 200n]);
      expect(channel('t01_degC')!.value.value).toBe(value);
      expect(channel('t01_degC')!.stale.value).toBe(false);
      ages.push(channel('t01_degC')!.ageS.value);
    }
    expect(ages).toEqual([0.2, 0.2, 0.2]);
    takeCellTime(8 * hour); // a heartbeat after the next step back: no time is known to have passed
    takeCellTime(8 * hour + 31 * second);
    paintChannels();
    expect(channel('t01_degC')!.ageS.value).toBe(31.2);
    expect(channel('t01_degC')!.stale.value).toBe(true);
  });
  it('is stale when the page is not live, and when it was never read', () => {
    take(100 * second, [21.5, NaN], [0n, -1n]);
    expect(channel('t02_degC')!.stale.value).toBe(true);
    connection.value = { phase: 'lost', lastMs: 0 };
    expect(channel('t01_degC')!.stale.value).toBe(true);
  });
  it.each([['', 1, 3000.2], [', at the speed of its cell', 10, 30_000.2]])('goes on ageing while the page is not live%s', (_, speed, ageS) => {
    const clock = vi.spyOn(performance, 'now').mockReturnValue(0);
    cell.value = create(GetStatusResponseSchema, { speed });
    take(100 * second, [21.5, 22], [200n, 0n]);
    clock.mockReturnValue(400);
    paintChannels();
    expect(channel('t01_degC')!.ageS.value).toBe(0.2); // live: the daemon's clock alone
    connection.value = { phase: 'lost', lastMs: 0 };
    clock.mockReturnValue(3000 * second);
    paintChannels();
    expect(channel('t01_degC')!.ageS.value).toBe(ageS);
    cell.value = undefined;
    clock.mockRestore();
  });
  it('is heard with every update, though only the last before a painting is shown', () => {
    const heard: unknown[] = [];
    const end = onValues((brought) => heard.push(brought('t02_degC')));
    for (const value of [22, 23]) takeValues(create(ValuesUpdateSchema, { layoutRevision: 1n, values: [21, value], ageMs: [0n, 500n] }), value * second);
    end();
    expect(heard).toEqual([[22, 21_500], [23, 22_500]]);
  });
  it('keeps its signal over a new layout, so that components go on following it', () => {
    take(100 * second, [21.5, 22], [0n, 0n]);
    const before = channel('t01_degC')!.value;
    takeLayout(layoutOf(2n, 't02_degC', 't01_degC', 't03_degC'));
    expect(channel('t01_degC')!.value).toBe(before);
  });
  it('takes no values of another layout', () => {
    take(100 * second, [21.5, 22], [0n, 0n]);
    takeLayout(layoutOf(2n, 't02_degC', 't01_degC'));
    take(101 * second, [30, 40], [0n, 0n]); // still of revision 1
    expect(channel('t01_degC')!.value.value).toBe(21.5);
  });
});
