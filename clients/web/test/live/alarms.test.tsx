// The list of alarms is had in the end, whatever became of the first question, and stands beside a later one that fails.
import { create } from '@bufbuild/protobuf';
import { Code, ConnectError, createRouterTransport } from '@connectrpc/connect';
import { cleanup, configure, render, screen } from '@testing-library/preact';
import { afterEach, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { Alarm_Level, AlarmSchema, WatchService } from '@/api/gen/driftwise/v1/watch_service_pb';
import { AlarmWatch } from '@/app/alarm_watch';
import { standing } from '@/live/alarms';
import { connection } from '@/live/connection';
import { AlarmList, WallAlarms } from '@/views/now/alarm_list';
import { at } from '../fake/cell';

vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });
afterEach(cleanup);

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

it.each([['the list', AlarmList], ['the wall', WallAlarms]])('shows in %s what is known beside the question that failed', (_, List) => {
  standing.value = { value: [lost], failure, waiting: false, again: () => undefined, set: () => undefined };
  render(<List />);
  expect(screen.getByRole('alert')).toBeTruthy();
  expect(screen.getByText(/Laser x does not answer/)).toBeTruthy();
  standing.value = undefined;
});
