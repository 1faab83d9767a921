// A map as numbers, and how it is painted.
import type { MapTargetsResponse } from '@/api/gen/driftwise/v1/target_service_pb';
import { ticks, tickTexts } from '@/plot/ticks';
import type { Palette } from '@/plot/palette';
import { diverging, mix } from '@/poses/colours';
import type { PoseField } from './pose';

export interface MapPicture {
  title: string;
  kind: 'correction' | 'uncertainty';
  columns: number;
  rows: number;
  values: readonly number[]; // nm, row by row, the lowest first
  outside: readonly boolean[];
  unreachable: readonly boolean[]; // beyond the soft limits of an axis
  x: (column: number) => number; // mm
  y: (row: number) => number;
  names: readonly [string, string];
  low: number; // over the domain
  high: number;
}

export function mapOf(answer: MapTargetsResponse, channel: string, kind: MapPicture['kind']): MapPicture {
  const plane = answer.planes.find((one) => one.channel === channel) ?? answer.planes[0];
  const [h, v] = [answer.horizontal!, answer.vertical!];
  const position = (axis: typeof h) => (index: number) => (axis.from ?? 0) + (((axis.to ?? 0) - (axis.from ?? 0)) * index) / (axis.count - 1);
  const values = kind === 'correction' && plane.correctionNm.length > 0 ? plane.correctionNm : plane.u90Nm;
  let [low, high] = [Infinity, -Infinity];
  values.forEach((value, i) => {
    if (answer.outside[i]) return;
    low = Math.min(low, value);
    high = Math.max(high, value);
  });
  return {
    title: `${kind} of ${channel}`, kind: values === plane.u90Nm ? 'uncertainty' : kind, columns: h.count, rows: v.count, values, outside: answer.outside, unreachable: answer.unreachable,
    x: position(h), y: position(v), names: [h.channel, v.channel], low: low <= high ? low : 0, high: low <= high ? high : 1,
  };
}

export function colourOf(picture: MapPicture, value: number, colours: Palette): string {
  if (picture.kind === 'correction') return diverging(value, Math.max(Math.abs(picture.low), Math.abs(picture.high)), colours);
  const share = picture.high > picture.low ? (value - picture.low) / (picture.high - picture.low) : 0;
  return mix(colours.panel, colours.q1, 0.08 + 0.92 * Math.min(1, Math.max(0, share)));
}

const margin = { left: 52, right: 12, top: 24, bottom: 40 };

function frame(picture: MapPicture, width: number, height: number) {
  const inner = { width: width - margin.left - margin.right, height: height - margin.top - margin.bottom };
  const [x0, x1] = [picture.x(-0.5), picture.x(picture.columns - 0.5)];
  const [y0, y1] = [picture.y(-0.5), picture.y(picture.rows - 0.5)];
  return {
    inner,
    px: (x: number) => margin.left + ((x - x0) / (x1 - x0)) * inner.width,
    py: (y: number) => margin.top + inner.height - ((y - y0) / (y1 - y0)) * inner.height,
    x: (px: number) => x0 + ((px - margin.left) / inner.width) * (x1 - x0),
    y: (py: number) => y0 + ((margin.top + inner.height - py) / inner.height) * (y1 - y0),
    ends: [x0, x1, y0, y1] as const,
  };
}

export function placeOnMap(picture: MapPicture, width: number, height: number, px: number, py: number) {
  const f = frame(picture, width, height);
  const [x, y] = [f.x(px), f.y(py)];
  const column = Math.round((x - picture.x(0)) / (picture.x(1) - picture.x(0)));
  const row = Math.round((y - picture.y(0)) / (picture.y(1) - picture.y(0)));
  if (column < 0 || column >= picture.columns || row < 0 || row >= picture.rows) return undefined;
  return { x, y, column, row };
}

