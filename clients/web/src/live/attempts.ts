// Keeps one stream open for as long as it is wanted: after a break again in 0.2, 0.5, 1, 2, 5 s, a little by chance, and at
// once when the browser says that it is online; always from the cursor of the last batch.
import { Code, ConnectError } from '@connectrpc/connect';
import { api } from '@/api/client';
import { sessionLost } from '@/app/session';
import type { WatchResponse } from '@/api/gen/driftwise/v1/watch_service_pb';

const waitsMs = [200, 500, 1000, 2000, 5000];
const silenceMs = 3000; // three heartbeats: the connection is taken for dead

export interface StreamListener {
  cursor: () => string; // where to go on; '' starts with the present state
  batch: (batch: WatchResponse) => void;
  afresh: () => void; // the cursor is too old or of another database: what was loaded must be loaded again
}

function pause(forMs: number, signal: AbortSignal): Promise<void> {
  return new Promise((done) => {
    const end = () => {
      clearTimeout(timer);
      removeEventListener('online', end);
      signal.removeEventListener('abort', end);
      done();
    };
    const timer = setTimeout(end, forMs);
    addEventListener('online', end);
    signal.addEventListener('abort', end);
  });
}

async function once(listener: StreamListener, signal: AbortSignal): Promise<void> {
  const attempt = new AbortController();
  const end = () => attempt.abort();
  signal.addEventListener('abort', end);
  let watchdog = setTimeout(end, silenceMs);
  try {
    const request = { cursor: listener.cursor(), topics: [], maxHz: 20 };
    for await (const batch of api.watch().watch(request, { signal: attempt.signal })) {
      clearTimeout(watchdog);
      if (signal.aborted) return;
      watchdog = setTimeout(end, silenceMs);
      listener.batch(batch);
    }
  } finally {
    clearTimeout(watchdog);
    signal.removeEventListener('abort', end);
    attempt.abort();
  }
}

export async function keepStreaming(listener: StreamListener, signal: AbortSignal): Promise<void> {
  let failures = 0;
  const counting = { ...listener, batch: (batch: WatchResponse) => ((failures = 0), listener.batch(batch)) };
  while (!signal.aborted) {
    try {
      await once(counting, signal);
    } catch (error) {
      const { code } = ConnectError.from(error);
      if (code === Code.OutOfRange) listener.afresh(), (failures = 0); // what is asked anew waits for the stream, not for long
      if (code === Code.Unauthenticated) void sessionLost();
    }
    if (signal.aborted) return;
    const wait = waitsMs[Math.min(failures++, waitsMs.length - 1)];
    await pause(wait * (0.8 + 0.4 * Math.random()), signal);
  }
}
