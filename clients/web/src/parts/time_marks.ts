// Changes of force, stops, resumes and restarts of a run, from its points and the record.
import type { PlotMark } from '@/plot/spec';
import type { TimeMark } from '@/plot/marks';

export interface Happened {
  atMs: number;
  what: string; // as in the record: "run.pause"
  detail: string;
}

const kinds: Record<string, PlotMark['kind']> = {
  stop: 'stop', 'run.pause': 'stop', 'hold.begun': 'stop', 'run.resume': 'resume', 'run.resumed': 'resume', 'hold.ended': 'resume', 'run.restarted': 'restart', 'daemon.started': 'restart',
};
export const isMarked = (what: string): boolean => what in kinds;

export const eventMarks = (events: readonly Happened[]): TimeMark[] =>
  events.flatMap(({ atMs, what, detail }) => (isMarked(what) ? [{ atMs, kind: kinds[what], label: detail || what }] : []));

// A change is more than 2 % of the range and 5 mN: less is the noise of the load cell. Rows without a force are passed over.
export function forceSteps(force: ArrayLike<number>): { index: number; label: string }[] {
  const known = Array.from(force, (value, index) => ({ value, index })).filter(({ value }) => Number.isFinite(value));
  const values = known.map(({ value }) => value);
  const range = values.reduce((a, b) => Math.max(a, b), -Infinity) - values.reduce((a, b) => Math.min(a, b), Infinity);
  const least = Math.max(0.005, 0.02 * range);
  const text = (newton: number) => String(Number(newton.toFixed(3)));
  return known.flatMap(({ value, index }, i) =>
    i > 0 && Math.abs(value - known[i - 1].value) > least ? [{ index, label: `force ${text(known[i - 1].value)} to ${text(value)} N` }] : []);
}

export const forceMarks = (hours: ArrayLike<number>, force: ArrayLike<number>): PlotMark[] =>
  forceSteps(force).map(({ index, label }) => ({ at: hours[index], kind: 'force', label }));
