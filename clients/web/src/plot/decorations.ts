// What lies behind and between uPlot's lines: hatched gaps, bands, min-max fill, zero line, limits, markers.
import type uPlot from 'uplot';
import { markerShapes } from './markers';
import type { Palette } from './palette';
import type { PlotSeries, PlotSpec } from './spec';
import { gapsOf } from './ranges';

type Context = CanvasRenderingContext2D;

export const scaleOf = (one: { axis?: 'left' | 'right' }): 'y' | 'r' => (one.axis === 'right' ? 'r' : 'y');

function clipped(u: uPlot, draw: (ctx: Context) => void): void {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  draw(ctx);
  ctx.restore();
}

function hatch(ctx: Context, left: number, right: number, bbox: uPlot.BBox, colour: string, px: number): void {
  ctx.save();
  ctx.beginPath();
  ctx.rect(left, bbox.top, right - left, bbox.height);
  ctx.clip();
  ctx.beginPath();
  for (let x = left - bbox.height; x < right; x += 8 * px) {
    ctx.moveTo(x, bbox.top + bbox.height);
    ctx.lineTo(x + bbox.height, bbox.top);
  }
  ctx.strokeStyle = colour;
  ctx.lineWidth = 2 * px;
  ctx.stroke();
  ctx.restore();
}

function level(u: uPlot, ctx: Context, at: number, scale: string, colour: string, dash: number[], width: number): void {
  const y = u.valToPos(at, scale, true);
  ctx.beginPath();
  ctx.setLineDash(dash); // uPlot leaves the dash of its last line on the canvas
  ctx.moveTo(u.bbox.left, y);
  ctx.lineTo(u.bbox.left + u.bbox.width, y);
  ctx.strokeStyle = colour;
  ctx.lineWidth = width;
  ctx.stroke();
}

function fillBetween(u: uPlot, ctx: Context, one: PlotSeries, colour: string): void {
  if (!one.min || !one.max) return;
  const scale = scaleOf(one);
  const { min, max } = u.scales.x;
  ctx.fillStyle = colour;
  ctx.globalAlpha = 0.3;
  let start = -1;
  const flush = (end: number) => {
    if (start < 0) return;
    ctx.beginPath();
    for (let i = start; i < end; i++) ctx.lineTo(u.valToPos(one.x[i], 'x', true), u.valToPos(one.max![i], scale, true));
    for (let i = end - 1; i >= start; i--) ctx.lineTo(u.valToPos(one.x[i], 'x', true), u.valToPos(one.min![i], scale, true));
    ctx.fill();
    start = -1;
  };
  for (let i = 0; i < one.x.length; i++) {
    const seen = one.x[i] >= min! && one.x[i] <= max! && Number.isFinite(one.min[i]);
    if (!seen) flush(i);
    else if (start < 0) start = i;
  }
  flush(one.x.length);
  ctx.globalAlpha = 1;
}

export function drawBehind(u: uPlot, spec: PlotSpec, colours: Palette): void {
  const px = devicePixelRatio;
  clipped(u, (ctx) => {
    for (const gap of gapsOf(spec)) {
      hatch(ctx, u.valToPos(gap.from, 'x', true), u.valToPos(gap.to, 'x', true), u.bbox, colours.line, px);
    }
    for (const band of spec.bands ?? []) {
      const top = u.valToPos(band.to, 'y', true);
      ctx.fillStyle = colours[band.colour];
      ctx.globalAlpha = 0.12;
      ctx.fillRect(u.bbox.left, top, u.bbox.width, u.valToPos(band.from, 'y', true) - top);
      ctx.globalAlpha = 1;
    }
    if (spec.y.zero !== false) level(u, ctx, 0, 'y', colours.zero, [], 1.5 * px);
    for (const limit of spec.limits ?? []) level(u, ctx, limit.at, scaleOf(limit), colours.muted, [6 * px, 4 * px], 1.25 * px);
    for (const one of spec.series) fillBetween(u, ctx, one, colours[one.colour]);
  });
}

export function drawMarkers(u: uPlot, spec: PlotSpec, colours: Palette, chosen: number | undefined): void {
  const px = devicePixelRatio;
  const { min, max } = u.scales.x;
  clipped(u, (ctx) => {
    for (const one of spec.series) {
      if (one.draw !== 'markers') continue;
      const kind = one.marker ?? 'dot';
      const shape = new Path2D(markerShapes[kind].path);
      const scale = scaleOf(one);
      ctx.setLineDash([]);
      ctx.fillStyle = ctx.strokeStyle = kind === 'rejected' ? colours.bad : colours[one.colour];
      ctx.lineWidth = kind === 'rejected' ? 2 : 1.5;
      for (let i = 0; i < one.x.length; i++) {
        if (one.x[i] < min! || one.x[i] > max! || !Number.isFinite(one.y[i])) continue;
        ctx.setTransform(px, 0, 0, px, u.valToPos(one.x[i], 'x', true), u.valToPos(one.y[i], scale, true));
        if (markerShapes[kind].filled) ctx.fill(shape);
        else ctx.stroke(shape);
        if (chosen !== undefined && one.keys?.[i] === chosen) ringAround(ctx, colours);
      }
      ctx.setTransform(1, 0, 0, 1, 0, 0);
    }
  });
}

function ringAround(ctx: Context, colours: Palette): void {
  ctx.save();
  ctx.beginPath();
  ctx.arc(0, 0, 8, 0, 2 * Math.PI);
  ctx.strokeStyle = colours.text;
  ctx.lineWidth = 2;
  ctx.stroke();
  ctx.restore();
}
