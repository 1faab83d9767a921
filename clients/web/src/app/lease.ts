// The lease to move, for as long as one action takes: taken, used, given back, whatever came of it. Refused with
// PERMISSION_DENIED while somebody else holds it; the daemon's sentence says who.
import { Code, ConnectError } from '@connectrpc/connect';
import { api } from '@/api/client';
import { cell } from '@/live/state';

const tooLateMs = 5000; // as server/rpc/shared/heard.h has it of the command itself

// handOver: what was started goes on with the lease and renews it itself (the improve loop), so it is given back only when
// nothing was started.
export async function withLease<T>(act: (token: string) => Promise<T>, handOver = false): Promise<T> {
  // A minute on the wall; a fast simulated cell counts in its own time, and no lease is longer than its hour.
  const seconds = Math.min(3600, Math.max(1, Math.round(60 * (cell.value?.speed || 1))));
  const askedAt = performance.now();
  const { lease } = await api.cell().takeLease({ leaseDuration: { seconds: BigInt(seconds), nanos: 0 } });
  const token = lease?.token ?? '';
  const giveBack = () => void api.cell().giveUpLease({ token }).catch(() => undefined); // it runs out by itself
  try {
    if (performance.now() - askedAt > tooLateMs)
      throw new ConnectError('The daemon took more than 5 s to hand over the lease, so nothing was started. Look at the machine and ask again', Code.FailedPrecondition);
    const done = await act(token);
    if (!handOver) giveBack();
    return done;
  } catch (error) {
    giveBack();
    throw error;
  }
}
