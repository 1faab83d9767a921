// What the axes span.
import type { PlotSeries, PlotSpec } from './spec';
import { paddedRange } from './ticks';

export interface Range {
  from: number;
  to: number; // in the unit of x
}

export function wholeRange(spec: PlotSpec): Range | undefined {
  let from = spec.x.low ?? Infinity;
  let to = spec.x.high ?? -Infinity;
  for (const { x } of spec.series) {
    if (x.length === 0) continue;
    from = Math.min(from, x[0]);
    to = Math.max(to, x[x.length - 1]);
  }
  if (from > to) return undefined;
  if (from === to) return { from: from - 0.5, to: to + 0.5 };
  // A mark is as wide as it is: those at the ends would be cut in half.
  const room = spec.series.every((one) => one.draw === 'markers') ? 0.02 * (to - from) : 0;
  return { from: from - room, to: to + room };
}

function extent(series: readonly PlotSeries[], range: Range): [number, number] {
  let low = Infinity;
  let high = -Infinity;
  for (const one of series) {
    const lows = one.min ?? one.y;
    const highs = one.max ?? one.y;
    const take = (least: number, most: number) => {
      if (least < low) low = least;
      if (most > high) high = most;
    };
    for (let i = 0; i < one.x.length; i++) {
      if (one.x[i] >= range.from && one.x[i] <= range.to) take(lows[i], highs[i]);
      if (i === 0 || one.draw === 'markers') continue;
      // Crossings of a line with an end of what is seen, between two points.
      for (const end of [range.from, range.to]) {
        if (!(one.x[i - 1] < end && end < one.x[i])) continue;
        const share = one.draw === 'steps' ? 0 : (end - one.x[i - 1]) / (one.x[i] - one.x[i - 1]);
        const at = (values: ArrayLike<number>) => values[i - 1] + share * (values[i] - values[i - 1]);
        take(at(lows), at(highs));
      }
    }
  }
  return [low, high];
}

// Of one axis, over what is seen of x: data, zero line, limits, and what the spec asks for at least.
export function yRange(spec: PlotSpec, axis: 'left' | 'right', range: Range): [number, number] {
  const mine = spec.series.filter((one) => (one.axis ?? 'left') === axis);
  let [low, high] = extent(mine, range);
  const wanted = axis === 'left' ? spec.y : (spec.right ?? { unit: '' });
  if (axis === 'left') {
    if (spec.y.zero !== false) [low, high] = [Math.min(low, 0), Math.max(high, 0)];
    for (const band of spec.bands ?? []) [low, high] = [Math.min(low, band.from), Math.max(high, band.to)];
  }
  for (const limit of spec.limits ?? []) {
    if ((limit.axis ?? 'left') === axis) [low, high] = [Math.min(low, limit.at), Math.max(high, limit.at)];
  }
  if (wanted.low !== undefined) low = Math.min(low, wanted.low);
  if (wanted.high !== undefined) high = Math.max(high, wanted.high);
  const [padLow, padHigh] = paddedRange(low, high);
  if (axis === 'left' && spec.y.symmetric) {
    const most = Math.max(Math.abs(padLow), Math.abs(padHigh));
    return [-most, most];
  }
  // An axis that starts at zero starts there, not below it.
  return axis === 'left' && low === 0 && high > 0 ? [0, padHigh] : [padLow, padHigh];
}

// Ranges where no line series has anything, which are hatched: runs of NaN between two values, and what lies before the first and
// after the last one where that is longer than a value holds; common to all lines.
export function gapsOf(spec: PlotSpec): Range[] {
  const lines = spec.series.filter((one) => one.draw !== 'markers');
  let common: Range[] | undefined;
  for (const one of lines) {
    const gaps: Range[] = [];
    let last = -1;
    for (let i = 0; i < one.x.length; i++) {
      if (!Number.isFinite(one.y[i])) continue;
      if (last >= 0 && i > last + 1) gaps.push({ from: one.x[last], to: one.x[i] });
      last = i;
    }
    gaps.push(...atEnds(one, spec.x, last));
    common = common === undefined ? gaps : overlap(common, gaps);
  }
  return [...(common ?? []), ...(spec.spans ?? []).filter((span) => span.kind === 'gap')];
}

// last: the index of the last value; -1: the series has none.
function atEnds(one: PlotSeries, { low = NaN, high = NaN }: PlotSpec['x'], last: number): Range[] {
  const first = Array.prototype.findIndex.call(one.y, Number.isFinite);
  const ends = last < 0 ? [{ from: low, to: high }] : [{ from: low, to: one.x[first] }, { from: one.x[last], to: high }];
  return ends.filter(({ from, to }) => to - from > (one.holds ?? Infinity));
}

function overlap(a: readonly Range[], b: readonly Range[]): Range[] {
  return a.flatMap((one) =>
    b.map((two) => ({ from: Math.max(one.from, two.from), to: Math.min(one.to, two.to) })).filter(({ from, to }) => to > from),
  );
}
