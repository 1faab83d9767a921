// Draws a PlotSpec.
import type { Signal } from '@preact/signals';
import type { PlotSpec } from './spec';

export interface Range {
  from: number;
  to: number; // in the unit of x
}

export interface PlotProps {
  spec: PlotSpec;
  height?: number; // px of the drawing, 200 unless told
  group?: string; // plots of one group share the cursor
  range?: Signal<Range | undefined>; // shared zoom; undefined: everything (or live)
  live?: boolean; // follows now, unless zoomed: then it says "held"
  chosen?: Signal<number | undefined>; // key of the point that is marked everywhere
  onPick?: (key: number) => void; // a marker was chosen
}

export function Plot({ spec, height = 200 }: PlotProps) {
  return (
    <figure class="plot">
      <figcaption>{spec.title}</figcaption>
      <p class="note muted">{spec.why ?? spec.what} ({height} px)</p>
    </figure>
  );
}
