// Now of a run whose points hold no length: tilts alone (set-up "level" of the min-angle cell).
import { create } from '@bufbuild/protobuf';
import { createRouterTransport } from '@connectrpc/connect';
import { configure, render, screen } from '@testing-library/preact';
import { expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { PointSchema, RunProgressSchema } from '@/api/gen/driftwise/v1/run_pb';
import { RunService } from '@/api/gen/driftwise/v1/run_service_pb';
import { connection } from '@/live/connection';
import { progress } from '@/live/state';
import Now from '@/views/now/view';
import { at, fakeRun } from '../fake/cell';

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
});
