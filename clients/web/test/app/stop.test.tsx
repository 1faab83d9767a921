// Stop: its own way to the daemon, and what each press does.
import { configure, fireEvent, render, screen, waitFor } from '@testing-library/preact';
import { Code, ConnectError, createRouterTransport } from '@connectrpc/connect';
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { stopFetch, useTransport } from '@/api/client';
import { CellService } from '@/api/gen/driftwise/v1/cell_service_pb';
import { setOperatorName } from '@/app/session';
import { StopButton } from '@/app/stop';

vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });

class Socket {
  static all: Socket[] = [];
  binaryType = '';
  closed = false;
  onopen?: () => void;
  onclose?: () => void;
  onmessage?: (event: { data: ArrayBuffer }) => void;
  constructor(readonly url: string) {
    Socket.all.push(this);
  }
  close() {
    this.closed = true;
    this.onclose?.();
  }
}

const address = 'https://cell.example:8443/driftwise.v1.CellService/StopAll';
const posted = vi.fn(async () => new Response('by post'));

beforeEach(() => {
  Socket.all = [];
  posted.mockClear();
  vi.stubGlobal('WebSocket', Socket);
  vi.stubGlobal('fetch', posted);
  setOperatorName('');
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

it('goes by a WebSocket of its own, with the name of who stops', async () => {
  setOperatorName('Žofie>?');
  const answer = stopFetch(address, {});
  const socket = Socket.all[0];
  const name = new URL(socket.url).searchParams.get('operator')!;
  expect(socket.url).toMatch(/^wss:\/\/cell\.example:8443\/driftwise\.v1\.CellService\/StopAll\?operator=[\w-]+$/);
  expect(new TextDecoder().decode(Uint8Array.from(atob(name.replace(/-/g, '+').replace(/_/g, '/')), (one) => one.charCodeAt(0)))).toBe('Žofie>?');
  socket.onopen!();
  socket.onmessage!({ data: new Uint8Array([1, 2]).buffer });
  socket.onclose!();
  expect([...new Uint8Array(await (await answer).arrayBuffer())]).toEqual([1, 2]);
  expect(posted).not.toHaveBeenCalled();
});
it('goes by an ordinary call as well where no WebSocket opens within a second', async () => {
  vi.useFakeTimers();
  const answer = stopFetch(address, {});
  vi.advanceTimersByTime(1000);
  expect(await (await answer).text()).toBe('by post');
  Socket.all[0].onclose!();
  expect(posted).toHaveBeenCalledTimes(1);
});
it('goes by an ordinary call at once where the WebSocket is refused', async () => {
  const answer = stopFetch(address, {});
  Socket.all[0].onclose!();
  expect(await (await answer).text()).toBe('by post');
});

const press = (button: HTMLElement) => fireEvent(button, new MouseEvent('pointerdown', { button: 0, bubbles: true }));

// Stops that reach the daemon; each waits until it is let go, or given up.
function daemon() {
  const stops: { signal: AbortSignal; go: () => void }[] = [];
  useTransport(createRouterTransport(({ service }) => service(CellService, {
    stopAll: (_, { signal }) => new Promise((done, failed) => {
      stops.push({ signal, go: () => done({ confirmed: true, message: '' } as never) });
      signal.addEventListener('abort', () => failed(new ConnectError('given up', Code.Canceled)));
    }),
  })));
  return stops;
}

it('sends a stop for every press, and gives up one that hangs', async () => {
  const clock = vi.spyOn(performance, 'now').mockReturnValue(0);
  const stops = daemon();
  render(<StopButton />);
  const button = screen.getByRole('button');
  press(button);
  clock.mockReturnValue(300);
  press(button);
  await waitFor(() => expect(stops).toHaveLength(2));
  expect(stops.map(({ signal }) => signal.aborted)).toEqual([false, false]);
  clock.mockReturnValue(1200);
  press(button);
  await waitFor(() => expect(stops).toHaveLength(3));
  expect(stops.map(({ signal }) => signal.aborted)).toEqual([true, false, false]);
  stops[2].go();
  await screen.findAllByText('Axes halted');
  stops[1].go();
  clock.mockRestore();
});
it('stops once by Space, which clicks again when it is let go', async () => {
  const stops = daemon();
  render(<StopButton />);
  const button = screen.getByRole('button');
  expect(fireEvent.keyDown(button, { key: ' ' })).toBe(false); // the browser's own press is off
  expect(fireEvent.keyUp(button, { key: ' ' })).toBe(false);
  await waitFor(() => expect(stops).toHaveLength(1));
  stops[0].go();
  await screen.findAllByText('Axes halted');
});
