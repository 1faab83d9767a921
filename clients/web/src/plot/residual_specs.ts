// Residuals as plots: one against time, one against each channel that varies.
import type { PlotSeries, PlotSpec } from '@/plot/spec';
import { forceMarks } from '@/parts/time_marks';
import { unitSign } from '@/format/units';

export interface ResidualRows {
  timeS: readonly number[];
  validation: readonly boolean[];
  excluded: readonly boolean[];
  variables: readonly { symbol: string; unit: string; values: readonly number[] }[];
  outputs: readonly { output: string; values: readonly number[] }[];
}

// Of the rows of one set, in order of x.
function seriesOf(rows: ResidualRows, x: readonly number[], y: readonly number[], validation: boolean, unit: string): PlotSeries {
  const wanted: number[] = [];
  for (let i = 0; i < y.length; ++i)
    if (rows.validation[i] === validation && !rows.excluded[i] && Number.isFinite(x[i]) && Number.isFinite(y[i])) wanted.push(i);
  wanted.sort((a, b) => x[a] - x[b]);
  return {
    name: validation ? 'validation' : 'calibration',
    unit,
    colour: validation ? 'q2' : 'q1',
    draw: 'markers',
    marker: validation ? 'validation' : 'calibration',
    x: wanted.map((i) => x[i]),
    y: wanted.map((i) => y[i]),
    keys: wanted,
    digits: 1,
  };
}

export function spanOf(values: readonly number[]): number {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return high - low;
}

// In the order in which a person looks: position, force, structure temperatures, tilts, air; motor coordinates only where
// there is no pose.
const families = [/^[xyz]$/, /^force$/, /^t\d\d$/, /^r[xyz]$/, /^(air.*|pressure|humidity|dwell)$/];
const motor = /^q\d+$/;

export function inOrderOfInterest<V extends { symbol: string }>(variables: readonly V[]): V[] {
  const wanted = variables.some((one) => families[0].test(one.symbol)) ? families : [motor, ...families];
  return wanted.flatMap((family) => variables.filter((one) => family.test(one.symbol)));
}

export function residualSpecs(rows: ResidualRows, output: string, unit: string, a90: number | undefined, file: string): PlotSpec[] {
  const y = rows.outputs.find((one) => one.output === output)?.values ?? [];
  const reach = Math.max(...y.filter((value, i) => Number.isFinite(value) && !rows.excluded[i]).map(Math.abs), 1e-9);
  const bands = a90 === undefined ? [] : [{ from: -a90, to: a90, colour: 'q1' as const, label: 'A90 of calibration' }];
  const spec = (title: string, x: readonly number[], label: string, xUnit: string, words: string): PlotSpec => {
    const both = [false, true].map((validation) => seriesOf(rows, x, y, validation, unit)).filter((series) => series.x.length > 0);
    return {
      title, what: `${unit} against ${words}`, x: { label, unit: xUnit }, y: { unit, symmetric: true, low: -reach, high: reach },
      series: both, bands, file: `${file}-${output}-residual-${label}`,
      ...(both.length === 0 ? { why: `No row has both ${output} and ${label}.` } : {}),
    };
  };
  const specs: PlotSpec[] = [];
  if (rows.timeS.length > 0) {
    const start = rows.timeS[0];
    const hours = rows.timeS.map((t) => (t - start) / 3600);
    const force = rows.variables.find((one) => one.symbol === 'force')?.values ?? [];
    const overTime = spec('Over time', hours, 'time_h', 'h', 'hours since start');
    specs.push({ ...overTime, x: { ...overTime.x, sinceFirstRow: true }, marks: forceMarks(hours, force) });
  } else {
    specs.push(spec('In order', y.map((_, i) => i + 1), 'row', '1', 'row'));
  }
  for (const variable of inOrderOfInterest(rows.variables)) {
    if (variable.symbol === output || !(spanOf(variable.values.filter(Number.isFinite)) > 0)) continue;
    specs.push(spec(`Against ${variable.symbol}`, variable.values, variable.symbol, variable.unit, `${variable.symbol}, ${unitSign(variable.unit)}`));
  }
  return specs;
}
