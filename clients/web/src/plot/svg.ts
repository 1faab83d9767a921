// A plot as SVG for papers: light colours on white, the same ticks and marks as on the page.
import { withUnit } from './values';
import { markLooks, marksInWords, marksSvg } from './marks';
import { markerShapes } from './markers';
import { paletteOf } from './palette';
import { gapsOf, yRange, type Range } from './ranges';
import type { PlotSeries, PlotSpec } from './spec';
import { tickTexts, ticks, xTexts, xTicks } from './ticks';

const font = 'font-family="Helvetica, Arial, sans-serif"';
const colours = paletteOf(false);
const escaped = (text: string) => text.replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);
const r = (value: number) => Math.round(value * 100) / 100;

interface Frame {
  left: number;
  top: number;
  width: number;
  height: number;
  x: (value: number) => number;
  y: (value: number, axis?: 'left' | 'right') => number;
}

function lineOf(one: PlotSeries, frame: Frame, range: Range): string {
  let path = '';
  let pen = 'M';
  for (let i = 0; i < one.x.length; i++) {
    if (one.x[i] < range.from || one.x[i] > range.to || !Number.isFinite(one.y[i])) {
      pen = 'M';
      continue;
    }
    const here = `${r(frame.x(one.x[i]))} ${r(frame.y(one.y[i], one.axis))}`;
    path += one.draw === 'steps' && pen === 'L' ? `H${r(frame.x(one.x[i]))}V${r(frame.y(one.y[i], one.axis))}` : `${pen}${here}`;
    pen = 'L';
  }
  const dash = one.dash ? ` stroke-dasharray="${one.dash.join(' ')}"` : one.draw === 'dashed' ? ' stroke-dasharray="5 4"' : '';
  const colour = colours[one.colour];
  return `<path d="${path}" fill="none" stroke="${colour}" stroke-width="${one.quiet ? 0.75 : 1.25}" stroke-linejoin="round"${dash}/>`;
}

function bandOf(one: PlotSeries, frame: Frame, range: Range): string {
  if (!one.min || !one.max) return '';
  const seen = Array.from({ length: one.x.length }, (_, i) => i).filter(
    (i) => one.x[i] >= range.from && one.x[i] <= range.to && Number.isFinite(one.min![i]),
  );
  const up = seen.map((i) => `${r(frame.x(one.x[i]))} ${r(frame.y(one.max![i], one.axis))}`);
  const down = seen.reverse().map((i) => `${r(frame.x(one.x[i]))} ${r(frame.y(one.min![i], one.axis))}`);
  return up.length ? `<path d="M${[...up, ...down].join('L')}Z" fill="${colours[one.colour]}" fill-opacity="0.25"/>` : '';
}

function markersOf(one: PlotSeries, frame: Frame, range: Range, id: string): string {
  const kind = one.marker ?? 'dot';
  const colour = kind === 'rejected' ? colours.bad : colours[one.colour];
  const ink = markerShapes[kind].filled ? `fill="${colour}"` : `fill="none" stroke="${colour}" stroke-width="1.5"`;
  let out = `<defs><path id="${id}" d="${markerShapes[kind].path}" ${ink}/></defs>`;
  for (let i = 0; i < one.x.length; i++) {
    if (one.x[i] < range.from || one.x[i] > range.to || !Number.isFinite(one.y[i])) continue;
    out += `<use href="#${id}" x="${r(frame.x(one.x[i]))}" y="${r(frame.y(one.y[i], one.axis))}"/>`;
  }
  return out;
}

function axes(spec: PlotSpec, frame: Frame, range: Range, left: [number, number], right: [number, number] | undefined): string {
  const text = (x: number, y: number, words: string, anchor: string) =>
    `<text x="${r(x)}" y="${r(y)}" text-anchor="${anchor}" fill="${colours.muted}">${escaped(words)}</text>`;
  const line = (x1: number, y1: number, x2: number, y2: number, more: string) =>
    `<path d="M${r(x1)} ${r(y1)}L${r(x2)} ${r(y2)}" ${more}/>`;
  const grid = `stroke="${colours.grid}"`;
  const end = frame.left + frame.width;
  const foot = frame.top + frame.height;
  const xs = xTicks(spec.x)(range.from, range.to, frame.width / 70);
  const ys = ticks(left[0], left[1], frame.height / 30);
  const rs = right ? ticks(right[0], right[1], frame.height / 30) : [];
  const below = xTexts(spec.x)(xs), yTexts = tickTexts(ys), rTexts = tickTexts(rs);
  return [
    ...xs.flatMap((at, i) => [line(frame.x(at), frame.top, frame.x(at), foot, grid), text(frame.x(at), foot + 16, below[i], 'middle')]),
    ...ys.flatMap((at, i) => [line(frame.left, frame.y(at), end, frame.y(at), grid), text(frame.left - 6, frame.y(at) + 4, yTexts[i], 'end')]),
    ...rs.map((at, i) => text(end + 6, frame.y(at, 'right') + 4, rTexts[i], 'start')),
    spec.y.zero === false ? '' : line(frame.left, frame.y(0), end, frame.y(0), `stroke="${colours.zero}" stroke-width="1.5"`),
    ...(spec.limits ?? []).map((limit) =>
      line(frame.left, frame.y(limit.at, limit.axis), end, frame.y(limit.at, limit.axis), `stroke="${colours.muted}" stroke-dasharray="6 4"`)),
  ].join('');
}

