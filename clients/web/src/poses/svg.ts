// The same shapes as a file for papers.
import type { Shape } from './shapes';

const n = (value: number) => String(Math.round(value * 10) / 10);
const escape = (text: string) => text.replaceAll('&', '&amp;').replaceAll('<', '&lt;').replaceAll('>', '&gt;');

function shapeSvg(shape: Shape): string {
  if (shape.kind === 'text')
    return `<text x="${n(shape.x)}" y="${n(shape.y)}" fill="${shape.colour}"${shape.strong ? ' font-weight="600"' : ''}>${escape(shape.text)}</text>`;
  if (shape.kind === 'line')
    return `<line x1="${n(shape.x1)}" y1="${n(shape.y1)}" x2="${n(shape.x2)}" y2="${n(shape.y2)}" stroke="${shape.colour}" stroke-width="${shape.width}"${shape.dash ? ' stroke-dasharray="4 4"' : ''}/>`;
  const { x, y, size: s, colour } = shape;
  if (shape.kind === 'dot') return `<circle cx="${n(x)}" cy="${n(y)}" r="${s}" fill="${colour}"/>`;
  if (shape.kind === 'ring') return `<circle cx="${n(x)}" cy="${n(y)}" r="${s}" fill="none" stroke="${colour}" stroke-width="1.5"/>`;
  const path = shape.kind === 'diamond'
    ? `M${n(x)} ${n(y - s)}L${n(x + s)} ${n(y)}L${n(x)} ${n(y + s)}L${n(x - s)} ${n(y)}Z`
    : `M${n(x - s)} ${n(y)}H${n(x + s)}M${n(x)} ${n(y - s)}V${n(y + s)}`;
  return `<path d="${path}" fill="none" stroke="${colour}" stroke-width="1.5"/>`;
}

export function shapesSvg(shapes: readonly Shape[], width: number, height: number, title: string, panel: string): string {
  return [
    `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" font-family="sans-serif" font-size="13" text-anchor="middle" dominant-baseline="middle">`,
    `<title>${escape(title)}</title>`,
    `<rect width="${width}" height="${height}" fill="${panel}"/>`,
    ...shapes.map(shapeSvg),
    '</svg>',
  ].join('\n');
}
