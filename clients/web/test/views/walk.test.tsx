// Defects found by a walk through the page.
import { cleanup, configure, fireEvent, render, screen, waitFor, within } from '@testing-library/preact';
import { create } from '@bufbuild/protobuf';
import { afterAll, beforeAll, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { DeviceSchema, GetStatusResponseSchema } from '@/api/gen/driftwise/v1/cell_service_pb';
import { Run_State, RunProgressSchema } from '@/api/gen/driftwise/v1/run_pb';
import { go } from '@/app/router';
import { Shell } from '@/app/shell';
import { startStream } from '@/live/stream';
import { FileInput } from '@/ui/file_input';
import { RunPanel } from '@/views/now/run_panel';
import { cell } from '@/live/state';
import { fakeNowMs, fakeRun, fakeStatus } from '../fake/cell';
import { fakeDaemon } from '../fake/daemon';
import { timestampOf } from '@/format/time';

vi.mock('@/plot/plot', () => ({ Plot: ({ spec }: { spec: { title: string; why?: string } }) => <figure>{spec.title}<figcaption>{spec.why}</figcaption></figure> }));
vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });

let endStream: () => void;
beforeAll(() => {
  vi.stubGlobal('scrollTo', () => undefined);
  useTransport(fakeDaemon());
  endStream = startStream();
});
afterAll(() => endStream());

it('offers no state that a run never has', async () => {
  go('/runs');
  render(<Shell />);
  const states = await screen.findByRole('option', { name: 'Waiting' });
  const offered = within(states.closest('select')!).getAllByRole('option').map((one) => one.textContent);
  expect(offered).toContain('Done');
  expect(offered).not.toContain('Queued');
});

it('shows a dropped file by its name, and no field beside it that says there is none', async () => {
  const got: string[] = [];
  const { rerender } = render(<FileInput label="Trajectory" accept=".csv" onFile={(file) => got.push(file.name)} mostBytes={1000} />);
  const field = screen.getByLabelText('Trajectory');
  expect(field.classList.contains('sr-only')).toBe(true); // a browser would write "No file chosen" here
  expect(screen.getByText('Choose a file…')).toBeTruthy();
  const file = Object.assign(new File(['x_mm\n1\n'], 'weekend.csv'), { arrayBuffer: async () => new ArrayBuffer(7) }); // jsdom has none
  fireEvent.drop(field.closest('.file-drop')!, { dataTransfer: { files: [file] } });
  await waitFor(() => expect(got).toEqual(['weekend.csv']));
  rerender(<FileInput label="Trajectory" accept=".csv" chosen="weekend.csv" onFile={() => undefined} mostBytes={1000} />);
  expect(screen.getByText('weekend.csv')).toBeTruthy();
  expect(screen.queryByText('or drop it here')).toBeNull();
});

it('says when a run that waits would be ready', async () => {
  go('/now');
  render(<Shell />);
  await screen.findByText('Live'); // cell time is known
  cleanup();
  const run = { ...fakeRun, state: Run_State.WAITING, reason: 'laser-x does not answer' };
  render(<RunPanel buttons={false} progress={create(RunProgressSchema, { run, phase: 'waiting', estimatedEndTime: timestampOf(fakeNowMs - 3600e3), remainingDuration: { seconds: 7200n, nanos: 0 } })} />);
  expect(screen.getByText('ready about, if it went on now')).toBeTruthy();
  expect(screen.getByText(/of measuring left/)).toBeTruthy();
  expect(screen.queryByText('estimated end passed')).toBeNull();
});

it('states the end of a run as a band', async () => {
  go('/now');
  render(<Shell />);
  await screen.findByText('Live');
  cleanup();
  const at = (hours: number) => timestampOf(fakeNowMs + hours * 3600e3);
  render(<RunPanel buttons={false} progress={create(RunProgressSchema, {
    run: fakeRun, phase: 'reading', estimatedEndTime: at(6), earliestEndTime: at(5), latestEndTime: at(8), remainingDuration: { seconds: 21600n, nanos: 0 },
    remainingBand: { lowDuration: { seconds: 18000n, nanos: 0 }, highDuration: { seconds: 28800n, nanos: 0 }, share: 0.8, runCount: 12n, rowCount: 4000n },
  })} />);
  expect(screen.getByText(/^80 %: ... \d\d:\d\d UTC to ... \d\d:\d\d UTC$/)).toBeTruthy();
});

it('shows two instruments of one coordinate, each by its own name, and their plots', async () => {
  go('/now');
  render(<Shell />);
  await screen.findByText('Live');
  cleanup();
  cell.value = create(GetStatusResponseSchema, {
    ...fakeStatus,
    devices: [
      ...fakeStatus.devices.map((one) => (one.id === 'laser-z' ? create(DeviceSchema, { ...one, kind: 'interferometer-adapter' }) : one)),
      create(DeviceSchema, { id: 'touch', kind: 'heidenhain-nd28x', lengthChannel: 'z_mm' }),
      create(DeviceSchema, { id: 'level', kind: 'meas-dpl', angleChannels: ['ma.rx_arcsec'] }),
    ],
  });
  go('/instruments');
  render(<Shell />);
  expect(await screen.findByRole('heading', { name: 'z interferometer' })).toBeTruthy();
  expect(screen.getByRole('heading', { name: 'z touch probe' })).toBeTruthy();
  expect(screen.getByRole('heading', { name: 'Inclinometer level' })).toBeTruthy();
  expect(await screen.findByText('No angle read yet')).toBeTruthy();
  await waitFor(() => expect(screen.queryByText('Waiting for the record …')).toBeNull());
  expect(screen.queryByText(/is named twice/)).toBeNull();
});