// Every series with its line as drawn, then the marks; as many rows as the width needs.
function keyOf(spec: PlotSpec, width: number): { rows: number; svg: string } {
  let [x, y, svg] = [0, 35, ''];
  const add = (sign: string, words: string) => {
    const wide = 22 + 7 * words.length + 14;
    if (x > 0 && x + wide > width) [x, y] = [0, y + 16];
    svg += `<g transform="translate(${x} ${y})">${sign}<text x="22" y="0" fill="${colours.muted}">${escaped(words)}</text></g>`;
    x += wide;
  };
  for (const one of spec.series) {
    const colour = one.marker === 'rejected' ? colours.bad : colours[one.colour];
    const dash = one.dash?.join(' ') ?? (one.draw === 'dashed' ? '5 4' : 'none');
    const shape = markerShapes[one.marker ?? 'dot'];
    const sign = one.draw === 'markers'
      ? `<path transform="translate(9 -4)" d="${shape.path}" ${shape.filled ? `fill="${colour}"` : `fill="none" stroke="${colour}" stroke-width="1.5"`}/>`
      : `<path d="M0 -4H18" stroke="${colour}" stroke-width="2" stroke-dasharray="${dash}"/>`;
    add(sign, withUnit(one.name, one.axis === 'right' ? one.unit : ''));
  }
  for (const { kind, words } of marksInWords(spec))
    add(`<path d="M9 -11V2" stroke="${colours[markLooks[kind].colour]}" stroke-width="1.5" stroke-dasharray="${markLooks[kind].dash.join(' ') || 'none'}"/>`, words);
  return { rows: 1 + (y - 35) / 16, svg };
}

// unique: start of the ids within, for several pictures in one document.
export function svgOf(spec: PlotSpec, range: Range, width: number, height: number, unique = ''): string {
  const left = yRange(spec, 'left', range);
  const right = spec.right ? yRange(spec, 'right', range) : undefined;
  const key = keyOf(spec, width);
  const top = 64 + 16 * (key.rows - 1);
  const frame: Frame = {
    left: 60, top, width: width - 60 - (right ? 56 : 16), height: height - top - 28,
    x: (value) => frame.left + ((value - range.from) / (range.to - range.from)) * frame.width,
    y: (value, axis) => {
      const [low, high] = axis === 'right' && right ? right : left;
      return frame.top + (1 - (value - low) / (high - low)) * frame.height;
    },
  };
  const clip = `M${frame.left} ${frame.top}h${frame.width}v${frame.height}h${-frame.width}Z`;
  const marks = spec.series.map((one, at) => (one.draw === 'markers' ? markersOf(one, frame, range, `${unique}m${at}`) : bandOf(one, frame, range) + lineOf(one, frame, range)));
  const gaps = gapsOf(spec).map(({ from, to }) =>
    `<rect x="${r(frame.x(from))}" y="${frame.top}" width="${r(frame.x(to) - frame.x(from))}" height="${frame.height}" fill="url(#${unique}gap)"/>`);
  const bands = (spec.bands ?? []).map((band) =>
    `<rect x="${frame.left}" y="${r(frame.y(band.to))}" width="${frame.width}" height="${r(frame.y(band.from) - frame.y(band.to))}" fill="${colours[band.colour]}" fill-opacity="0.12"/>`);
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" ${font} font-size="12">
<title>${escaped(spec.title)}</title><rect width="${width}" height="${height}" fill="#fff"/>
<defs><clipPath id="${unique}in"><path d="${clip}"/></clipPath><pattern id="${unique}gap" width="8" height="8" patternUnits="userSpaceOnUse"><path d="M0 8 8 0" stroke="${colours.line}" stroke-width="2"/></pattern></defs>
<text x="0" y="16" font-size="15" font-weight="600" fill="${colours.text}">${escaped(spec.title)}</text>
${key.svg}<text x="0" y="${top - 12}" fill="${colours.muted}">${escaped(spec.what)}</text>
<g clip-path="url(#${unique}in)">${gaps.join('')}${bands.join('')}</g>${axes(spec, frame, range, left, right)}
<g clip-path="url(#${unique}in)">${marksSvg(spec, range, frame.x, frame.top, frame.height, colours, escaped)}</g>
<g clip-path="url(#${unique}in)">${marks.join('')}</g></svg>
`;
}