export function paintMap(context: CanvasRenderingContext2D, picture: MapPicture, how: { width: number; height: number; chosen: readonly [number, number]; fields: readonly PoseField[]; font: string }, colours: Palette): void {
  const f = frame(picture, how.width, how.height);
  context.fillStyle = colours.panel;
  context.fillRect(0, 0, how.width, how.height);
  context.drawImage(cellsOf(picture, colours), margin.left, margin.top, f.inner.width, f.inner.height);
  const [hField, vField] = how.fields;
  fadeOutside(context, f, how.fields, colours);
  context.strokeStyle = colours.text;
  context.lineWidth = 1.5;
  context.strokeRect(f.px(hField.min), f.py(vField.max), f.px(hField.max) - f.px(hField.min), f.py(vField.min) - f.py(vField.max));
  paintAxes(context, f, how, colours);
  const [cx, cy] = [f.px(how.chosen[0]), f.py(how.chosen[1])];
  context.beginPath();
  context.arc(cx, cy, 6, 0, 2 * Math.PI);
  context.moveTo(cx - 11, cy);
  context.lineTo(cx + 11, cy);
  context.moveTo(cx, cy - 11);
  context.lineTo(cx, cy + 11);
  context.stroke();
}

// One pixel per pose: the browser smooths between them when it is drawn larger.
function cellsOf(picture: MapPicture, colours: Palette): HTMLCanvasElement {
  const cells = document.createElement('canvas');
  [cells.width, cells.height] = [picture.columns, picture.rows];
  const context = cells.getContext('2d')!;
  picture.values.forEach((value, i) => {
    context.fillStyle = picture.unreachable[i] ? colours.muted : colourOf(picture, value, colours);
    context.fillRect(i % picture.columns, picture.rows - 1 - Math.floor(i / picture.columns), 1, 1);
  });
  return cells;
}

function fadeOutside(context: CanvasRenderingContext2D, f: ReturnType<typeof frame>, [h, v]: readonly PoseField[], colours: Palette): void {
  context.save();
  context.beginPath();
  context.rect(margin.left, margin.top, f.inner.width, f.inner.height);
  context.rect(f.px(h.min), f.py(v.max), f.px(h.max) - f.px(h.min), f.py(v.min) - f.py(v.max));
  context.clip('evenodd');
  context.globalAlpha = 0.6;
  context.fillStyle = colours.panel;
  context.fillRect(margin.left, margin.top, f.inner.width, f.inner.height);
  context.restore();
}

function paintAxes(context: CanvasRenderingContext2D, f: ReturnType<typeof frame>, how: { height: number; fields: readonly PoseField[]; font: string }, colours: Palette): void {
  context.font = `13px ${how.font}`;
  context.fillStyle = colours.muted;
  const bottom = how.height - margin.bottom;
  const across = ticks(f.ends[0], f.ends[1], 6);
  context.textAlign = 'center';
  context.textBaseline = 'top';
  tickTexts(across).forEach((text, i) => context.fillText(text, f.px(across[i]), bottom + 5));
  context.fillText(`${how.fields[0].symbol}, mm`, margin.left + f.inner.width / 2, bottom + 22);
  const up = ticks(f.ends[2], f.ends[3], 5);
  context.textAlign = 'right';
  context.textBaseline = 'middle';
  tickTexts(up).forEach((text, i) => context.fillText(text, margin.left - 6, f.py(up[i])));
  context.textAlign = 'left';
  context.fillText(`${how.fields[1].symbol}, mm`, 4, 10);
}

export function mapCsv(picture: MapPicture): string {
  const lines = [`# ${picture.title}`, `${picture.names[0]},${picture.names[1]},${picture.kind}_nm,outside,unreachable`];
  picture.values.forEach((value, i) => {
    lines.push(`${fixedPlain(picture.x(i % picture.columns))},${fixedPlain(picture.y(Math.floor(i / picture.columns)))},${value},${picture.outside[i] ? 1 : 0},${picture.unreachable[i] ? 1 : 0}`);
  });
  return lines.join('\n') + '\n';
}
const fixedPlain = (value: number) => String(Math.round(value * 1e9) / 1e9);
