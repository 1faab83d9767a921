// The shell and Now over the real stream client, before a daemon in memory.
import { configure, fireEvent, render, screen, waitFor, within } from '@testing-library/preact';
import { createRouterTransport, type Transport } from '@connectrpc/connect';
import { afterAll, beforeAll, beforeEach, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { CellService } from '@/api/gen/driftwise/v1/cell_service_pb';
import { WatchService } from '@/api/gen/driftwise/v1/watch_service_pb';
import { go } from '@/app/router';
import { setOperatorName } from '@/app/session';
import { Shell } from '@/app/shell';
import { connection } from '@/live/connection';
import { startStream } from '@/live/stream';
import { fakeDaemon } from '../fake/daemon';

vi.mock('@/plot/plot', () => ({ Plot: ({ spec }: { spec: { title: string } }) => <figure>{spec.title}</figure> }));

// Calls that reach the daemon, in order.
const calls: string[] = [];
function counting(inner: Transport): Transport {
  return {
    unary: (method, ...rest) => {
      calls.push(method.name);
      return inner.unary(method, ...rest);
    },
    stream: (method, ...rest) => inner.stream(method, ...rest),
  };
}

vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });

let endStream: () => void;
beforeAll(() => {
  vi.stubGlobal('scrollTo', () => undefined);
  useTransport(counting(fakeDaemon()));
  endStream = startStream();
});
afterAll(() => endStream());
beforeEach(() => {
  calls.length = 0;
  go('/now');
});

it('shows the run, the numbers with their units, and what is stale', async () => {
  render(<Shell />);
  await screen.findByText('Running');
  const spread = (await screen.findByText('Spread of last point')).closest('.tile')! as HTMLElement;
  expect(within(spread).getByText('3.8')).toBeTruthy();
  expect(within(spread).getByText('nm')).toBeTruthy();
  const tilt = (await screen.findByText('Autocollimator, ry')).closest('.tile')!;
  expect(tilt.classList.contains('stale')).toBe(true);
  expect(tilt.textContent).toContain('stale: 48 s old');
  await screen.findByText('Drift of the zero');
});

it('acknowledges one alarm by its own call, and says by whom', async () => {
  setOperatorName('Anna');
  render(<Shell />);
  await screen.findByText('Live');
  fireEvent.click(await screen.findByRole('button', { name: /Acknowledge: Autocollimator 1/ }));
  await screen.findByText(/seen by Anna/);
  expect(calls).toContain('AcknowledgeAlarm');
});

it('stops on press and asks nobody', async () => {
  setOperatorName('');
  render(<Shell />);
  const stop = screen.getByRole('button', { name: 'Stop motion' });
  fireEvent(stop, new MouseEvent('pointerdown', { button: 0, bubbles: true })); // jsdom's pointer events have no button
  fireEvent.click(stop, { detail: 1 });
  await screen.findAllByText('Axes halted');
  expect(calls.filter((name) => name === 'StopAll')).toEqual(['StopAll']);
});

it('asks for a name before the first command, and sends nothing without one', async () => {
  setOperatorName('');
  render(<Shell />);
  fireEvent.click(await screen.findByRole('button', { name: 'Pause' }));
  await screen.findByText('Who are you?');
  fireEvent.click(screen.getByRole('button', { name: 'Cancel' }));
  await waitFor(() => expect(screen.queryByText('Who are you?')).toBeNull());
  expect(calls).not.toContain('PauseRun');
});

it('gives no command while the page is not live, and says why; Stop stays', async () => {
  setOperatorName('Anna');
  render(<Shell />);
  const pause = await screen.findByRole('button', { name: 'Pause' });
  useTransport(createRouterTransport(({ service }) => {
    service(WatchService, {});
    service(CellService, {});
  }));
  connection.value = { phase: 'lost', lastMs: Date.UTC(2026, 0, 1, 10, 21, 7) };
  await waitFor(() => expect(pause.getAttribute('aria-disabled')).toBe('true'));
  expect(pause.getAttribute('title')).toMatch(/not live since/);
  expect(screen.getByText(/commands are off/)).toBeTruthy();
  fireEvent.click(pause);
  expect(calls).not.toContain('PauseRun');
  expect(screen.getByRole('button', { name: 'Stop motion' }).getAttribute('aria-disabled')).toBeNull();
});
