// The points of a run: asked for in pages, and joined with what comes while they are on their way.
import { create } from '@bufbuild/protobuf';
import { createRouterTransport } from '@connectrpc/connect';
import { cleanup, configure, render, screen } from '@testing-library/preact';
import { afterEach, expect, test, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { PointSchema } from '@/api/gen/driftwise/v1/run_pb';
import { RunService } from '@/api/gen/driftwise/v1/run_service_pb';
import { useRunPoints } from '@/live/points';

vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });
afterEach(cleanup);

const point = (id: bigint) => create(PointSchema, { id, runId: 17n, row: id });

function Shown() {
  const ids = useRunPoints(17n).value?.points.map((one) => one.id) ?? [];
  return <p>{ids.length > 0 ? `points ${ids.length > 9 ? `${ids.length} to ${ids[ids.length - 1]}` : ids.join()}` : 'waiting'}</p>;
}

test('a long run comes in pages of some megabytes', async () => {
  const all = Array.from({ length: 2500 }, (_, i) => point(BigInt(i + 1)));
  const limits: number[] = [];
  useTransport(createRouterTransport(({ service }) => service(RunService, {
    listPoints: ({ afterPointId, limit }) => {
      limits.push(limit);
      return { points: all.slice(Number(afterPointId), Number(afterPointId) + limit) };
    },
    listAttempts: () => ({ attempts: [] }),
  })));
  render(<Shown />);
  await screen.findByText('points 2500 to 2500');
  expect(Math.max(...limits)).toBeLessThanOrEqual(2000);
});
