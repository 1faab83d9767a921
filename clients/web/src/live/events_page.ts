// The record backwards: the daemon lists events forwards from an id, and people read them from the end.
import { api } from '@/api/client';
import type { Event } from '@/api/gen/driftwise/v1/cell_service_pb';

const pageSize = 1000;

const eventsAfter = async (afterEventId: bigint, limit: number, signal: AbortSignal) =>
  (await api.cell().listEvents({ afterEventId, limit }, { signal })).events;

// Id of the newest event; 0n: none. Ids grow without big holes, so doubling and halving finds it in some twenty small questions.
export async function newestEventId(signal: AbortSignal): Promise<bigint> {
  const reaches = async (id: bigint) => (await eventsAfter(id, 1, signal))[0]?.id;
  let known = (await reaches(0n)) ?? 0n;
  if (known === 0n) return 0n;
  let step = 64n;
  let beyond: bigint | undefined;
  while (beyond === undefined) {
    const found = await reaches(known + step);
    if (found === undefined) beyond = known + step;
    else [known, step] = [found, step * 4n];
  }
  while (beyond - known > 1n) {
    const middle: bigint = (known + beyond) / 2n;
    const found = await reaches(middle);
    if (found === undefined) beyond = middle;
    else known = found;
  }
  const last = await reaches(known);
  return last ?? known;
}

// Up to a page of events before an id (all before the newest: pass newest + 1), oldest first.
export async function eventsBefore(id: bigint, signal: AbortSignal): Promise<Event[]> {
  const after = id - BigInt(pageSize) - 1n;
  const events = await eventsAfter(after > 0n ? after : 0n, pageSize, signal);
  return events.filter((event) => event.id < id);
}

// Of one run, oldest first. They lie together, from about when it was created.
export async function eventsOfRun(runId: bigint, signal: AbortSignal): Promise<Event[]> {
  const found: Event[] = [];
  for (let after = 0n; ; ) {
    const page = await eventsAfter(after, pageSize, signal);
    found.push(...page.filter((event) => event.runId === runId));
    if (page.length < pageSize) return found;
    after = page[page.length - 1].id;
  }
}
