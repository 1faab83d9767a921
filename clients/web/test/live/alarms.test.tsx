// The list of alarms is had in the end, whatever became of the first question, and stands beside a later one that fails.
import { create } from '@bufbuild/protobuf';
import { Code, ConnectError, createRouterTransport } from '@connectrpc/connect';
import { act, configure, render, screen, waitFor } from '@testing-library/preact';
import { expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { Alarm_Level, AlarmSchema, WatchEventSchema, WatchService, type Alarm } from '@/api/gen/driftwise/v1/watch_service_pb';
import { AlarmWatch } from '@/app/alarm_watch';
import { arrived, standing } from '@/live/alarms';
import { connection } from '@/live/connection';
import { announce, onEvents } from '@/live/events';
import { AlarmList, WallAlarms } from '@/views/now/alarm_list';
import { at } from '../fake/cell';

vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });

const lost = create(AlarmSchema, { id: 2n, level: Alarm_Level.FAILED, kind: 'device.lost', subject: 'laser-x', message: 'Laser x does not answer.', sinceTime: at(1) });
const failure = { code: Code.Unavailable, reason: '', message: 'The daemon did not answer.', lost: true };

it('asks on a live page until the list is there', async () => {
  let asked = 0;
  useTransport(createRouterTransport(({ service }) => service(WatchService, {
    listAlarms: () => {
      if (++asked === 1) throw new ConnectError('reset', Code.Unavailable);
      return { alarms: [lost] };
    },
  })));
  connection.value = { phase: 'live' };
  render(<><AlarmWatch /><WallAlarms /></>);
  expect(await screen.findByText(/The daemon did not answer/)).toBeTruthy();
  expect(await screen.findByText(/Laser x does not answer/)).toBeTruthy();
  expect(screen.queryByRole('alert')).toBeNull();
  expect(document.title).toContain('Laser x does not answer.');
});

// A full disk: what begins has no number until the record takes it, and is told at once all the same.
const tell = (one: Alarm) => act(() => announce(create(WatchEventSchema, { event: { case: 'alarm', value: one } })));
const onFullDisk = (subject: string, more: { id?: bigint; clearedTime?: ReturnType<typeof at> } = {}): Alarm =>
  create(AlarmSchema, { id: 0n, level: Alarm_Level.FAILED, kind: 'device.lost', subject, message: `${subject} does not answer.`, sinceTime: at(1), ...more });
const lines = () => screen.queryAllByRole('listitem').map((line) => line.textContent);

it('shows an alarm that is not on record once, until it is over, and lets nobody acknowledge it before', async () => {
  let asked = 0;
  useTransport(createRouterTransport(({ service }) => service(WatchService, { listAlarms: () => (++asked, { alarms: [] }) })));
  connection.value = { phase: 'live' };
  arrived.value = [];
  render(<><AlarmWatch /><AlarmList /></>);
  await waitFor(() => expect(standing.value?.value).toEqual([]));
  tell(onFullDisk('laser-x'));
  tell(onFullDisk('laser-y'));
  await waitFor(() => expect(lines()).toHaveLength(2));
  expect(screen.queryByRole('button', { name: /Acknowledge/ })).toBeNull();
  expect(screen.getAllByText(/not on record yet/)).toHaveLength(2);
  expect(arrived.value.at(-1)?.subject).toBe('laser-y');
  tell(onFullDisk('laser-x', { id: 7n }));
  await waitFor(() => expect(screen.getAllByRole('button', { name: /^Acknowledge: / })).toHaveLength(1));
  expect(lines()).toHaveLength(2);
  expect(arrived.value.at(-1)?.subject).toBe('laser-y'); // it is no new one
  tell(onFullDisk('laser-y', { clearedTime: at(2) }));
  await waitFor(() => expect(lines().find((line) => line?.includes('laser-y'))).toContain('over'));
  expect(lines()).toHaveLength(2);
  // Another daemon does not have what only the old one knew.
  act(() => void (connection.value = { phase: 'lost', lastMs: undefined }));
  act(() => void (connection.value = { phase: 'live' }));
  await waitFor(() => expect(asked).toBe(2));
  await waitFor(() => expect(lines()).toHaveLength(0));
});

it.each([['the list', AlarmList], ['the wall', WallAlarms]])('says in %s that the alarms are awaited, until they are there', async (_, List) => {
  standing.value = { waiting: true, again: () => undefined, set: () => undefined };
  render(<List />);
  expect(await screen.findByText(/Waiting for the alarms/)).toBeTruthy();
  act(() => void (standing.value = { value: [], waiting: false, again: () => undefined, set: () => undefined }));
  await waitFor(() => expect(screen.queryByText(/Waiting for the alarms/)).toBeNull());
  standing.value = undefined;
});

it('goes on though one listener fails', () => {
  const told = vi.spyOn(console, 'error').mockImplementation(() => undefined);
  const heard: bigint[] = [];
  const ends = [onEvents('alarm', () => {
    throw new TypeError('Illegal constructor');
  }), onEvents('alarm', (alarm) => heard.push(alarm.id))];
  announce(create(WatchEventSchema, { event: { case: 'alarm', value: lost } }));
  expect(heard).toEqual([lost.id]);
  expect(told).toHaveBeenCalledTimes(1);
  ends.forEach((end) => end());
  told.mockRestore();
});

it.each([['the list', AlarmList], ['the wall', WallAlarms]])('shows in %s what is known beside the question that failed', (_, List) => {
  standing.value = { value: [lost], failure, waiting: false, again: () => undefined, set: () => undefined };
  render(<List />);
  expect(screen.getByRole('alert')).toBeTruthy();
  expect(screen.getByText(/Laser x does not answer/)).toBeTruthy();
  standing.value = undefined;
});
