// Another record behind the daemon under an open page: nothing of the old one stays, and its ids are not those of the new one.
import { create, type MessageInitShape } from '@bufbuild/protobuf';
import { Code, ConnectError, createRouterTransport } from '@connectrpc/connect';
import { act, configure, fireEvent, render, screen } from '@testing-library/preact';
import { useState } from 'preact/hooks';
import { beforeEach, expect, test, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { PointSchema, Run_State, RunSchema } from '@/api/gen/driftwise/v1/run_pb';
import { RunService } from '@/api/gen/driftwise/v1/run_service_pb';
import { WatchEventSchema } from '@/api/gen/driftwise/v1/watch_service_pb';
import { Outlet } from '@/app/outlet';
import { epoch } from '@/live/epoch';
import { announce } from '@/live/events';
import { useRunPoints } from '@/live/points';
import { useAsked } from '@/ui/use_asked';
import { RunPage } from '@/views/runs/page';

vi.mock('@/plot/plot', () => ({ Plot: () => null }));
vi.mock('@/poses/poses', () => ({ Poses: () => null }));
vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });
beforeEach(() => vi.stubGlobal('scrollTo', () => undefined));

const point = (id: bigint, x: number): MessageInitShape<typeof PointSchema> => ({ id, runId: 1n, row: id, values: [{ channel: 'x_mm', value: x }] });

function daemonWith(run: MessageInitShape<typeof RunSchema> | undefined, points: MessageInitShape<typeof PointSchema>[]) {
  useTransport(createRouterTransport(({ service }) => service(RunService, {
    getRun: () => {
      if (!run) throw new ConnectError('there is no run 1', Code.NotFound);
      return { run };
    },
    listPoints: ({ afterPointId }) => {
      if (!run) throw new ConnectError('there is no run 1', Code.NotFound);
      return { points: points.filter((one) => one.id! > afterPointId) };
    },
    listAttempts: () => ({}),
  })));
}

const old = { id: 1n, name: 'the old one', state: Run_State.DONE, rowCount: 2n };

const afresh = () => act(() => void epoch.value++);

test('the page of a run that the new record has not says so, and shows nothing of the old one', async () => {
  daemonWith(old, [point(1n, 1)]);
  render(<RunPage id={1n} />);
  await screen.findByText(/the old one/);
  daemonWith(undefined, []);
  afresh();
  await screen.findByText(/there is no run 1/);
  expect(screen.queryByText(/the old one/)).toBeNull();
  const begun = { ...old, name: 'the new one', state: Run_State.RUNNING };
  daemonWith(begun, []);
  act(() => announce(create(WatchEventSchema, { event: { case: 'run', value: create(RunSchema, begun) } })));
  await screen.findByText(/the new one/);
});

test('points of the new record are shown, though the old one had the same ids', async () => {
  const Shown = () => <p>{useRunPoints(1n).value?.points.map((one) => `${one.id}: ${one.values[0].value}`).join() || 'none'}</p>;
  daemonWith(old, [point(1n, 10), point(2n, 20)]);
  render(<Shown />);
  await screen.findByText('1: 10,2: 20');
  daemonWith(undefined, []);
  afresh();
  await screen.findByText('none');
  daemonWith(old, [point(1n, 1)]);
  act(() => announce(create(WatchEventSchema, { event: { case: 'point', value: create(PointSchema, point(1n, 1)) } })));
  await screen.findByText('1: 1');
});

test('an answer that is on its way from the old record is none of the new one', async () => {
  let late = (_: string): void => undefined;
  const ask = vi.fn<() => Promise<string>>().mockReturnValueOnce(new Promise((done) => (late = done))).mockResolvedValue('new');
  const Shown = () => <p>{useAsked('list', ask).value ?? 'waiting'}</p>;
  render(<Shown />);
  await vi.waitFor(() => expect(ask).toHaveBeenCalledTimes(1));
  afresh();
  await screen.findByText('new');
  await act(async () => late('old'));
  expect(screen.getByText('new')).toBeTruthy();
});

test('what a view chose and computed goes with the record', async () => {
  function View() {
    const [chosen, choose] = useState('nothing');
    return <button type="button" onClick={() => choose('model 2')}>{chosen}</button>;
  }
  const entry = { id: 'models', title: 'Models', load: async () => ({ default: View }) } as never;
  render(<Outlet entry={entry} />);
  fireEvent.click(await screen.findByText('nothing'));
  await screen.findByText('model 2');
  afresh();
  await screen.findByText('nothing');
});
