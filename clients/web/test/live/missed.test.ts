// A follower that misses batches of the leader reads them from its own cursor, by a stream that ends where the two meet.
import { create } from '@bufbuild/protobuf';
import { createRouterTransport } from '@connectrpc/connect';
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { WatchResponseSchema, WatchService, type WatchResponse } from '@/api/gen/driftwise/v1/watch_service_pb';
import { onEvents } from '@/live/events';
import { cell } from '@/live/state';
import { startStream } from '@/live/stream';
import type { TabMessage } from '@/live/tabs';
import { at, fakeBatch, fakeStatus } from '../fake/cell';

// The leader is another tab: the test speaks for it.
type Listening = { onmessage?: (event: { data: TabMessage }) => void };
let follower: Listening;
const said: TabMessage[] = [];
const tell = (message: TabMessage) => follower.onmessage!({ data: message });

const ids: bigint[] = [];
const batchOf = (cursor: string, ...points: bigint[]): WatchResponse =>
  create(WatchResponseSchema, { cursor, serverTime: at(1), cellTime: at(1), events: points.map((id) => ({ event: { case: 'point' as const, value: { id, runId: 17n } } })) });

let asked: string[];
let open: number;
let ends: (() => void)[];
beforeEach(() => {
  vi.stubGlobal('BroadcastChannel', class implements Listening {
    onmessage?: Listening['onmessage'];
    constructor() {
      follower = this;
    }
    postMessage = (message: TabMessage) => said.push(message);
    close() {}
  });
  vi.stubGlobal('navigator', { locks: { request: () => new Promise(() => undefined) } });
  vi.spyOn(document, 'hidden', 'get').mockReturnValue(true); // batches are taken as they come
  [asked, open, ids.length] = [[], 0, 0];
  useTransport(createRouterTransport(({ service }) => service(WatchService, {
    watch: async function* ({ cursor }, { signal }) {
      asked.push(cursor);
      open++;
      yield batchOf('c:4', 3n, 4n);
      await new Promise((done) => signal.addEventListener('abort', done));
      open--;
    },
  })));
  ends = [startStream(), onEvents('point', (point) => ids.push(point.id))];
});
afterEach(() => {
  ends.forEach((end) => end());
  vi.restoreAllMocks();
  vi.unstubAllGlobals();
});

it('takes each record once, whatever it slept through', async () => {
  const name = (said[0] as { from: string }).from;
  tell({ kind: 'state', to: name, batch: { ...create(WatchResponseSchema, fakeBatch(0)), cursor: 'c:1' } });
  expect(cell.value?.cellName).toBe(fakeStatus.cellName);
  tell({ kind: 'state', to: 'another', batch: batchOf('c:9', 9n) });
  tell({ kind: 'batch', after: 'c:1', batch: batchOf('c:2', 2n) });
  expect(ids).toEqual([2n]);
  tell({ kind: 'batch', after: 'c:3', batch: batchOf('c:4', 4n) }); // it slept while the leader brought 3
  expect(ids).toEqual([2n]);
  await vi.waitFor(() => expect(ids).toEqual([2n, 3n, 4n]));
  expect([asked, open]).toEqual([['c:2'], 1]);
  tell({ kind: 'batch', after: 'c:4', batch: batchOf('c:5', 5n) });
  expect(ids).toEqual([2n, 3n, 4n, 5n]);
  await vi.waitFor(() => expect(open).toBe(0));
  tell({ kind: 'batch', after: 'c:5', batch: batchOf('c:6', 6n) });
  expect(ids.at(-1)).toBe(6n);
  expect(asked).toHaveLength(1);
});
