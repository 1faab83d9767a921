// Runs, newest first: the newest page, those that are wanted by their number, and older ones page by page when asked.
import { useEffect, useRef, useState } from 'preact/hooks';
import { api } from '@/api/client';
import type { Run } from '@/api/gen/driftwise/v1/run_pb';
import { useEvents } from '@/live/events';
import { useAsked, type Asked } from '@/ui/use_asked';

const pageSize = 200;

interface Pages {
  runs: Run[];
  from: bigint; // all runs from this number on are here
  isAll: boolean;
}

const newestFirst = (runs: readonly Run[]) => [...new Map(runs.map((run) => [run.id, run])).values()].sort((a, b) => (a.id < b.id ? 1 : -1));

async function pageBefore(beforeRunId: bigint, signal?: AbortSignal): Promise<Pages> {
  const { runs } = await api.run().listRuns({ limit: pageSize, beforeRunId }, signal && { signal });
  return { runs, from: runs[runs.length - 1]?.id ?? 0n, isAll: runs.length < pageSize };
}

export interface Runs extends Omit<Asked<Run[]>, 'set'> {
  isAll: boolean; // there are no older ones
  newest: Run | undefined; // of the first answer that had one with points: news do not change what a form is about
  older: () => Promise<void>;
  asking: boolean; // for older ones
}

export function useRuns(wanted: readonly string[] = []): Runs {
  const asked = useAsked('runs', (signal) => pageBefore(0n, signal));
  const [asking, setAsking] = useState(false);
  const add = (runs: readonly Run[]) => asked.set((old) => ({ ...old, runs: newestFirst([...old.runs, ...runs]) }));
  useEvents('run', (run) => add([run]));
  useEvents('progress', ({ run }) => run && asked.set((old) => (old.runs.some((one) => one.id === run.id) ? { ...old, runs: newestFirst([...old.runs, run]) } : old)));
  const known = asked.value;
  const missing = known ? wanted.filter((id) => /^\d+$/.test(id) && !known.runs.some((one) => String(one.id) === id)) : [];
  const tried = useRef(new Set<string>());
  useEffect(() => {
    for (const runId of missing) {
      if (tried.current.has(runId)) continue;
      tried.current.add(runId);
      api.run().getRun({ runId: BigInt(runId) }).then(({ run }) => run && add([run]), () => undefined);
    }
  }, [missing.join()]);
  const first = useRef<Run | undefined>(undefined);
  first.current ??= known?.runs.find((run) => run.acceptedCount > 0n);
  const older = async () => {
    if (asking || !known) return;
    setAsking(true);
    try {
      const page = await pageBefore(known.from);
      asked.set((old) => ({ ...page, runs: newestFirst([...old.runs, ...page.runs]), from: page.isAll ? 0n : page.from }));
    } catch {
      asked.again(); // says why
    } finally {
      setAsking(false);
    }
  };
  const { value: _, set: __, ...rest } = asked;
  return { ...rest, ...(known && { value: known.runs }), isAll: known?.isAll ?? false, newest: first.current, older, asking };
}
