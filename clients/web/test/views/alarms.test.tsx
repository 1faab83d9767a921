// Alarms stand first: across a room and in the tab's title. One answer to many covers those that were read, and no other.
import { cleanup, configure, fireEvent, render, screen, waitFor, within } from '@testing-library/preact';
import type { Transport } from '@connectrpc/connect';
import { create } from '@bufbuild/protobuf';
import { batch } from '@preact/signals';
import { afterAll, beforeAll, beforeEach, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { Alarm_Level, Alarm_Priority, AlarmSchema, WatchEventSchema, type Alarm } from '@/api/gen/driftwise/v1/watch_service_pb';
import { pageTitle } from '@/app/page_title';
import { go } from '@/app/router';
import { setOperatorName } from '@/app/session';
import { helpOpen } from '@/app/keys';
import { notices, noticesRefused, switchNotices, switchSound } from '@/live/alarm_signals';
import { arrived, standing } from '@/live/alarms';
import { AlarmList } from '@/views/now/alarm_list';
import { Shell } from '@/app/shell';
import { announce } from '@/live/events';
import { startStream } from '@/live/stream';
import { at } from '../fake/cell';
import { fakeDaemon } from '../fake/daemon';

vi.mock('@/plot/plot', () => ({ Plot: ({ spec }: { spec: { title: string } }) => <figure>{spec.title}</figure> }));
vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });

const alarm = (id: bigint, level: Alarm_Level, message: string, over = false): Alarm =>
  create(AlarmSchema, { id, level, kind: 'device.late', subject: `device-${id}`, message, sinceTime: at(1), ...(over && { clearedTime: at(2) }) });
const late = alarm(1n, Alarm_Level.WARNING, 'Scanner answered late.');
const lost = alarm(2n, Alarm_Level.FAILED, 'Laser x does not answer.');
const warm = alarm(3n, Alarm_Level.FAILED, 'Air was at 24 °C.', true);
const arrives = (one: Alarm) => announce(create(WatchEventSchema, { event: { case: 'alarm', value: one } }));

const acknowledged: bigint[] = [];
function counting(inner: Transport): Transport {
  return {
    unary: (method, signal, timeoutMs, header, input, ...rest) => {
      if (method.name === 'AcknowledgeAlarm') acknowledged.push((input as { alarmId: bigint }).alarmId);
      return inner.unary(method, signal, timeoutMs, header, input, ...rest);
    },
    stream: (method, ...rest) => inner.stream(method, ...rest),
  };
}

let endStream: () => void;
beforeAll(() => {
  useTransport(counting(fakeDaemon({ alarms: [warm, late, lost] })));
  endStream = startStream();
});
afterAll(() => endStream());
beforeEach(() => {
  vi.stubGlobal('scrollTo', () => undefined);
  acknowledged.length = 0;
  setOperatorName('Anna');
});

it('says alarms before the view in the title of the tab, on every view', async () => {
  go('/record');
  render(<Shell />);
  await waitFor(() => expect(document.title).toBe('▲ 3 alarms, Failed: Laser x does not answer. – Record – Driftwise'));
  expect(pageTitle('Now', [])).toBe('Now – Driftwise');
  expect(pageTitle('Now', [late])).toBe('▲ Warning: Scanner answered late. – Now – Driftwise');
});

it('shows alarms first across a room, those that last before those that are over, and nothing to press', async () => {
  go('/now?wall=1');
  render(<Shell />);
  const list = await screen.findByRole('region', { name: 'What needs attention' });
  expect(within(list).getAllByRole('listitem').map((line) => line.querySelector('p')!.firstChild!.textContent)).toEqual([lost.message, late.message, warm.message]);
  const run = await screen.findByText('Running');
  expect(list.compareDocumentPosition(run) & Node.DOCUMENT_POSITION_FOLLOWING).toBeTruthy();
  expect(within(screen.getByRole('main')).queryAllByRole('button')).toEqual([]);
});

