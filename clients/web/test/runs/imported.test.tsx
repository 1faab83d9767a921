// Page of an imported run: what its points hold is shown, and no readings are asked for, because a file brings none.
import { create } from '@bufbuild/protobuf';
import { createRouterTransport } from '@connectrpc/connect';
import { configure, render, screen, within } from '@testing-library/preact';
import { h } from 'preact';
import { beforeEach, expect, test, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { PointSchema, PointSet, Run_State, RunSchema, type Point } from '@/api/gen/driftwise/v1/run_pb';
import { RunService } from '@/api/gen/driftwise/v1/run_service_pb';
import { ChannelLayoutSchema, WatchService } from '@/api/gen/driftwise/v1/watch_service_pb';
import { go } from '@/app/router';
import { takeLayout } from '@/live/channels';
import { connection } from '@/live/connection';
import type { PlotSpec } from '@/plot/spec';
import { spanOf } from '@/views/runs/use_tracks';
import Runs from '@/views/runs/view';
import { at, fakeChannels, fakeRun } from '../fake/cell';

vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });
const plots = new Map<string, PlotSpec>();
vi.mock('@/plot/plot', () => ({ Plot: ({ spec }: { spec: PlotSpec }) => (plots.set(spec.title, spec), h('p', {}, spec.why)) }));

// A file in um and K: two lines with a return to zero each; the zero of x drifts by 0.9 um.
const fileRow = (row: number, zero: boolean, x: number, kelvin: number, force: number): Point => create(PointSchema, {
  id: BigInt(row + 1), runId: 2n, row: BigInt(row), datumId: 1n, set: PointSet.CALIBRATION, zero, measureTime: at(row),
  values: [['q1_um', x], ['x_um', x], ['t07_K', kelvin], ['force_N', force]].map(([channel, value]) => ({ channel: String(channel), value: Number(value) })),
});
const points = [fileRow(0, true, 0, 293.1, 0), fileRow(1, false, 500, 293.2, 0), fileRow(2, true, 0.9, 293.3, 2)];
const imported = create(RunSchema, {
  id: 2n, name: 'um', state: Run_State.DONE, reason: 'imported', operatorName: 'Anna', rowCount: 3n, nextRow: 3n, acceptedCount: 3n, createTime: at(0), startTime: at(0), endTime: at(0), elapsedDuration: {},
});
const asked: string[][] = [];

beforeEach(() => {
  vi.stubGlobal('ResizeObserver', class { observe() {} disconnect() {} unobserve() {} });
  plots.clear();
  asked.length = 0;
  takeLayout(create(ChannelLayoutSchema, { revision: 1n, columns: fakeChannels.map(([channel, unit]) => ({ channel, unit })) }));
  useTransport(createRouterTransport(({ service }) => {
    service(RunService, { listRuns: () => ({ runs: [imported] }), getRun: () => ({ run: imported }), listPoints: () => ({ points }), listAttempts: () => ({ attempts: [] }), listClosures: () => ({}) });
    service(WatchService, { getSeries: ({ channels }) => { asked.push(channels); return {}; } });
  }));
  connection.value = { phase: 'live' };
});

test('its plots are the values of its points, in the units of the file, and no series is asked', async () => {
  go('/runs/2?tab=plots');
  render(<Runs />);
  await screen.findByText('Channels shown: 2 of 4');
  const temperatures = plots.get('Temperatures')!;
  expect(temperatures.series.map((one) => [one.name, one.unit, Array.from(one.y)])).toEqual([['t07', 'K', [293.1, 293.2, 293.3]]]);
  expect(temperatures.note).toBe('imported: values of its points, no readings on record');
  expect(plots.get('Force')!.series.map((one) => Array.from(one.x, (hours) => Math.round(hours * 60)))).toEqual([[0, 1, 2]]);
  expect(plots.get('Spread of the repeats')!.why).toBe('Imported: no readings on record.');
  expect(Array.from(plots.get('Drift of the zero')!.series[0].y)).toEqual([0, 900]);
  expect(screen.queryByRole('alert')).toBeNull();
  expect(asked).toEqual([]);
});

test('its plots have no time of day, which would be that of the import', async () => {
  go('/runs/2?tab=plots');
  render(<Runs />);
  await screen.findByText('Channels shown: 2 of 4');
  for (const title of ['Temperatures', 'Force', 'Drift of the zero']) {
    expect(plots.get(title)!.x.startMs).toBeUndefined();
    expect(plots.get(title)!.marks!.map((mark) => mark.label)).toEqual(['force 0 to 2 N']);
  }
});

test('its head says when and by whom it was imported, not that it took 0 s; its points have their lengths', async () => {
  go('/runs/2');
  render(<Runs />);
  const head = (await screen.findByText('imported by')).closest('dl')!;
  expect(within(head).getByText('imported').nextElementSibling!.textContent).toBe('2026-05-15 18:00:00 UTC');
  expect(within(head).getByText('points').nextElementSibling!.textContent).toBe('3 of 3 (100 %)');
  expect(within(head).queryByText('measured')).toBeNull();
  const table = within(await screen.findByRole('table', { name: 'Points of run 2' }));
  expect(table.getByRole('columnheader', { name: /x, µm/ })).toBeTruthy();
  expect(table.getByText('500.000')).toBeTruthy();
  expect(screen.queryByText('No point has been measured yet.')).toBeNull();
});

test('the record of a measured run is asked from its first to its last instant, also after the clock was set back', () => {
  const minutes = (from: number, to: number) => ({ fromMs: Number(at(from).seconds) * 1000, toMs: Number(at(to).seconds) * 1000 });
  const done = { ...fakeRun, state: Run_State.DONE, startTime: at(0), endTime: at(20) };
  expect(spanOf(done, points, undefined)).toEqual(minutes(0, 20));
  expect(spanOf({ ...done, endTime: at(-30) }, points, undefined)).toEqual(minutes(-30, 2));
  expect(spanOf({ ...done, endTime: at(0) }, points.slice(0, 1), undefined)).toBeUndefined();
  expect(spanOf({ ...done, startTime: undefined, endTime: at(20) }, [], undefined)).toBeUndefined();
});
