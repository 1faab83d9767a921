// Drift of the zero: what the instruments read at each return to zero, minus the first of the same datum.
import type { Point } from '@/api/gen/driftwise/v1/run_pb';
import { ms } from '@/format/time';
import { isLength, nmFrom, splitChannel } from '@/format/units';
import { channel } from '@/live/channels';
import { valueOf } from '@/live/points';
import type { Colour, PlotSeries, PlotSpec } from '@/plot/spec';

export const axisColours: readonly Colour[] = ['q1', 'q2', 'q3', 's4', 's6', 's5'];

export interface ZeroDrift {
  lengths: string[]; // "x_mm", "x_um" of an imported file
  hours: number[];
  nm: number[][]; // per length
  rows: number[];
}

export function zeroDrift(points: readonly Point[], startMs: number, lengths: readonly string[]): ZeroDrift {
  const zeros = points.filter((point) => point.zero);
  const first = new Map<bigint, Point>(); // of each datum
  for (const point of zeros) if (!first.has(point.datumId)) first.set(point.datumId, point);
  return {
    lengths: [...lengths],
    hours: zeros.map((point) => ((ms(point.measureTime) ?? NaN) - startMs) / 3600e3),
    nm: lengths.map((channel) => zeros.map((point) => nmFrom(valueOf(point, channel) - valueOf(first.get(point.datumId)!, channel), splitChannel(channel).unit))),
    rows: zeros.map((point) => Number(point.row)),
  };
}

// Lengths that the points hold, in whatever unit of length: x, y, z of the instruments, or all that are neither a motor coordinate nor
// the spread of another channel.
export function lengthsOf(channels: readonly string[]): string[] {
  const all = channels.filter((name) => isLength(splitChannel(name).unit));
  const lengths = all.filter((name) => /^[xyz]$/.test(splitChannel(name).symbol));
  return lengths.length > 0 ? lengths : all.filter((name) => !/^(q\d|goal_|x_target)/.test(name) && !/_(cmd|std)_/.test(name));
}

// By its name, or by the part that the cell file declares: a thermometer of the robot is none of the air.
export const airOf = (channels: readonly string[]): string | undefined =>
  channels.find((name) => name === 'air_degC') ?? channels.find((name) => /^air.*_degC$/.test(name)) ?? channels.find((name) => name.endsWith('_degC') && channel(name)?.column.part === 'air');

export function zeroPlot(drift: ZeroDrift, startMs: number, air?: { name: string; x: ArrayLike<number>; y: ArrayLike<number> }): PlotSpec {
  const series: PlotSeries[] = drift.lengths.map((channel, i) => ({
    name: splitChannel(channel).symbol,
    unit: 'nm',
    colour: axisColours[i % axisColours.length],
    x: drift.hours,
    y: drift.nm[i],
    keys: drift.rows,
    digits: 1,
    ofPoints: true,
  }));
  if (air) series.push({ name: splitChannel(air.name).symbol.replaceAll('_', ' '), unit: 'degC', colour: 's5', draw: 'dashed', ofPoints: true, axis: 'right', x: air.x, y: air.y });
  return {
    title: 'Drift of the zero',
    what: air ? 'nm against hours since start; air in °C on the right' : 'nm against hours since start',
    x: { label: 'time_h', unit: 'h', startMs },
    y: { unit: 'nm' },
    ...(air && { right: { unit: 'degC' } }),
    series,
    ...(drift.lengths.length === 0 && drift.hours.length > 0 && { why: 'No length is among the channels of its points.' }),
    ...(drift.hours.length < 2 && { why: drift.hours.length === 0 ? 'No return to zero yet.' : 'One return to zero so far: drift shows from the second on.' }),
  };
}
