// The lease to move, for as long as one action takes: taken, used, given back, whatever came of it. Refused with
// PERMISSION_DENIED while somebody else holds it; the daemon's sentence says who.
import { api } from '@/api/client';
import { cell } from '@/live/state';

export async function withLease<T>(act: (token: string) => Promise<T>): Promise<T> {
  // A minute on the wall; a fast simulated cell counts in its own time, and no lease is longer than its hour.
  const seconds = Math.min(3600, Math.max(1, Math.round(60 * (cell.value?.speed || 1))));
  const { lease } = await api.cell().takeLease({ leaseDuration: { seconds: BigInt(seconds), nanos: 0 } });
  const token = lease?.token ?? '';
  try {
    return await act(token);
  } finally {
    api.cell().giveUpLease({ token }).catch(() => undefined); // it runs out by itself
  }
}
