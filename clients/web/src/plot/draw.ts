// One uPlot on the page: made anew when the kind of series or the colours change, otherwise only given new data.
import uPlot from 'uplot';
import { aligned } from './aligned';
import { drawBehind, drawMarkers, scaleOf } from './decorations';
import { drawMarks } from './marks';
import type { Palette } from './palette';
import { wholeRange, yRange, type Range } from './ranges';
import type { PlotSeries, PlotSpec } from './spec';
import { tickTexts, ticks, xTexts, xTicks } from './ticks';

export interface Drawn {
  spec: PlotSpec; // series in order of x
  range: Range | undefined; // undefined: everything
  chosen: number | undefined;
  pointed: number | undefined; // series that is coloured though quiet
  colours: Palette;
  instant: number | undefined; // x of the instant that is pinned in every plot
}

export interface Wishes {
  zoom: (range: Range | undefined) => void;
  cursor: (x: number | undefined) => void;
  click: (x: number, y: number) => void; // px within the drawing
}

export const fontOf = '12px system-ui, "DejaVu Sans", sans-serif';

// What makes another uPlot necessary.
export const shapeOf = (spec: PlotSpec): string =>
  JSON.stringify([spec.right !== undefined, spec.series.map((one) => [one.name, one.draw, one.axis, one.colour, one.quiet, one.dash])]);

function axis(now: () => Drawn, scale: string, side: 0 | 1 | 2 | 3, pxPerTick: number): uPlot.Axis {
  const { colours } = now();
  const upright = side === 1 || side === 3;
  return {
    scale,
    side,
    stroke: colours.muted,
    font: fontOf,
    gap: 6,
    size: upright ? (_, values) => 14 + 7 * Math.max(2, ...(values ?? []).map((text) => text.length)) : 28,
    grid: { show: scale !== 'r', stroke: colours.grid, width: 1 },
    ticks: { show: false },
    splits: (u, _, low, high) =>
      (scale === 'x' ? xTicks(now().spec.x) : ticks)(low, high, (upright ? u.bbox.height : u.bbox.width) / devicePixelRatio / pxPerTick),
    values: (_, at) => (scale === 'x' ? xTexts(now().spec.x) : tickTexts)(at),
  };
}

const inks = (drawn: Drawn, at: number): string => {
  const one: PlotSeries | undefined = drawn.spec.series[at];
  if (!one) return drawn.colours.idle; // a plot of before its series changed, drawn once more before it is made anew
  return one.quiet && drawn.pointed !== undefined && drawn.pointed !== at ? drawn.colours.idle : drawn.colours[one.colour];
};

function seriesOptions(now: () => Drawn): uPlot.Series[] {
  return now().spec.series.map((one, at) => ({
    scale: scaleOf(one),
    stroke: () => inks(now(), at),
    width: one.quiet ? 1.25 : one.draw === 'dashed' ? 1.5 : 1.75,
    ...(one.draw === 'dashed' && { dash: [5, 4] }),
    ...(one.dash && { dash: [...one.dash] }),
    ...(one.draw === 'steps' && { paths: uPlot.paths.stepped!({ align: 1 }) }),
    ...(one.draw === 'markers' && { paths: () => null }),
    points: { show: false },
  }));
}

export function seenRange({ spec, range }: Drawn): Range {
  return range ?? wholeRange(spec) ?? { from: 0, to: 1 };
}

function drawInstant(u: uPlot, { instant, colours }: Drawn): void {
  if (instant === undefined) return;
  const at = Math.round(u.valToPos(instant, 'x', true));
  const { top, height } = u.bbox;
  const px = devicePixelRatio;
  u.ctx.save();
  u.ctx.strokeStyle = u.ctx.fillStyle = colours.text;
  u.ctx.lineWidth = px;
  u.ctx.beginPath();
  u.ctx.moveTo(at, top);
  u.ctx.lineTo(at, top + height);
  u.ctx.stroke();
  u.ctx.beginPath();
  u.ctx.moveTo(at - 5 * px, top - 6 * px);
  u.ctx.lineTo(at + 5 * px, top - 6 * px);
  u.ctx.lineTo(at, top);
  u.ctx.fill();
  u.ctx.restore();
}

export function makePlot(root: HTMLElement, now: () => Drawn, wishes: Wishes, size: { width: number; height: number }, group?: string): uPlot {
  const span = (which: 'left' | 'right') => (): uPlot.Range.MinMax => yRange(now().spec, which, seenRange(now()));
  const hasRight = now().spec.right !== undefined;
  return new uPlot(
    {
      ...size,
      padding: [8, hasRight ? 0 : now().spec.x.clock ? 24 : 20, 0, 0],
      legend: { show: false },
      scales: {
        x: { time: false, range: () => [seenRange(now()).from, seenRange(now()).to] },
        y: { range: span('left') },
        ...(hasRight && { r: { range: span('right') } }),
      },
      axes: [axis(now, 'x', 2, 70), axis(now, 'y', 3, 30), ...(hasRight ? [axis(now, 'r', 1, 30)] : [])],
      series: [{}, ...seriesOptions(now)],
      cursor: {
        y: false,
        points: { show: false },
        drag: { x: true, y: false, setScale: false, dist: 5 },
        ...(group && { sync: { key: group, setSeries: false, scales: ['x', null] } }),
        bind: {
          dblclick: () => () => (wishes.zoom(undefined), null),
          mousedown: (_, __, handler) => (event) => (event.shiftKey ? null : (handler(event), null)),
          click: (u) => (event) => (u.select.width < 3 && wishes.click(event.offsetX, event.offsetY), null),
        },
      },
      hooks: {
        drawAxes: [(u) => drawBehind(u, now().spec, now().colours)],
        draw: [(u) => drawMarks(u, now().spec, now().colours), (u) => drawMarkers(u, now().spec, now().colours, now().chosen), (u) => drawInstant(u, now())],
        setCursor: [(u) => wishes.cursor((u.cursor.left ?? -1) < 0 ? undefined : u.posToVal(u.cursor.left!, 'x'))],
        setSelect: [
          (u) => {
            if (u.select.width < 5) return;
            wishes.zoom({ from: u.posToVal(u.select.left, 'x'), to: u.posToVal(u.select.left + u.select.width, 'x') });
            u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          },
        ],
      },
    },
    aligned(now().spec),
    root,
  );
}

export function redraw(u: uPlot, drawn: Drawn): void {
  const { from, to } = seenRange(drawn);
  u.batch(() => {
    u.setData(aligned(drawn.spec), false);
    u.setScale('x', { min: from, max: to });
    u.redraw(true, true);
  });
}
