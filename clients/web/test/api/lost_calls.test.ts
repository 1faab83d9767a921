// Calls on a connection that died: no answer and no error ever comes, so the page ends them itself.
import { Code } from '@connectrpc/connect';
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { api } from '@/api/client';
import { failureOf, wasCancelled } from '@/api/errors';
import { connection } from '@/live/connection';

const sent: { url: string; signal: AbortSignal }[] = [];
const sockets: object[] = [];
beforeEach(() => {
  sent.length = sockets.length = 0;
  vi.stubGlobal('fetch', (url: string, init: RequestInit) => new Promise((_, failed) => {
    sent.push({ url, signal: init.signal! });
    init.signal!.addEventListener('abort', () => failed(init.signal!.reason));
  }));
  vi.stubGlobal('WebSocket', class {
    onopen?: () => void;
    constructor() {
      sockets.push(this);
      setTimeout(() => this.onopen?.());
    }
    close() {}
  });
  connection.value = { phase: 'live' };
});
afterEach(() => vi.unstubAllGlobals());

it('fail when the page is no longer live, as not answered; a stop goes on', async () => {
  let outcome: unknown;
  api.run().listRuns({}).catch((error) => (outcome = error));
  let stopped = 'under way';
  const given = new AbortController();
  api.cell().stopAll({}, { signal: given.signal }).then(() => (stopped = 'answered'), () => (stopped = 'failed'));
  await vi.waitFor(() => expect([sent.length, sockets.length]).toEqual([1, 1]));
  expect(sent[0].signal.aborted).toBe(false);
  connection.value = { phase: 'lost', lastMs: 0 };
  await vi.waitFor(() => expect(outcome).toBeDefined());
  expect([failureOf(outcome).code, failureOf(outcome).lost, wasCancelled(outcome)]).toEqual([Code.Unavailable, true, false]);
  expect(sent[0].signal.aborted).toBe(true);
  expect(stopped).toBe('under way');
  given.abort();
  await vi.waitFor(() => expect(stopped).toBe('failed'));
});

it('that begin while the page is not live are not ended by that', async () => {
  connection.value = { phase: 'lost', lastMs: 0 };
  const given = new AbortController();
  const call = api.run().listRuns({}, { signal: given.signal }).catch(() => undefined);
  await vi.waitFor(() => expect(sent).toHaveLength(1));
  expect(sent[0].signal.aborted).toBe(false);
  given.abort();
  await call;
});
