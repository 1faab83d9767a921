// The target of a pose, asked again every second while the page is looked at: temperatures move, and with them the
// target. By single calls, not by a stream of its own: a browser has six connections to one place over all its tabs.
import { useEffect, useRef, useState } from 'preact/hooks';
import { api } from '@/api/client';
import { failureOf, wasCancelled, type Failure } from '@/api/errors';
import type { Target } from '@/api/gen/driftwise/v1/target_service_pb';
import { ms } from '@/format/time';
import type { Pose } from './pose';

export interface HistoryRow {
  atMs: number; // cell time of the conditions
  correctionNm: readonly number[]; // per coordinate; NaN: has none
}

export interface TargetState {
  target?: Target;
  failure?: Failure;
  history: readonly HistoryRow[]; // oldest first, at most an hour of cell time, of this pose only
}

const everyMs = 1000;
const hourMs = 3_600_000;

export function useTarget(pose: Pose): TargetState {
  const key = pose.map((one) => `${one.channel}=${one.value}`).join(' ');
  const [state, setState] = useState<TargetState & { key: string }>({ key, history: [] });
  const latest = useRef(pose);
  latest.current = pose;
  useEffect(() => {
    const abort = new AbortController();
    let timer: ReturnType<typeof setTimeout>;
    const ask = async () => {
      if (!document.hidden) {
        try {
          const { target } = await api.target().computeTarget({ pose: [...latest.current], withBudget: true }, { signal: abort.signal });
          if (target && !abort.signal.aborted) setState((old) => taken(old.key === key ? old.history : [], target, key));
        } catch (error) {
          if (abort.signal.aborted || wasCancelled(error)) return;
          setState((old) => ({ key, failure: failureOf(error), history: old.key === key ? old.history : [] }));
        }
      }
      if (!abort.signal.aborted) timer = setTimeout(ask, everyMs);
    };
    void ask();
    return () => {
      clearTimeout(timer);
      abort.abort();
    };
  }, [key]);
  return state.key === key ? state : { history: [] };
}

function taken(history: readonly HistoryRow[], target: Target, key: string) {
  const atMs = ms(target.conditionsTime) ?? 0;
  const row = { atMs, correctionNm: target.coordinates.map((one) => one.correctionNm ?? NaN) };
  const last = history.at(-1);
  const kept = last && last.atMs >= atMs ? history : [...history.filter((one) => one.atMs > atMs - hourMs), row];
  return { key, target, history: kept };
}
