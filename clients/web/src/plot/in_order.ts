// Series in order of x. Apart from aligned.ts, which needs uPlot: marks are wanted before any plot is.
import type { PlotSeries } from './spec';

function isSorted(x: ArrayLike<number>): boolean {
  for (let i = 1; i < x.length; i++) if (x[i] < x[i - 1]) return false;
  return true;
}

// The same series in order of x, every parallel array with it. Returns the series itself where nothing is to be done.
export function inOrder(series: PlotSeries): PlotSeries {
  if (isSorted(series.x)) return series;
  const order = Array.from({ length: series.x.length }, (_, i) => i).sort((a, b) => series.x[a] - series.x[b]);
  const by = (values: ArrayLike<number>) => order.map((i) => values[i]);
  return {
    ...series,
    x: by(series.x),
    y: by(series.y),
    ...(series.min && { min: by(series.min) }),
    ...(series.max && { max: by(series.max) }),
    ...(series.keys && { keys: by(series.keys) }),
  };
}