it('acknowledges all that were shown, and neither what arrived since nor what became worse', async () => {
  go('/now');
  render(<Shell />);
  await screen.findByText('Live');
  fireEvent.click(await screen.findByRole('button', { name: 'Acknowledge all…' }));
  const dialog = (await screen.findByText('Acknowledge 3 alarms?')).closest('dialog')!;
  for (const one of [late, lost, warm]) expect(within(dialog).getByText(one.message)).toBeTruthy();
  arrives(alarm(4n, Alarm_Level.FAILED, 'Laser y does not answer.'));
  arrives({ ...late, level: Alarm_Level.FAILED, message: 'Scanner does not answer.' });
  await screen.findByText(/Laser y does not answer/, { selector: 'li p' });
  fireEvent.click(within(dialog).getByRole('button', { name: 'Acknowledge these 3' }));
  await waitFor(() => expect(acknowledged).toEqual([lost.id, warm.id]));
  await waitFor(() => expect(screen.getByText(/Laser x does not answer/, { selector: 'li p' }).textContent).toContain('seen by Anna'));
  expect(screen.getByRole('button', { name: /Acknowledge: Laser y/ })).toBeTruthy();
});

it('acknowledges nothing without the second press', async () => {
  go('/now');
  render(<Shell />);
  await screen.findByText('Live');
  fireEvent.click(await screen.findByRole('button', { name: 'Acknowledge all…' }));
  fireEvent.click(await screen.findByRole('button', { name: 'Not yet' }));
  await waitFor(() => expect(screen.queryByText('Acknowledge 3 alarms?')).toBeNull());
  expect(acknowledged).toEqual([]);
});

it('lists what follows from an alarm under it', async () => {
  go('/now');
  render(<Shell />);
  await screen.findByText('Live');
  await screen.findByRole('button', { name: 'Acknowledge all…' }); // the list is there
  arrives({ ...lost, consequences: ['Run 17 waits: laser-x.'] });
  const line = (await screen.findByText('hence: Run 17 waits: laser-x.')).closest('.alarm')!;
  expect(line.textContent).toContain(lost.message);
});

it('keeps a shelved alarm out of the title and offers to bring it back', async () => {
  const shelved = { ...lost, shelvedUntilTime: at(7200), shelvedBy: 'ada', shelveReason: 'the laser is being aligned' };
  expect(pageTitle('Now', [late, shelved])).toBe('▲ Warning: Scanner answered late. – Now – Driftwise');
  go('/now');
  render(<Shell />);
  await screen.findByText('Live');
  await screen.findByRole('button', { name: `Shelve: ${lost.message}` });
  arrives(shelved);
  expect(await screen.findByRole('button', { name: `Bring back: ${lost.message}` })).toBeTruthy();
  expect(screen.getByText(/shelved by ada until .*: the laser is being aligned/)).toBeTruthy();
});

it('shelves with a time and a reason, and not without one', async () => {
  go('/now');
  render(<Shell />);
  await screen.findByText('Live');
  fireEvent.click(await screen.findByRole('button', { name: `Shelve: ${late.message}` }));
  const shelve = screen.getByRole('button', { name: 'Shelve' });
  expect(shelve.getAttribute('aria-disabled')).toBe('true');
  fireEvent.input(screen.getByLabelText('Reason'), { target: { value: 'being cleaned' } });
  fireEvent.input(screen.getByLabelText('Shelve for, h'), { target: { value: '25' } });
  expect(shelve.getAttribute('aria-disabled')).toBe('true');
  fireEvent.input(screen.getByLabelText('Shelve for, h'), { target: { value: '1.5' } });
  await waitFor(() => expect(shelve.getAttribute('aria-disabled')).toBeNull());
});

it('hands a new alarm to sound and notification once, and none that is shelved', async () => {
  go('/now');
  render(<Shell />);
  await screen.findByText('Live');
  await screen.findByText(/Laser x does not answer/, { selector: 'li p' }); // the list is there
  const fresh = alarm(9n, Alarm_Level.FAILED, 'Laser z does not answer.');
  arrives(fresh);
  await waitFor(() => expect(arrived.value.at(-1)?.id).toBe(9n));
  arrives({ ...alarm(10n, Alarm_Level.FAILED, 'Axis is away.'), shelvedUntilTime: at(7200) });
  fireEvent.click(await screen.findByRole('button', { name: /more that are over or shelved/ }));
  await screen.findByText(/Axis is away/, { selector: 'li p' });
  expect(arrived.value.at(-1)?.id).toBe(9n);
});

