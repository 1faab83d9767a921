// [Export]: the plot as PNG for a message, SVG for a paper, CSV for anything; [Table] reads it on the page.
import type uPlot from 'uplot';
import { useRef } from 'preact/hooks';
import { download, fileName } from '@/ui/download';
import { fontOf } from './draw';
import { palette } from './palette';
import type { Range } from './ranges';
import type { PlotSpec } from './spec';
import { svgOf } from './svg';
import { csvOf } from './values';

const stem = (spec: PlotSpec) => spec.file ?? fileName(spec.title);

// The canvas as it stands, with title and unit above it: they are text of the page otherwise.
function saveAsPng(spec: PlotSpec, u: uPlot): void {
  const px = devicePixelRatio;
  const colours = palette();
  const canvas = document.createElement('canvas');
  const head = 56 * px;
  canvas.width = u.ctx.canvas.width + 24 * px;
  canvas.height = u.ctx.canvas.height + head + 8 * px;
  const ctx = canvas.getContext('2d')!;
  ctx.fillStyle = colours.panel;
  ctx.fillRect(0, 0, canvas.width, canvas.height);
  ctx.drawImage(u.ctx.canvas, 12 * px, head);
  ctx.scale(px, px);
  ctx.fillStyle = colours.text;
  ctx.font = fontOf.replace('12px', '600 15px');
  ctx.fillText(spec.title, 12, 22);
  ctx.font = fontOf;
  let x = 12;
  for (const one of spec.series) {
    ctx.fillStyle = one.marker === 'rejected' ? colours.bad : colours[one.colour];
    ctx.fillRect(x, 36, 14, 3);
    ctx.fillStyle = colours.muted;
    ctx.fillText(one.name, x + 18, 42);
    x += ctx.measureText(one.name).width + 36;
  }
  ctx.fillStyle = colours.muted;
  ctx.fillText(spec.what, Math.max(x + 8, 12), 42);
  canvas.toBlob((blob) => blob && download(`${stem(spec)}.png`, blob));
}

export function ExportMenu({ spec, range, drawing, table, onTable }: {
  spec: PlotSpec;
  range: () => Range;
  drawing: () => uPlot | undefined;
  table: boolean;
  onTable: () => void;
}) {
  const menu = useRef<HTMLDetailsElement>(null);
  const choose = (act: () => void) => () => {
    act();
    menu.current?.removeAttribute('open');
  };
  const svg = () => {
    const u = drawing();
    download(`${stem(spec)}.svg`, svgOf(spec, range(), u?.width ?? 720, (u?.height ?? 260) + 64), 'image/svg+xml');
  };
  return (
    <span class="plot-tools">
      <button type="button" class="tool" aria-pressed={table} onClick={onTable}>Table</button>
      <details class="menu" ref={menu} onKeyDown={(event) => event.key === 'Escape' && menu.current?.removeAttribute('open')}>
        <summary class="tool">Export</summary>
        <div class="menu-items">
          <button type="button" onClick={choose(() => { const u = drawing(); if (u) saveAsPng(spec, u); })}>PNG</button>
          <button type="button" onClick={choose(svg)}>SVG</button>
          <button type="button" onClick={choose(() => download(`${stem(spec)}.csv`, csvOf(spec, location.href), 'text/csv'))}>CSV</button>
        </div>
      </details>
    </span>
  );
}
