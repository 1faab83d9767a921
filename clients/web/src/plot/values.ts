// A plot in words and in rows: legend values, the sentence for those who do not see it, the table, the CSV.
import { fixed, signed } from '@/format/numbers';
import { dateClock } from '@/format/time';
import { liveDigits, unitSign } from '@/format/units';
import { nearest } from './aligned';
import type { Range } from './ranges';
import type { PlotSeries, PlotSpec } from './spec';

export const digitsOf = (one: PlotSeries): number => one.digits ?? liveDigits(one.unit);
export const withUnit = (text: string, unit: string): string => (unit && unit !== '1' ? `${text}\u00a0${unitSign(unit)}` : text);

// Of the instant nearest to x; nothing where no line is drawn and that value no longer holds.
export function valueAt(one: PlotSeries, x: number | undefined): string {
  const at = x === undefined ? one.x.length - 1 : nearest(one.x, x);
  const away = x === undefined || at < 0 ? 0 : x - one.x[at];
  const isKnown = Number.isFinite(one.y[at + Math.sign(away)]) || Math.abs(away) <= (one.holds ?? Infinity);
  return withUnit(fixed(isKnown ? one.y[at] : NaN, digitsOf(one)), one.unit);
}

export function cursorText(spec: PlotSpec, x: number): string {
  const here = withUnit(fixed(x, spec.x.unit === 'h' ? 3 : 2), spec.x.unit);
  return spec.x.startMs === undefined ? here : `${here}, ${dateClock(spec.x.startMs + x * 3600e3)}`;
}

// "q1: −12 to 43 nm, last 41 nm, +3 nm over what is shown"
export function inWords(spec: PlotSpec, { from, to }: Range): string {
  const parts = spec.series.slice(0, 6).map((one) => {
    let low = Infinity;
    let high = -Infinity;
    let first = NaN;
    let last = NaN;
    for (let i = 0; i < one.x.length; i++) {
      const y = one.y[i];
      if (one.x[i] < from || one.x[i] > to || !Number.isFinite(y)) continue;
      if (Number.isNaN(first)) first = y;
      last = y;
      low = Math.min(low, one.min?.[i] ?? y);
      high = Math.max(high, one.max?.[i] ?? y);
    }
    if (low > high) return `${one.name}: nothing shown`;
    const d = digitsOf(one);
    const line = one.draw !== 'markers' ? `, last ${fixed(last, d)}, change ${signed(last - first, d)}` : '';
    return `${one.name}: ${fixed(low, d)} to ${withUnit(fixed(high, d), one.unit)}${line}`;
  });
  const more = spec.series.length > 6 ? `; and ${spec.series.length - 6} more` : '';
  return `${spec.title}, ${spec.what}. ${parts.join('; ')}${more}.`;
}

// Columns of the CSV and the table: x, then every series, with its extremes where it is decimated.
export interface Columns {
  names: string[];
  x: number[];
  values: (number | undefined)[][]; // per column, parallel to x
}

export function columnsOf(spec: PlotSpec): Columns {
  const xs = [...new Set(spec.series.flatMap((one) => Array.from(one.x)))].sort((a, b) => a - b);
  const row = new Map(xs.map((x, at) => [x, at]));
  const names: string[] = [];
  const values: (number | undefined)[][] = [];
  const add = (name: string, one: PlotSeries, of: ArrayLike<number>) => {
    const column = new Array<number | undefined>(xs.length).fill(undefined);
    for (let i = 0; i < one.x.length; i++) if (Number.isFinite(of[i])) column[row.get(one.x[i])!] = of[i];
    names.push(name);
    values.push(column);
  };
  for (const one of spec.series) {
    const plain = one.name.replace(/[^\w]+/g, '_');
    const unit = one.unit || '1';
    add(`${plain}_${unit}`, one, one.y);
    if (one.min && one.max) {
      add(`${plain}_min_${unit}`, one, one.min);
      add(`${plain}_max_${unit}`, one, one.max);
    }
  }
  return { names, x: xs, values };
}

export function csvOf(spec: PlotSpec, source: string): string {
  const { names, x, values } = columnsOf(spec);
  const head = [
    '# driftwise-plot: 1',
    `# title: ${spec.title}`,
    `# what: ${spec.what}`,
    `# source: ${source}`,
    ...(spec.x.startMs === undefined ? [] : [`# start: ${new Date(spec.x.startMs).toISOString()}`]),
    ...(spec.note ? [`# note: ${spec.note}`] : []),
    ...(spec.marks ?? []).map((mark) => `# mark: ${mark.at} ${spec.x.unit}, ${mark.kind}: ${mark.label}`),
    ...(spec.head ?? []).map((line) => `# ${line}`),
    [spec.x.label, ...names].join(','),
  ];
  const rows = x.map((at, i) => [at, ...values.map((column) => column[i] ?? '')].join(','));
  return `${[...head, ...rows].join('\n')}\n`;
}
