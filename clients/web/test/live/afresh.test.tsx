// Another database behind the daemon (a backup put back): what the page knew of the old one is gone.
import { create } from '@bufbuild/protobuf';
import { Code, ConnectError, createRouterTransport } from '@connectrpc/connect';
import { expect, test, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { WatchResponseSchema, WatchService } from '@/api/gen/driftwise/v1/watch_service_pb';
import { epoch } from '@/live/epoch';
import { progress } from '@/live/state';
import { startStream } from '@/live/stream';
import { fakeBatch, fakeRun } from '../fake/cell';

vi.setConfig({ testTimeout: 60_000 }); // a busy machine

test('the run of the old database is not under way in the new one', async () => {
  const cursors: string[] = [];
  const seen: (bigint | undefined)[] = [];
  useTransport(createRouterTransport(({ service }) => service(WatchService, {
    watch: async function* ({ cursor }, { signal }) {
      cursors.push(cursor);
      const present = create(WatchResponseSchema, fakeBatch(0));
      if (cursors.length === 1) {
        yield { ...present, cursor: 'old:5' };
        return; // the daemon was stopped
      }
      seen.push(progress.value?.run?.id);
      if (cursor !== '') throw new ConnectError('the cursor is of no record of this database', Code.OutOfRange);
      while (!signal.aborted) {
        yield { ...present, cursor: 'new:1', events: present.events.filter((one) => one.event.case !== 'progress') };
        await new Promise((done) => setTimeout(done, 100));
      }
    },
  })));
  const end = startStream();
  await vi.waitFor(() => expect(cursors).toEqual(['', 'old:5', '']), { timeout: 50_000 });
  expect(seen).toEqual([fakeRun.id, undefined]);
  expect(epoch.value).toBe(1);
  await vi.waitFor(() => expect(progress.value).toBeUndefined());
  end();
});
