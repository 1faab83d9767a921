// Recorded channels over time of day, as a plot.
import { lastMidnight } from '@/format/time';
import { splitChannel, unitSign } from '@/format/units';
import { channel } from '@/live/channels';
import { usualStep, type History } from '@/live/history';
import type { Track } from '@/live/series';
import { lookOf } from '@/plot/many';
import type { PlotSeries, PlotSpec } from '@/plot/spec';

export function seriesOfTrack(track: Track, startMs: number, more: Partial<PlotSeries>, convert: (value: number) => number = (v) => v): PlotSeries {
  return {
    name: splitChannel(track.channel).symbol.replaceAll('_', ' '),
    unit: splitChannel(track.channel).unit,
    colour: 'q1',
    x: track.atMs.map((at) => (at - startMs) / 3600e3),
    y: track.mean.map(convert),
    ...(track.min && { min: track.min.map(convert) }),
    ...(track.max && { max: track.max.map(convert) }),
    ...more,
  };
}

// Time of day over the whole window of a history: a channel that fell silent leaves the rest of it empty.
export function timeOfDay({ fromMs, toMs }: History): PlotSpec['x'] & { startMs: number } {
  const startMs = lastMidnight(fromMs);
  const hours = (atMs: number) => (atMs - startMs) / 3600e3;
  return { label: 'time_h', unit: 'h', startMs, clock: true, low: hours(fromMs), high: hours(toMs) };
}

// A channel of a history. Its values hold as long as its line is drawn from one to the next (series.ts, Tail).
export function liveSeries(name: string, history: History, more: Partial<PlotSeries>, convert?: (value: number) => number): PlotSeries {
  const track = history.of(name);
  const holdsMs = Math.max((channel(name)?.column.staleAfterS ?? 0) * 1000, 3000 * history.bucketS, 5 * usualStep(track.atMs));
  return seriesOfTrack(track, lastMidnight(history.fromMs), { holds: holdsMs / 3600e3, ...more }, convert);
}

// Channels of one unit; more than six as deviation from the start.
export function environmentPlot(title: string, names: readonly string[], history: History): PlotSpec {
  const unit = splitChannel(names[0] ?? '').unit;
  const many = names.length > 6;
  return {
    title,
    what: `${unitSign(unit)} against time of day`,
    x: timeOfDay(history),
    y: { unit, zero: false },
    deviation: many,
    series: names.map((name, i) => liveSeries(name, history, { ...lookOf(i), quiet: many })),
    ...(history.bucketS >= 2 && { note: `1 px = ${Math.round(history.bucketS)} s` }),
    ...(history.waiting && { why: 'Waiting for the record …' }),
    ...(history.failure && { why: history.failure.message }),
  };
}
