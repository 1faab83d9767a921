// Discrepancies as plots.
import type { DiscrepancyRows, FindingParameter, OutputDiscrepancy } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { unitSign } from '@/format/units';
import type { Marker, PlotSeries, PlotSpec } from '@/plot/spec';
import { forceMarks } from '@/parts/time_marks';
import { spanOf } from '@/plot/residual_specs';
import { after, before, parameterWords } from './words';

export interface PlotAxis {
  symbol: string;
  unit: string;
  words: string;
  values: readonly number[];
}

// Time first, or the order where the rows are untimed; then every channel that varies and is no output.
export function axesOf(rows: DiscrepancyRows): string[] {
  const outputs = new Set(rows.outputs.map((one) => one.output));
  const channels = rows.variables.filter((one) => !outputs.has(one.symbol) && spanOf(one.values.filter(Number.isFinite)) > 0).map((one) => one.symbol);
  return [rows.timeS.length > 0 ? 'time' : 'row', ...channels];
}

export function axisOf(rows: DiscrepancyRows, symbol: string): PlotAxis {
  const found = rows.variables.find((one) => one.symbol === symbol);
  if (found) return { symbol, unit: found.unit, words: `${symbol}, ${unitSign(found.unit)}`, values: found.values };
  if (rows.timeS.length > 0) return { symbol: 'time_h', unit: 'h', words: 'hours since start', values: rows.timeS.map((t) => (t - rows.timeS[0]) / 3600) };
  const length = rows.outputs[0]?.before.length ?? 0;
  return { symbol: 'row', unit: '1', words: 'row', values: Array.from({ length }, (_, i) => i + 1) };
}

interface Group {
  name: string;
  colour: 'q1' | 'q2';
  marker: Marker;
  has: (row: number) => boolean;
}

function groupsOf(rows: DiscrepancyRows, output: string, colour: string): Group[] {
  if (colour === 'line' && rows.line.length > 0)
    return [
      { name: 'odd lines', colour: 'q1', marker: 'dot', has: (i) => Math.abs(rows.line[i] % 2) === 1 },
      { name: 'even lines', colour: 'q2', marker: 'validation', has: (i) => rows.line[i] % 2 === 0 },
    ];
  const motor = rows.variables.find((one) => one.symbol === output)?.values ?? rows.variables.find((one) => one.symbol === output.replace('q', 'xyz'[Number(output.slice(1)) - 1] ?? ''))?.values;
  if (colour === 'direction' && motor)
    return [
      { name: 'approached upwards', colour: 'q1', marker: 'dot', has: (i) => i > 0 && motor[i] >= motor[i - 1] },
      { name: 'approached downwards', colour: 'q2', marker: 'validation', has: (i) => i > 0 && motor[i] < motor[i - 1] },
    ];
  return [
    { name: 'calibration', colour: 'q1', marker: 'calibration', has: (i) => !rows.validation[i] },
    { name: 'validation', colour: 'q2', marker: 'validation', has: (i) => rows.validation[i] },
  ];
}

export function discrepancySpec(rows: DiscrepancyRows, output: OutputDiscrepancy, x: PlotAxis, colour: string, which: 'before' | 'after', title: string): PlotSpec {
  const of = rows.outputs.find((one) => one.output === output.output);
  const y = (which === 'before' ? of?.before : of?.after) ?? [];
  const all = [...(of?.before ?? []), ...(of?.after ?? [])].filter(Number.isFinite);
  const reach = all.reduce((most, value) => Math.max(most, Math.abs(value)), Math.max(before(output), after(output)));
  const a90 = which === 'before' ? before(output) : after(output);
  const series: PlotSeries[] = groupsOf(rows, output.output, colour).map((group) => {
    const wanted: number[] = [];
    for (let i = 0; i < y.length; ++i) if (group.has(i) && Number.isFinite(y[i]) && Number.isFinite(x.values[i])) wanted.push(i);
    wanted.sort((a, b) => x.values[a] - x.values[b]);
    return {
      name: group.name, unit: output.unit, colour: group.colour, draw: 'markers' as const, marker: group.marker, digits: 1,
      x: wanted.map((i) => x.values[i]), y: wanted.map((i) => y[i]), keys: wanted,
    };
  });
  return {
    title, what: `measured − simulated, ${output.output}, ${output.unit}, against ${x.words}; band = A90`,
    x: { label: x.symbol, unit: x.unit, ...(x.symbol === 'time_h' && { sinceFirstRow: true }) }, y: { unit: output.unit, symmetric: true, low: -reach, high: reach },
    series: series.filter((one) => one.x.length > 0), bands: [{ from: -a90, to: a90, colour: 'q1', label: 'A90' }],
    ...(x.symbol === 'time_h' && { marks: forceMarks(x.values, axisOf(rows, 'force').unit === 'N' ? axisOf(rows, 'force').values : []) }),
    file: `discrepancy-${which}-${output.output}`, ...(y.length === 0 ? { why: 'No rows were kept of this output.' } : {}),
  };
}

// 2 ln L below its maximum against the parameter; the limit line is that of the 90 % interval (chi-square, one degree).
export function likelihoodSpec(parameter: FindingParameter, cause: string): PlotSpec {
  const { name, unit } = parameterWords(parameter.name);
  const below = parameter.curve2lnl.map((value) => -Math.abs(value));
  return {
    title: `Likelihood of ${name}`, what: `2 ln L below its maximum against ${name}${unit && `, ${unit}`}; within the dashed line: 90 %`,
    x: { label: parameter.name, unit }, y: { unit: '1', low: -12, high: 0 },
    series: [{ name: '2 ln L', unit: '1', colour: 'q1', x: parameter.curveValue, y: below.map((value) => Math.max(value, -40)), digits: 1 }],
    limits: [{ at: -2.706, label: '90 %' }], spans: [], file: `likelihood-${cause}-${parameter.name}`,
    ...(parameter.curveValue.length < 2 ? { why: 'No profile was worked out for this parameter.' } : {}),
  };
}
