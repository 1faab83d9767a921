// Drift of the zero over the points of a run.
import type { Point } from '@/api/gen/driftwise/v1/run_pb';
import { ms } from '@/format/time';
import { splitChannel } from '@/format/units';
import { channel } from '@/live/channels';
import { valueOf } from '@/live/points';
import type { Colour, PlotSeries, PlotSpec } from '@/plot/spec';
import { driftOf, type ZeroDrift } from './zero_drift';

export { lengthsOf, type ZeroDrift } from './zero_drift';

export const axisColours: readonly Colour[] = ['q1', 'q2', 'q3', 's4', 's6', 's5'];

export function zeroDrift(points: readonly Point[], startMs: number, lengths: readonly string[]): ZeroDrift {
  const returns = points.filter((point) => point.zero).map((point) => ({
    datum: point.datumId, hours: ((ms(point.measureTime) ?? NaN) - startMs) / 3600e3, row: Number(point.row), value: (channel: string) => valueOf(point, channel),
  }));
  return driftOf(returns, lengths);
}

// By its name, where the cell file declares no other part, or by the part that it declares: a thermometer of the robot is none of the
// air, also where its name begins so.
export const airOf = (channels: readonly string[]): string | undefined => {
  const partOf = (name: string) => channel(name)?.column.part;
  return (
    channels.find((name) => name === 'air_degC') ??
    channels.find((name) => /^air.*_degC$/.test(name) && (partOf(name) || 'air') === 'air') ??
    channels.find((name) => name.endsWith('_degC') && partOf(name) === 'air')
  );
};

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
