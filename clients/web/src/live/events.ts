// Records as they come over the stream: runs, points, attempts, events, alarms, models, diagnoses. They arrive once, in
// order, whole and with their ids; after a break they are replayed. States (values, cell) are signals in state.ts.
import { useEffect, useRef } from 'preact/hooks';
import type { WatchEvent } from '@/api/gen/driftwise/v1/watch_service_pb';

type Cases = Exclude<WatchEvent['event'], { case: undefined }>;
export type EventKind = Cases['case'];
export type EventOf<K extends EventKind> = Extract<Cases, { case: K }>['value'];

type Listener = (value: never, whole: WatchEvent) => void;
const listeners = new Map<EventKind, Set<Listener>>();

export function onEvents<K extends EventKind>(kind: K, listener: (value: EventOf<K>, whole: WatchEvent) => void): () => void {
  const of = listeners.get(kind) ?? new Set();
  listeners.set(kind, of.add(listener as Listener));
  return () => of.delete(listener as Listener);
}

export function announce(event: WatchEvent): void {
  if (event.event.case === undefined) return;
  for (const listener of listeners.get(event.event.case) ?? [])
    try {
      listener(event.event.value as never, event);
    } catch (error) { // one listener's fault ends neither the stream nor what the others hear
      console.error(error);
    }
}

// The same in a component, for as long as it is on the page.
export function useEvents<K extends EventKind>(kind: K, listener: (value: EventOf<K>, whole: WatchEvent) => void): void {
  const latest = useRef(listener);
  latest.current = listener;
  useEffect(() => onEvents(kind, (value, whole) => latest.current(value, whole)), [kind]);
}
