import { createRouterTransport } from '@connectrpc/connect';
import { beforeEach, expect, it } from 'vitest';
import { useTransport } from '@/api/client';
import { CellService } from '@/api/gen/driftwise/v1/cell_service_pb';
import { withLease } from '@/app/lease';

const calls: string[] = [];
beforeEach(() => {
  calls.length = 0;
  useTransport(createRouterTransport(({ service }) => {
    service(CellService, {
      takeLease: () => (calls.push('take'), { lease: { token: 'one' } }),
      giveUpLease: ({ token }) => (calls.push(`give up ${token}`), {}),
    });
  }));
});
const settled = () => new Promise((later) => setTimeout(later, 20));

it('the lease is given back when the action is over', async () => {
  expect(await withLease(async (token) => token)).toBe('one');
  await settled();
  expect(calls).toEqual(['take', 'give up one']);
});

it('what goes on with it keeps it, as the improve loop does', async () => {
  await withLease(async () => undefined, true);
  await settled();
  expect(calls).toEqual(['take']);
});

it('whoever failed to start anything gives it back', async () => {
  await expect(withLease(() => Promise.reject(new Error('no')), true)).rejects.toThrow('no');
  await settled();
  expect(calls).toEqual(['take', 'give up one']);
});
