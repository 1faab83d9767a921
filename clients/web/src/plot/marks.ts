// Instants that explain a step in every plot over time: changes of force, stops, resumes, restarts, remarks. As vertical lines.
import { createContext } from 'preact';
import type uPlot from 'uplot';
import type { Palette } from './palette';
import type { Range } from './ranges';
import { inOrder } from './in_order';
import type { Colour, PlotMark, PlotSeries, PlotSpec } from './spec';

export type TimeMark = Omit<PlotMark, 'at'> & { atMs: number };

// Of the page: every plot below whose x is time since a known instant shows them.
export const TimeMarks = createContext<readonly TimeMark[]>([]);

// Of rows whose x is hours since the first of them: what the record says of their runs.
export const RowMarks = createContext<readonly PlotMark[]>([]);

export const markLooks: Record<PlotMark['kind'], { colour: Colour; dash: number[]; one: string; many: string }> = {
  force: { colour: 's6', dash: [1, 3], one: 'change of force', many: 'changes of force' },
  stop: { colour: 'bad', dash: [], one: 'stop or pause', many: 'stops or pauses' },
  resume: { colour: 'good', dash: [8, 3], one: 'resume', many: 'resumes' },
  restart: { colour: 's5', dash: [8, 3], one: 'restart', many: 'restarts' },
  note: { colour: 'muted', dash: [3, 2], one: 'remark', many: 'remarks' },
};

export function withTimeMarks(spec: PlotSpec, marks: readonly TimeMark[], ofRows: readonly PlotMark[] = []): PlotSpec {
  if (spec.x.sinceFirstRow) {
    const all = [...(spec.marks ?? []), ...within(spec, ofRows)].sort((a, b) => a.at - b.at);
    return all.length > 0 ? broken({ ...spec, marks: all }) : spec;
  }
  const { startMs, unit } = spec.x;
  if (spec.marks || startMs === undefined || unit !== 'h' || marks.length === 0) return spec;
  const at = marks.map(({ atMs, ...mark }): PlotMark => ({ ...mark, at: (atMs - startMs) / 3600e3 }));
  return broken({ ...spec, marks: within(spec, at) });
}

// Lines of points with a gap at each stop: nothing was measured between the points before and after it.
function broken(spec: PlotSpec): PlotSpec {
  const stops = spec.marks!.filter((mark) => mark.kind === 'stop').map((mark) => mark.at);
  if (stops.length === 0 || !spec.series.some((one) => one.ofPoints)) return spec;
  const gapped = (one: PlotSeries): PlotSeries => {
    if (!one.ofPoints || one.x.length === 0) return one;
    const at = stops.filter((x) => x > one.x[0] && x < one.x[one.x.length - 1]);
    return inOrder({ ...one, x: [...Array.from(one.x), ...at], y: [...Array.from(one.y), ...at.map(() => NaN)], ...(one.keys && { keys: [...Array.from(one.keys), ...at.map(() => NaN)] }) });
  };
  return { ...spec, series: spec.series.map(gapped) };
}

// Those between the first and the last point of the plot, or in the range that it shows at least.
function within(spec: PlotSpec, marks: readonly PlotMark[]): PlotMark[] {
  const xs = spec.series.filter((one) => one.x.length > 0);
  const from = Math.min(spec.x.low ?? Infinity, ...xs.map((one) => one.x[0]));
  const to = Math.max(spec.x.high ?? -Infinity, ...xs.map((one) => one.x[one.x.length - 1]));
  return marks.filter((mark) => mark.at >= from && mark.at <= to);
}

// Per kind, those that stand in the plot: "2 stops or pauses".
export function marksInWords(spec: PlotSpec): { kind: PlotMark['kind']; words: string; labels: string }[] {
  return (Object.keys(markLooks) as PlotMark['kind'][]).flatMap((kind) => {
    const mine = (spec.marks ?? []).filter((mark) => mark.kind === kind);
    const look = markLooks[kind];
    return mine.length === 0 ? [] : [{ kind, words: `${mine.length} ${mine.length === 1 ? look.one : look.many}`, labels: mine.map((mark) => mark.label).join('; ') }];
  });
}

export function drawMarks(u: uPlot, spec: PlotSpec, colours: Palette): void {
  const { ctx, bbox } = u;
  const { min, max } = u.scales.x;
  const px = devicePixelRatio;
  ctx.save();
  for (const mark of spec.marks ?? []) {
    if (mark.at < min! || mark.at > max!) continue;
    const x = u.valToPos(mark.at, 'x', true);
    ctx.beginPath();
    ctx.setLineDash(markLooks[mark.kind].dash.map((length) => length * px));
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.strokeStyle = colours[markLooks[mark.kind].colour];
    ctx.lineWidth = 1.25 * px;
    ctx.stroke();
  }
  ctx.restore();
}

export function marksSvg(spec: PlotSpec, range: Range, x: (value: number) => number, top: number, height: number, colours: Palette, escaped: (text: string) => string): string {
  return (spec.marks ?? []).filter((mark) => mark.at >= range.from && mark.at <= range.to).map((mark) => {
    const { colour, dash } = markLooks[mark.kind];
    return `<path class="mark-${mark.kind}" d="M${x(mark.at).toFixed(2)} ${top}v${height}" stroke="${colours[colour]}" stroke-dasharray="${dash.join(' ') || 'none'}"><title>${escaped(mark.label)}</title></path>`;
  }).join('');
}
