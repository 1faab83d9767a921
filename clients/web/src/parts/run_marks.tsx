// Gives all plots over time below it the marks of a run.
import type { ComponentChildren } from 'preact';
import { useContext, useMemo } from 'preact/hooks';
import { api } from '@/api/client';
import type { Event } from '@/api/gen/driftwise/v1/cell_service_pb';
import type { Run } from '@/api/gen/driftwise/v1/run_pb';
import { ms } from '@/format/time';
import { useEvents } from '@/live/events';
import { newestEventId } from '@/live/events_page';
import { usePointColumns, type RunPoints } from '@/live/points';
import { TimeMarks, type TimeMark } from '@/plot/marks';
import { useAsked } from '@/ui/use_asked';
import { eventMarks, forceSteps, isMarked } from './time_marks';
import { notesDuring } from './time_notes';

const pageSize = 1000;

// A stop and a start of the daemon are of the cell: they carry no run, only their time tells.
const concerns = (run: Run, event: Event): boolean => {
  const at = ms(event.eventTime) ?? NaN;
  if (!isMarked(event.what) || (event.runId !== undefined && event.runId !== run.id)) return false;
  return event.runId === run.id || (at >= (ms(run.startTime) ?? Infinity) && at <= (ms(run.endTime) ?? Infinity));
};

const page = async (afterEventId: bigint, limit: number, signal: AbortSignal): Promise<Event[]> =>
  (await api.cell().listEvents({ afterEventId, limit }, { signal })).events;

// Id before the first event of the run's time, to within a page: a long record is not read from its beginning.
async function before(run: Run, signal: AbortSignal): Promise<bigint> {
  const fromMs = ms(run.startTime) ?? Infinity;
  let [low, high] = [0n, await newestEventId(signal)];
  while (high - low > BigInt(pageSize)) {
    const middle = (low + high) / 2n;
    const [event] = await page(middle, 1, signal);
    if (event && (ms(event.eventTime) ?? NaN) < fromMs) low = middle;
    else high = middle;
  }
  return low;
}

export async function marked(run: Run, signal: AbortSignal): Promise<Event[]> {
  const first = await page(0n, pageSize, signal);
  if (first.length < pageSize) return first.filter((event) => concerns(run, event));
  const found: Event[] = [];
  for (let after = await before(run, signal); ; ) {
    const events = await page(after, pageSize, signal);
    found.push(...events.filter((event) => concerns(run, event)));
    const last = events[events.length - 1];
    if (events.length < pageSize || (ms(last.eventTime) ?? NaN) > (ms(run.endTime) ?? Infinity)) return found;
    after = last.id;
  }
}

// Those of the cell, and those of the run's time that are older.
function both(around: readonly TimeMark[], ofRun: readonly TimeMark[]): readonly TimeMark[] {
  const key = (mark: TimeMark) => `${mark.atMs} ${mark.label}`;
  const known = new Set(around.map(key));
  return [...around, ...ofRun.filter((mark) => !known.has(key(mark)))];
}

export function RunMarks({ run, points, children }: { run: Run | undefined; points: RunPoints | undefined; children: ComponentChildren }) {
  const events = useAsked(run && `marks of run ${run.id}`, (signal) => marked(run!, signal));
  useEvents('record', (event) => {
    if (run && concerns(run, event)) events.set((old) => (old.some((one) => one.id === event.id) ? old : [...old, event]));
  });
  const notes = useAsked(run && `remarks at the time of run ${run.id}`, (signal) => notesDuring(run!, signal));
  useEvents('record', (event) => void (event.what === 'note.pinned' && notes.again()));
  const around = useContext(TimeMarks);
  const columns = usePointColumns(points?.points, ms(run?.startTime));
  const marks = useMemo(() => [
    ...forceSteps(columns.of('force_N')).map(({ index, label }) => ({ kind: 'force' as const, label, atMs: columns.startMs + columns.hours[index] * 3600e3 })),
    ...eventMarks((events.value ?? []).map((event) => ({ atMs: ms(event.eventTime) ?? NaN, what: event.what, detail: event.detail }))),
    ...both(around, notes.value ?? []),
  ], [columns, events.value, notes.value, around]);
  return <TimeMarks.Provider value={marks}>{children}</TimeMarks.Provider>;
}
