// Entries of the queue in words.
import { QueueEntry_State, type ListQueueResponse, type QueueEntry } from '@/api/gen/driftwise/v1/queue_service_pb';
import { Run_State, type MetadataItem, type Run } from '@/api/gen/driftwise/v1/run_pb';
import { dateClock, duration, ms, secondsOf } from '@/format/time';
import type { VerdictKind } from '@/ui/verdict';

export const entryWords: Record<QueueEntry_State, [VerdictKind, string]> = {
  [QueueEntry_State.UNSPECIFIED]: ['idle', 'Unknown'],
  [QueueEntry_State.WAITING]: ['idle', 'Waiting'],
  [QueueEntry_State.RUNNING]: ['good', 'Running'],
  [QueueEntry_State.FOLLOWING]: ['good', 'Run done, results follow'],
  [QueueEntry_State.DONE]: ['good', 'Done'],
  [QueueEntry_State.SET_ASIDE]: ['bad', 'Set aside'],
  [QueueEntry_State.REMOVED]: ['idle', 'Removed'],
};

export const isOverEntry = (entry: QueueEntry): boolean => entry.state === QueueEntry_State.DONE || entry.state === QueueEntry_State.REMOVED;

export const metadataText = (items: readonly MetadataItem[]): string => items.map((item) => `${item.key}=${item.value}`).join(', ');

// "sample=A12, tool=probe" -> items; undefined: something is no key=value.
export function metadataTyped(text: string): { key: string; value: string }[] | undefined {
  const parts = text.split(',').map((part) => part.trim()).filter(Boolean);
  const items = parts.map((part) => ({ key: part.slice(0, Math.max(0, part.indexOf('='))).trim(), value: part.slice(part.indexOf('=') + 1).trim() }));
  return items.every((item) => item.key !== '' && item.value !== '') ? items : undefined;
}

// What an entry may start after.
export interface Terms {
  notBeforeMs: number | undefined; // by the daemon's wall clock
  afterEntryId: bigint | undefined;
}

// Nothing that the page knows of holds an entry with these terms back, so that the robot may move as soon as it is in the queue.
// A condition is not among them: it may hold already, which only the daemon knows.
export function mayStartAtOnce(terms: Terms, queue: ListQueueResponse, run: Run | undefined, wallMs: number): boolean {
  if (queue.hold || (run && run.state < Run_State.DONE)) return false;
  if (queue.entries.some((entry) => entry.state === QueueEntry_State.RUNNING)) return false;
  if (terms.notBeforeMs !== undefined && terms.notBeforeMs > wallMs) return false;
  return terms.afterEntryId === undefined || !queue.entries.some((entry) => entry.id === terms.afterEntryId && !entry.accepted);
}

export const startWords = (condition: string): string =>
  condition === '' ? 'at once: the robot may move' : `as soon as ${condition}, which may be now: the robot may move`;

// What it waits for by its own terms, and what happens afterwards.
export function termsOf(entry: QueueEntry): string[] {
  const terms: string[] = [];
  if (entry.notBeforeTime) terms.push(`not before ${dateClock(ms(entry.notBeforeTime))}`);
  if (entry.afterEntryId !== undefined) terms.push(`after entry ${entry.afterEntryId}`);
  if (entry.condition) terms.push(`when ${entry.condition}`);
  if (entry.repeatDuration) terms.push(`every ${duration(secondsOf(entry.repeatDuration))}`);
  if (entry.setAsideOnFailure) terms.push('set aside on failure');
  return [...terms, ...entry.followUps.map((one) => `then ${one}`)];
}
