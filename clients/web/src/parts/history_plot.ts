// Recorded channels over time of day, as a plot.
import { lastMidnight } from '@/format/time';
import { splitChannel, unitSign } from '@/format/units';
import type { History } from '@/live/history';
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

// Channels of one unit; more than six as deviation from the start.
export function environmentPlot(title: string, names: readonly string[], history: History): PlotSpec {
  const startMs = lastMidnight(history.fromMs);
  const unit = splitChannel(names[0] ?? '').unit;
  const many = names.length > 6;
  return {
    title,
    what: `${unitSign(unit)} against time of day`,
    x: { label: 'time_h', unit: 'h', startMs, clock: true },
    y: { unit, zero: false },
    deviation: many,
    series: names.map((name, i) => seriesOfTrack(history.of(name), startMs, { ...lookOf(i), quiet: many })),
    ...(history.bucketS >= 2 && { note: `1 px = ${Math.round(history.bucketS)} s` }),
    ...(history.waiting && { why: 'Waiting for the record …' }),
    ...(history.failure && { why: history.failure.message }),
  };
}
