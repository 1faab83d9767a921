// Now of a run whose points hold no length: tilts alone (set-up "level" of the min-angle cell).
import { create } from '@bufbuild/protobuf';
import { createRouterTransport } from '@connectrpc/connect';
import { act, configure, render, screen } from '@testing-library/preact';
import { expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { GetStatusResponseSchema } from '@/api/gen/driftwise/v1/cell_service_pb';
import { PointSchema, RunProgressSchema } from '@/api/gen/driftwise/v1/run_pb';
import { RunService } from '@/api/gen/driftwise/v1/run_service_pb';
import { connection } from '@/live/connection';
import { cell, progress } from '@/live/state';
import { DeviceList } from '@/views/now/device_list';
import { IdlePanel } from '@/views/now/run_panel';
import Now from '@/views/now/view';
import { at, fakeRun, fakeStatus } from '../fake/cell';

vi.mock('@/plot/plot', () => ({ Plot: ({ spec }: { spec: { title: string; why?: string } }) => <figure>{spec.title}: {spec.why}</figure> }));
vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });

it('shows a run of tilts without a drift of the zero', async () => {
  const points = [1, 2, 3].map((i) => create(PointSchema, {
    id: BigInt(i), runId: fakeRun.id, row: BigInt(i), datumId: 1n, zero: i !== 2, measureTime: at(i / 10),
    values: [{ channel: 'q1_mm', value: 0 }, { channel: 'rx_arcsec', value: i }, { channel: 't01_degC', value: 20 }],
  }));
  useTransport(createRouterTransport(({ service }) => service(RunService, {
    getRun: () => ({ run: fakeRun, rulesJson: '{}' }), listAttempts: () => ({ attempts: [] }), listPoints: () => ({ points }),
  })));
  connection.value = { phase: 'live' };
  progress.value = create(RunProgressSchema, { run: fakeRun, lastSpreadNm: 3.8 });
  render(<Now />);
  expect(await screen.findByText('Drift of the zero: No length is among the channels of its points.')).toBeTruthy();
  expect(screen.getByText('Running')).toBeTruthy();
  expect(screen.getByText('Spread of last point')).toBeTruthy();
  expect(screen.queryByText(/^Drift of the zero,/)).toBeNull();
  const tile = screen.getByText('Spread of last point').closest('.tile')!;
  expect(tile.classList.contains('stale')).toBe(false);
  act(() => void (connection.value = { phase: 'lost', lastMs: 0 }));
  expect(tile.classList.contains('stale')).toBe(true);
});

it('does not say of a page that is not live that devices answer, or that no run is under way', async () => {
  useTransport(createRouterTransport(({ service }) => service(RunService, { listRuns: () => ({ runs: [] }) })));
  connection.value = { phase: 'live' };
  cell.value = create(GetStatusResponseSchema, { devices: fakeStatus.devices });
  render(<><DeviceList /><IdlePanel /></>);
  const answering = screen.getAllByText(/^answers/).length;
  const idle = screen.getByText('No run').closest('.panel')!;
  expect(answering).toBeGreaterThan(0);
  expect(idle.classList.contains('stale')).toBe(false);
  act(() => void (connection.value = { phase: 'lost', lastMs: 0 }));
  expect(screen.queryAllByText(/^answers/)).toEqual([]);
  expect(screen.getAllByText('not known')).toHaveLength(answering);
  expect(screen.getByRole('heading').textContent).toBe(`Devices: not known which of ${fakeStatus.devices!.length} answer`);
  expect(idle.classList.contains('stale')).toBe(true);
});
