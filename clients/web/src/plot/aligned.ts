// uPlot wants one x for all series: series in order of x (in_order.ts) are joined. NaN becomes null (a gap), an instant that only another
// series has becomes undefined (no gap).
import uPlot from 'uplot';
import type { PlotSpec } from './spec';

const nulled = (y: ArrayLike<number>): (number | null)[] => Array.from(y, (value) => (Number.isFinite(value) ? value : null));

const expand = 2; // uPlot's NULL_EXPAND: a gap stays one where other series have instants within it

// spec.series must be in order of x each.
export function aligned(spec: PlotSpec): uPlot.AlignedData {
  const byX = new Map<ArrayLike<number>, number[]>();
  spec.series.forEach((one, at) => byX.set(one.x, [...(byX.get(one.x) ?? []), at]));
  if (byX.size === 0) return [[]];
  const tables = [...byX].map(([x, members]) => [Array.from(x), ...members.map((at) => nulled(spec.series[at].y))] as uPlot.AlignedData);
  const joined = tables.length === 1 ? tables[0] : uPlot.join(tables, tables.map((table) => table.map(() => expand)));
  const place = [...byX.values()].flat(); // column of the joined data -> series
  const columns: uPlot.AlignedData[number][] = [joined[0]];
  place.forEach((at, column) => (columns[at + 1] = joined[column + 1]));
  return columns as uPlot.AlignedData;
}

// Index of the value nearest to x; -1 for none. x in order.
export function nearest(xs: ArrayLike<number>, x: number): number {
  let low = 0;
  let high = xs.length - 1;
  if (high < 0) return -1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (xs[middle] < x) low = middle;
    else high = middle;
  }
  return Math.abs(xs[low] - x) <= Math.abs(xs[high] - x) ? low : high;
}
