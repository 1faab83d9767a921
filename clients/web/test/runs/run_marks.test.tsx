// The marks of a run come from its points and from what the record says of it and of the cell meanwhile.
import { create } from '@bufbuild/protobuf';
import { cleanup, configure, render, screen } from '@testing-library/preact';
import { useContext } from 'preact/hooks';
import { afterAll, afterEach, beforeAll, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { EventSchema } from '@/api/gen/driftwise/v1/cell_service_pb';
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
afterEach(cleanup);

const Shown = () => <ul>{useContext(TimeMarks).map((mark) => <li>{mark.kind}: {mark.label}</li>)}</ul>;
const happens = (id: bigint, what: string, detail: string, minutes: number, runId?: bigint) =>
  announce(create(WatchEventSchema, { event: { case: 'record', value: create(EventSchema, { id, what, detail, eventTime: at(minutes), ...(runId && { runId }) }) } }));

it('marks force, stops and restarts, and leaves out other runs and what was before', async () => {
  const points = fakePoints.slice(0, 6).map((point, i) => ({ ...point, values: [{ $typeName: 'driftwise.v1.ChannelValue' as const, channel: 'force_N', value: i < 3 ? 0 : 0.768 }] }));
  render(<RunMarks run={fakeRun} points={{ points, attempts: [] }}><Shown /></RunMarks>);
  await screen.findByText('force: force 0 to 0.768 N');
  await vi.waitFor(() => {
    happens(900n, 'run.paused', 'anna paused', 30, 17n);
    expect(screen.getByText('stop: anna paused')).toBeTruthy(); // what comes before the list was answered is in the list
  }, { timeout: 15_000 });
  happens(901n, 'stop', 'Anna stopped everything', 31);
  happens(902n, 'run.restarted', 'went on', 32, 17n);
  happens(903n, 'run.paused', 'another run', 33, 16n);
  happens(904n, 'stop', 'before it began', -5);
  await screen.findByText('restart: went on');
  expect(screen.getAllByRole('listitem').map((one) => one.textContent)).toEqual(
    ['force: force 0 to 0.768 N', 'stop: anna paused', 'stop: Anna stopped everything', 'restart: went on']);
});
