// Plots of many channels: each has a look of its own in the key, and all can be seen as their deviation from the start.
import type { Colour, PlotSeries, PlotSpec } from './spec';

const colours: readonly Colour[] = ['q1', 'q2', 'q3', 's4', 's6', 's5'];
const dashes: readonly (readonly number[])[] = [[], [7, 3], [2, 3], [9, 3, 2, 3]];

// 24 that differ in colour or dash.
export function lookOf(at: number): Pick<PlotSeries, 'colour' | 'dash'> {
  const dash = dashes[Math.floor(at / colours.length) % dashes.length];
  return { colour: colours[at % colours.length], ...(dash.length > 0 && { dash }) };
}

const deviationUnit = (unit: string): string => (unit === 'degC' ? 'K' : unit);

function lessFirst(one: PlotSeries): PlotSeries {
  const first = Array.from(one.y).find(Number.isFinite) ?? NaN;
  const less = (values: ArrayLike<number>) => Array.from(values, (value) => value - first);
  return { ...one, unit: deviationUnit(one.unit), y: less(one.y), ...(one.min && { min: less(one.min) }), ...(one.max && { max: less(one.max) }) };
}

// Every series less its first value: ten thermometers of ten temperatures on one scale.
export function deviationFromStart(spec: PlotSpec): PlotSpec {
  const { low, high, zero, ...y } = spec.y;
  return {
    ...spec,
    what: `deviation from the start, ${deviationUnit(spec.y.unit)}; ${spec.what.replace(/^.*?against/, 'against')}`,
    y: { ...y, unit: deviationUnit(spec.y.unit) },
    series: spec.series.map(lessFirst),
    ...(spec.file && { file: `${spec.file}-deviation` }),
  };
}