it('notifies of each alarm of one batch, says all of them, and sounds the worst', async () => {
  const shown: string[] = [];
  vi.stubGlobal('Notification', Object.assign(function (this: unknown, _title: string, options: NotificationOptions) {
    shown.push(options.body ?? '');
  }, { requestPermission: async () => 'granted' }));
  let tones = 0;
  const part = { connect: () => part, start: () => void tones++, stop: () => undefined, frequency: {}, gain: { setValueAtTime: () => undefined, linearRampToValueAtTime: () => undefined } };
  vi.stubGlobal('AudioContext', class {
    currentTime = 0;
    resume = async () => undefined;
    createOscillator = () => part;
    createGain = () => part;
  });
  await switchNotices(true);
  await switchSound(true);
  go('/now');
  render(<Shell />);
  await screen.findByText('Live');
  await screen.findByText(/Laser x does not answer/, { selector: 'li p' }); // the list is there
  batch(() => {
    arrives({ ...alarm(31n, Alarm_Level.FAILED, 'Axis q1 is lost.'), priority: Alarm_Priority.CRITICAL });
    arrives({ ...alarm(32n, Alarm_Level.FAILED, 'The room is warm.'), priority: Alarm_Priority.LOW });
  });
  await waitFor(() => expect(shown).toEqual(['Axis q1 is lost.', 'The room is warm.']));
  expect(document.querySelector('[aria-live=polite]')!.textContent).toBe('Failed: Axis q1 is lost. Failed: The room is warm.');
  expect(tones).toBe(2 * (Alarm_Priority.CRITICAL - Alarm_Priority.LOW));
  await switchSound(false);
  await switchNotices(false);
  vi.unstubAllGlobals();
});

it('says so where the browser has the permission and no notifications', async () => {
  vi.stubGlobal('Notification', Object.assign(function () {
    throw new TypeError('Illegal constructor');
  }, { requestPermission: async () => 'granted' }));
  await switchNotices(true);
  arrived.value = [alarm(41n, Alarm_Level.FAILED, 'Axis q1 is lost.')];
  expect(notices.value).toBe(false);
  expect(noticesRefused.value).toBe('This browser shows no notifications of a page.');
  vi.unstubAllGlobals();
});

it('hands over an alarm that becomes worse, and one whose shelf ended', async () => {
  go('/now');
  render(<Shell />);
  await screen.findByText('Live');
  await screen.findByText(/Scanner answered late/, { selector: 'li p' }); // the list is there
  const told = async (one: Alarm) => {
    arrives(one);
    await waitFor(() => expect(arrived.value.at(-1)?.message).toBe(one.message));
  };
  const silent = async (one: Alarm) => {
    const before = arrived.value;
    arrives(one);
    await waitFor(() => expect(standing.value?.value?.map((each) => each.message)).toContain(one.message));
    expect(arrived.value).toBe(before);
  };
  await told(alarm(20n, Alarm_Level.WARNING, 'Laser y is dim.'));
  await silent(alarm(20n, Alarm_Level.WARNING, 'Laser y is still dim.'));
  await told(alarm(20n, Alarm_Level.FAILED, 'Laser y is dark.'));
  await silent({ ...alarm(20n, Alarm_Level.FAILED, 'Laser y is dark, shelved.'), shelvedUntilTime: at(7200) });
  await told(alarm(20n, Alarm_Level.FAILED, 'Laser y is dark again.'));
  await silent({ ...alarm(20n, Alarm_Level.FAILED, 'Laser y is dark, seen.'), acknowledgeTime: at(3), acknowledgedBy: 'Anna' });
});

it('has the switches of sound and notifications while nothing is wrong, and among the settings', async () => {
  standing.value = { value: [], waiting: false, again: () => undefined, set: () => undefined };
  render(<AlarmList />);
  expect(screen.getByRole('button', { name: 'Alarm sound: off' })).toBeTruthy();
  cleanup();
  go('/record');
  render(<Shell />);
  helpOpen.value = true;
  expect(await screen.findByRole('button', { name: 'Alarm sound: off' })).toBeTruthy();
  expect(screen.getByRole('button', { name: 'Browser notifications: off' })).toBeTruthy();
  helpOpen.value = false;
});
