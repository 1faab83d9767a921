// The points of a run: asked for in pages, and joined with what comes while they are on their way.
import { create } from '@bufbuild/protobuf';
import { createRouterTransport } from '@connectrpc/connect';
import { configure, render, screen } from '@testing-library/preact';
import { expect, test, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { PointSchema } from '@/api/gen/driftwise/v1/run_pb';
import { Alarm_Level, AlarmSchema, WatchEventSchema, WatchService } from '@/api/gen/driftwise/v1/watch_service_pb';
import { RunService } from '@/api/gen/driftwise/v1/run_service_pb';
import { arrived, useAlarms } from '@/live/alarms';
import { announce } from '@/live/events';
import { useRunPoints } from '@/live/points';
import { at } from '../fake/cell';

vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });

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

// An answer that was made at once and arrives when it is released.
function late() {
  let release = (): void => undefined;
  let asked = (): void => undefined;
  const gate = new Promise<void>((done) => (release = done));
  const wasAsked = new Promise<void>((done) => (asked = done));
  return { wasAsked, release: () => release(), answer: async <T,>(made: T): Promise<T> => (asked(), await gate, made) };
}

test('a point that is measured while the list is on its way is shown, once', async () => {
  const list = late();
  useTransport(createRouterTransport(({ service }) => service(RunService, {
    listPoints: () => list.answer({ points: [point(1n), point(2n)] }),
    listAttempts: () => ({ attempts: [] }),
  })));
  render(<Shown />);
  await list.wasAsked;
  for (const id of [2n, 3n]) announce(create(WatchEventSchema, { event: { case: 'point', value: point(id) } }));
  list.release();
  await screen.findByText('points 1,2,3');
  announce(create(WatchEventSchema, { event: { case: 'point', value: point(4n) } }));
  await screen.findByText('points 1,2,3,4');
});

test('an alarm that comes while the list is on its way stands in it, and one that ends does not', async () => {
  const list = late();
  const alarm = (id: bigint, over = false) => create(AlarmSchema, { id, level: Alarm_Level.FAILED, message: `alarm ${id}`, ...(over && { clearedTime: at(1), acknowledgeTime: at(2) }) });
  useTransport(createRouterTransport(({ service }) => service(WatchService, { listAlarms: () => list.answer({ alarms: [alarm(1n)] }) })));
  const Alarms = () => <p>{useAlarms().value?.map((one) => one.message).join() ?? 'waiting'}</p>;
  render(<Alarms />);
  await list.wasAsked;
  announce(create(WatchEventSchema, { event: { case: 'alarm', value: alarm(2n) } }));
  announce(create(WatchEventSchema, { event: { case: 'alarm', value: alarm(1n, true) } }));
  list.release();
  await screen.findByText('alarm 2');
  expect(arrived.value.map((one) => one.id)).toEqual([2n]);
});
