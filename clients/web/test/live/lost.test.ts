// Since when the page is not live: by the clock that the bar shows, whatever this computer's says.
import { create } from '@bufbuild/protobuf';
import { createRouterTransport } from '@connectrpc/connect';
import { afterEach, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { WatchResponseSchema, WatchService } from '@/api/gen/driftwise/v1/watch_service_pb';
import { connection } from '@/live/connection';
import { startStream } from '@/live/stream';
import { at, fakeBatch, fakeStatus } from '../fake/cell';
import { ms } from '@/format/time';

afterEach(() => {
  vi.restoreAllMocks();
});

it.each([['the daemon', 1, at(1)], ['a fast cell', 60, at(30)]])('is by the clock of %s', async (_, speed, since) => {
  vi.spyOn(document, 'hidden', 'get').mockReturnValue(true); // batches are taken as they come
  useTransport(createRouterTransport(({ service }) => service(WatchService, {
    watch: async function* (_request, { signal }) {
      const events = [...fakeBatch(0).events!, { event: { case: 'cell' as const, value: { ...fakeStatus, speed } } }];
      yield create(WatchResponseSchema, { cursor: 'c:1', serverTime: at(1), cellTime: at(30), events });
      await new Promise((done) => signal.addEventListener('abort', done));
    },
  })));
  const end = startStream();
  await vi.waitFor(() => expect(connection.value.phase).toBe('live'));
  const now = performance.now();
  vi.spyOn(performance, 'now').mockReturnValue(now + 10_000);
  await vi.waitFor(() => expect(connection.value).toEqual({ phase: 'lost', lastMs: ms(since) }), { timeout: 5000 });
  end();
});
