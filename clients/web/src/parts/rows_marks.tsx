// Gives all plots of rows over time below it the stops and restarts of the runs they were measured in. Rows of a file have none.
import type { ComponentChildren } from 'preact';
import { api } from '@/api/client';
import type { Event } from '@/api/gen/driftwise/v1/cell_service_pb';
import { ms } from '@/format/time';
import { RowMarks } from '@/plot/marks';
import type { PlotMark } from '@/plot/spec';
import { useAsked } from '@/ui/use_asked';
import { marked } from './run_marks';
import { eventMarks } from './time_marks';

const mostRuns = 20; // the record is read once per run

async function ofRun(runId: bigint, signal: AbortSignal): Promise<{ firstMs: number; events: Event[] }> {
  const [{ run }, { points }] = await Promise.all([api.run().getRun({ runId }, { signal }), api.run().listPoints({ runId, limit: 1 }, { signal })]);
  return { firstMs: ms(points[0]?.measureTime) ?? Infinity, events: run?.startTime ? await marked(run, signal) : [] };
}

async function marksOf(runIds: readonly bigint[], signal: AbortSignal): Promise<PlotMark[]> {
  const runs = await Promise.all(runIds.map((id) => ofRun(id, signal)));
  const firstMs = Math.min(...runs.map((one) => one.firstMs)); // rows count their time from there
  if (!Number.isFinite(firstMs)) return [];
  const events = new Map(runs.flatMap((one) => one.events).map((event) => [event.id, event]));
  const happened = [...events.values()].map((event) => ({ atMs: ms(event.eventTime) ?? NaN, what: event.what, detail: event.detail }));
  return eventMarks(happened).map(({ atMs, ...mark }) => ({ ...mark, at: (atMs - firstMs) / 3600e3 }));
}

export function RowsMarks({ runIds, children }: { runIds: readonly bigint[]; children: ComponentChildren }) {
  const key = runIds.length > 0 && runIds.length <= mostRuns ? `marks of the rows of runs ${runIds.join()}` : undefined;
  const asked = useAsked(key, (signal) => marksOf(runIds, signal));
  return <RowMarks.Provider value={asked.value ?? none}>{children}</RowMarks.Provider>;
}

const none: readonly PlotMark[] = [];
