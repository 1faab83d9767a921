// The points and attempts of one run: what is in the record, and what comes while it is under way.
import { useMemo } from 'preact/hooks';
import { api } from '@/api/client';
import type { Attempt, Point } from '@/api/gen/driftwise/v1/run_pb';
import { ms } from '@/format/time';
import { useAsked, type Asked } from '@/ui/use_asked';
import { useEvents } from './events';

// Some 2 MB of 40 channels: each answer has its own time to arrive, also on a slow line.
const pageSize = 2000;

async function allPoints(runId: bigint, signal: AbortSignal): Promise<Point[]> {
  const points: Point[] = [];
  for (;;) {
    const afterPointId = points[points.length - 1]?.id ?? 0n;
    const answer = await api.run().listPoints({ runId, afterPointId, limit: pageSize }, { signal });
    points.push(...answer.points);
    if (answer.points.length < pageSize) return points;
  }
}

export interface RunPoints {
  points: Point[]; // oldest first
  passages: Point[]; // where the run came by beside its plan: in no plot and no figure
  attempts: Attempt[];
}

export function useRunPoints(runId: bigint | undefined): Asked<RunPoints> {
  const asked = useAsked(runId === undefined ? undefined : `points ${runId}`, async (signal): Promise<RunPoints> => {
    const [points, attempts] = await Promise.all([allPoints(runId!, signal), api.run().listAttempts({ runId: runId! }, { signal })]);
    return { points: points.filter((one) => !one.passage), passages: points.filter((one) => one.passage), attempts: attempts.attempts };
  });
  useEvents('point', (point) => {
    if (point.runId !== runId) return;
    const key = point.passage ? 'passages' : 'points';
    asked.set((old) => (old[key].some((one) => one.id === point.id) ? old : { ...old, [key]: [...old[key], point] }));
  });
  useEvents('attempt', (attempt, event) => {
    if (event.runId !== runId) return;
    const same = (one: Attempt) => one.row === attempt.row && one.number === attempt.number;
    asked.set((old) => ({ ...old, attempts: [...old.attempts.filter((one) => !same(one)), attempt] }));
  });
  return asked;
}

export const valueOf = (point: Point, channel: string): number => point.values.find((one) => one.channel === channel)?.value ?? NaN;

// Columns of the points as arrays, for plots: x in hours since the first point's run started.
export type PointColumns = ReturnType<typeof usePointColumns>;

export function usePointColumns(points: readonly Point[] | undefined, startMs: number | undefined) {
  return useMemo(() => {
    const all = points ?? [];
    const start = startMs ?? ms(all[0]?.measureTime) ?? 0;
    const channels = [...new Set(all.slice(0, 3).concat(all.slice(-1)).flatMap((point) => point.values.map((one) => one.channel)))];
    const hours = all.map((point) => ((ms(point.measureTime) ?? NaN) - start) / 3600e3);
    const columns = new Map<string, number[]>();
    const of = (channel: string): number[] => {
      const found = columns.get(channel) ?? all.map((point) => valueOf(point, channel));
      columns.set(channel, found);
      return found;
    };
    return { startMs: start, hours, channels, of };
  }, [points, startMs]);
}
