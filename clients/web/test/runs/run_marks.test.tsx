// The marks of a run come from its points and from what the record says of it and of the cell meanwhile.
import { create } from '@bufbuild/protobuf';
import { createRouterTransport } from '@connectrpc/connect';
import { configure, render, screen } from '@testing-library/preact';
import { useContext } from 'preact/hooks';
import { afterAll, beforeAll, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { CellService, EventSchema } from '@/api/gen/driftwise/v1/cell_service_pb';
import { WatchEventSchema } from '@/api/gen/driftwise/v1/watch_service_pb';
import { announce } from '@/live/events';
import { startStream } from '@/live/stream';
import { RunMarks } from '@/parts/run_marks';
import { TimeMarks } from '@/plot/marks';
import { at, fakePoints, fakeRun } from '../fake/cell';
import { fakeDaemon } from '../fake/daemon';

vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });
let endStream: () => void;
beforeAll(() => {
  useTransport(fakeDaemon());
  endStream = startStream();
});
afterAll(() => endStream());

const Shown = () => <ul>{useContext(TimeMarks).map((mark) => <li>{mark.kind}: {mark.label}</li>)}</ul>;
const happens = (id: bigint, what: string, detail: string, minutes: number, runId?: bigint) =>
  announce(create(WatchEventSchema, { event: { case: 'record', value: create(EventSchema, { id, what, detail, eventTime: at(minutes), ...(runId && { runId }) }) } }));

it('marks force, stops and restarts, and leaves out other runs and what was before', async () => {
  const points = fakePoints.slice(0, 6).map((point, i) => ({ ...point, values: [{ $typeName: 'driftwise.v1.ChannelValue' as const, channel: 'force_N', value: i < 3 ? 0 : 0.768 }] }));
  render(<RunMarks run={fakeRun} points={{ points, passages: [], attempts: [] }}><Shown /></RunMarks>);
  await screen.findByText('force: force 0 to 0.768 N');
  await vi.waitFor(() => {
    happens(900n, 'run.pause', 'anna paused', 30, 17n);
    expect(screen.getByText('stop: anna paused')).toBeTruthy(); // what comes before the list was answered is in the list
  }, { timeout: 15_000 });
  happens(901n, 'stop', 'Anna stopped everything', 31);
  happens(902n, 'run.restarted', 'went on', 32, 17n);
  happens(903n, 'run.pause', 'another run', 33, 16n);
  happens(904n, 'stop', 'before it began', -5);
  await screen.findByText('restart: went on');
  expect(screen.getAllByRole('listitem').map((one) => one.textContent)).toEqual(
    ['force: force 0 to 0.768 N', 'stop: anna paused', 'stop: Anna stopped everything', 'restart: went on']);
});

it('reads of a long record only what belongs to the time of the run', async () => {
  const events = Array.from({ length: 200_000 }, (_, i) => ({ id: BigInt(i + 1), what: i % 100 === 0 ? 'stop' : 'device.back', detail: `event ${i + 1}`, minute: i - 150_000 }));
  let sent = 0;
  useTransport(createRouterTransport(({ service }) => service(CellService, {
    listEvents: ({ afterEventId, limit }) => {
      const page = events.slice(Number(afterEventId), Number(afterEventId) + limit);
      sent += page.length;
      return { events: page.map(({ minute, ...event }) => ({ ...event, who: 'Anna', peer: '', eventTime: at(minute) })) };
    },
  })));
  const run = { ...fakeRun, id: 18n, startTime: at(0), endTime: at(250) };
  render(<RunMarks run={run} points={undefined}><Shown /></RunMarks>);
  await screen.findByText('stop: event 150001');
  expect(screen.getAllByRole('listitem').map((one) => one.textContent)).toEqual([1, 101, 201].map((i) => `stop: event ${150_000 + i}`));
  expect(sent).toBeLessThan(4000);
});
