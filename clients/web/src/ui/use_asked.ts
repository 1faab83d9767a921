// Asks the daemon for something and keeps the answer: old numbers stay while the next answer is awaited, unless the
// subject changed (another key, or the page loads afresh: another record may stand behind the daemon), when they go at once.
import { useCallback, useEffect, useRef, useState } from 'preact/hooks';
import { failureOf, wasCancelled, type Failure } from '@/api/errors';
import { connection } from '@/live/connection';
import { epoch } from '@/live/epoch';
import { streamBegun } from '@/live/ready';

export interface Asked<T> {
  value?: T;
  failure?: Failure;
  waiting: boolean;
  again: () => void;
  set: (change: (before: T) => T) => void; // merge what the stream says; may be applied twice, so it goes by ids
}

// question: everything that it depends on, as text; undefined asks nothing. Asks anew when the page loads afresh, and when it becomes
// live again after an answer that failed, or that was asked for meanwhile and is not there.
export function useAsked<T>(question: string | undefined, ask: (signal: AbortSignal) => Promise<T>): Asked<T> {
  const [state, setState] = useState<{ key?: string; value?: T; failure?: Failure; waiting: boolean }>({ waiting: true });
  const [turn, setTurn] = useState(0);
  const latest = useRef(ask);
  latest.current = ask;
  // Changes since the question was sent: its answer may be older than they are.
  const meanwhile = useRef<((before: T) => T)[] | undefined>(undefined);
  const key = question === undefined ? undefined : `${epoch.value} ${question}`;
  const live = connection.value.phase === 'live';
  const timesLive = useRef(0); // how often the page became live
  const failed = useRef(false);
  failed.current = state.failure !== undefined && !state.waiting;
  const hangs = useRef(false); // asked while the page was not live: perhaps on a connection that died, which brings no answer
  const refused = useRef(false); // and nothing is known: news of it mean that it is there by now
  refused.current = failed.current && state.value === undefined;
  const again = useCallback(() => {
    setState((old) => ({ ...old, waiting: true })); // at once: the effect that asks may come later than who asks again
    setTurn((n) => n + 1);
  }, []);
  useEffect(() => {
    if (!live) return;
    timesLive.current++;
    if (failed.current || hangs.current) again();
  }, [live]);
  useEffect(() => {
    meanwhile.current = undefined;
    hangs.current = false;
    if (key === undefined) {
      setState({ waiting: false });
      return;
    }
    const abort = new AbortController();
    const askedAt = timesLive.current;
    hangs.current = connection.peek().phase === 'lost';
    const changes: ((before: T) => T)[] = (meanwhile.current = []);
    setState((old) => (old.key === key ? { ...old, waiting: true } : { key, waiting: true }));
    streamBegun()
      .then(() => latest.current(abort.signal))
      .then(
        (value) => {
          if (abort.signal.aborted) return;
          meanwhile.current = undefined;
          hangs.current = false;
          setState({ key, value: changes.reduce((old, change) => change(old), value), waiting: false });
        },
        (error) => {
          if (abort.signal.aborted || wasCancelled(error)) return;
          meanwhile.current = undefined;
          hangs.current = false;
          setState((old) => ({ ...old, key, failure: failureOf(error), waiting: false }));
          if (timesLive.current !== askedAt || changes.length > 0) again(); // it was asked before the page became live, or before there was any
        },
      );
    return () => abort.abort();
  }, [key, turn]);
  const set = useCallback(
    (change: (before: T) => T) => {
      meanwhile.current?.push(change);
      setState((old) => (old.value === undefined ? old : { ...old, value: change(old.value) }));
      if (refused.current) again();
    },
    [],
  );
  const shown = state.key === key ? state : { waiting: key !== undefined };
  return { ...shown, again, set };
}
