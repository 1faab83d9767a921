// Plots of many channels: each has a look of its own in the key, and all can be seen as their deviation from the start.
import type { Colour, PlotSeries, PlotSpec } from './spec';
import { cursorText } from './values';

const colours: readonly Colour[] = ['q1', 'q2', 'q3', 's4', 's6', 's5'];
const dashes: readonly (readonly number[])[] = [[], [7, 3], [2, 3], [9, 3, 2, 3]];

// 24 that differ in colour or dash.
export function lookOf(at: number): Pick<PlotSeries, 'colour' | 'dash'> {
  const dash = dashes[Math.floor(at / colours.length) % dashes.length];
  return { colour: colours[at % colours.length], ...(dash.length > 0 && { dash }) };
}

const deviationUnit = (unit: string): string => (unit === 'degC' ? 'K' : unit);

const firstFrom = (one: PlotSeries, from: number): number => {
  for (let i = 0; i < one.x.length; i++) if (one.x[i] >= from && Number.isFinite(one.y[i])) return i;
  return -1;
};

function lessFirst(one: PlotSeries, from: number): PlotSeries {
  const first = one.y[firstFrom(one, from)] ?? NaN;
  const less = (values: ArrayLike<number>) => Array.from(values, (value) => value - first);
  return { ...one, unit: deviationUnit(one.unit), y: less(one.y), ...(one.min && { min: less(one.min) }), ...(one.max && { max: less(one.max) }) };
}

// Every series less its value at one instant, the first that all of them reach: ten thermometers of ten temperatures on one scale.
export function deviationFromStart(spec: PlotSpec): PlotSpec {
  const starts = spec.series.flatMap((one) => one.x[firstFrom(one, -Infinity)] ?? []);
  const ends = spec.series.flatMap((one) => one.x[one.x.length - 1] ?? []);
  const from = Math.max(...starts);
  // Channels that are read in turn begin within a moment.
  const late = from - Math.min(...starts) > 0.02 * (Math.max(...ends) - Math.min(...starts));
  const { low, high, zero, ...y } = spec.y;
  return {
    ...spec,
    what: `deviation from ${late ? cursorText(spec, from) : 'the start'}, ${deviationUnit(spec.y.unit)}; ${spec.what.replace(/^.*?against/, 'against')}`,
    y: { ...y, unit: deviationUnit(spec.y.unit) },
    series: spec.series.map((one) => lessFirst(one, from)),
    ...(spec.file && { file: `${spec.file}-deviation` }),
  };
}
