// The target of a pose, asked again every second while the page is looked at: temperatures move, and with them the
// target. By single calls, not by a stream of its own: a browser has six connections to one place over all its tabs. What it
// was in the hour before comes from the daemon, so that a page that was just opened has it.
import { useEffect, useRef, useState } from 'preact/hooks';
import { targetApi } from '@/api/target';
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
  history: readonly HistoryRow[]; // oldest first, at most an hour of cell time, of this pose, model and zero only
}

const everyMs = 1000;
const hourMs = 3_600_000;

// Model and zero that a correction is computed by, beside the pose: another one of them gives another correction.
export interface ComputedBy {
  modelId: bigint;
  datum: string; // changes when the model's constant does
}

// Of an empty pose nothing is asked.
export function useTarget(pose: Pose, { modelId, datum }: ComputedBy): TargetState {
  const key = pose.length === 0 ? '' : [modelId, datum, ...pose.map((one) => `${one.channel}=${one.value}`)].join(' ');
  const [state, setState] = useState<TargetState & { key: string }>({ key, history: [] });
  const latest = useRef(pose);
  latest.current = pose;
  useEffect(() => {
    if (key === '') return undefined;
    const abort = new AbortController();
    let timer: ReturnType<typeof setTimeout>;
    const ask = async () => {
      if (!document.hidden) {
        try {
          const { target } = await targetApi().computeTarget({ pose: [...latest.current], withBudget: true, showUnreachable: true }, { signal: abort.signal });
          if (target && !abort.signal.aborted) setState((old) => taken(old.key === key ? old.history : [], target, key, modelId));
        } catch (error) {
          if (abort.signal.aborted || wasCancelled(error)) return;
          setState((old) => ({ key, failure: failureOf(error), history: old.key === key ? old.history : [] }));
        }
      }
      if (!abort.signal.aborted) timer = setTimeout(ask, everyMs);
    };
    void ask();
    theHourBefore(latest.current, modelId, abort.signal).then(
      (before) => setState((old) => (old.key === key ? { ...old, history: joined(before, old.history) } : { key, history: before })),
      () => undefined, // the target itself says what is wrong; the picture then begins now
    );
    return () => {
      clearTimeout(timer);
      abort.abort();
    };
  }, [key]);
  return state.key === key ? state : { history: [] };
}

async function theHourBefore(pose: Pose, modelId: bigint, signal: AbortSignal): Promise<readonly HistoryRow[]> {
  const { times, tracks, modelId: by } = await targetApi().listPastTargets({ pose: [...pose] }, { signal });
  if (by !== modelId) return []; // another one began to serve: it is asked anew with that
  return times.map((time, i) => ({ atMs: ms(time) ?? 0, correctionNm: tracks.map((track) => track.correctionNm[i]) }));
}

// What was before goes before what was seen since.
const joined = (before: readonly HistoryRow[], since: readonly HistoryRow[]) => [...before.filter((row) => !since[0] || row.atMs < since[0].atMs), ...since];

function taken(history: readonly HistoryRow[], target: Target, key: string, modelId: bigint) {
  const atMs = ms(target.conditionsTime) ?? 0;
  const row = { atMs, correctionNm: target.coordinates.map((one) => one.correctionNm ?? NaN) };
  const last = history.at(-1);
  const kept = target.modelId !== modelId || (last && last.atMs >= atMs) ? history : [...history.filter((one) => one.atMs > atMs - hourMs), row];
  return { key, target, history: kept };
}
