// What is what, and the values under the cursor. Of many lines the one pointed at here keeps its colour.
import { unitSign } from '@/format/units';
import { markLooks, marksInWords } from './marks';
import { markerShapes } from './markers';
import type { PlotSeries, PlotSpec } from './spec';
import { cursorText, valueAt } from './values';

function Swatch({ series }: { series: PlotSeries }) {
  const colour = series.marker === 'rejected' ? 'var(--bad)' : `var(--${series.colour})`;
  if (series.draw === 'markers') {
    const shape = markerShapes[series.marker ?? 'dot'];
    return (
      <svg width="12" height="12" viewBox="-6 -6 12 12" aria-hidden="true">
        <path d={shape.path} fill={shape.filled ? colour : 'none'} stroke={shape.filled ? 'none' : colour} stroke-width="1.75" />
      </svg>
    );
  }
  return (
    <svg width="18" height="10" aria-hidden="true">
      <path d="M0 5H18" stroke={colour} stroke-width="2.5" stroke-dasharray={series.dash?.join(' ') ?? (series.draw === 'dashed' ? '5 3' : undefined)} />
    </svg>
  );
}

export function Legend({ spec, cursor, onPoint, pointed }: {
  spec: PlotSpec;
  cursor: number | undefined; // x; undefined: not over the plot
  onPoint: (at: number | undefined) => void;
  pointed: number | undefined;
}) {
  const quiet = spec.series.some((one) => one.quiet);
  return (
    <div class="legend note">
      {spec.series.map((one, at) => (
        <span
          key={at}
          class={`legend-entry${one.quiet ? ' legend-quiet' : ''}${pointed === at ? ' legend-pointed' : ''}`}
          onPointerEnter={quiet ? () => onPoint(at) : undefined}
          onPointerLeave={quiet ? () => onPoint(undefined) : undefined}
        >
          <Swatch series={one} />
          {one.name}
          {one.axis === 'right' && !cursor && <span class="muted"> ({unitSign(one.unit)}, right)</span>}
          {cursor !== undefined && one.draw !== 'markers' && <span class="legend-value"> {valueAt(one, cursor)}</span>}
        </span>
      ))}
      {marksInWords(spec).map(({ kind, words, labels }) => (
        <span class="legend-entry muted" key={kind} title={labels}>
          <svg width="6" height="14" aria-hidden="true"><path d="M3 0V14" stroke={`var(--${markLooks[kind].colour})`} stroke-width="1.5" stroke-dasharray={markLooks[kind].dash.join(' ')} /></svg>
          {words}
        </span>
      ))}
      {cursor === undefined
        ? (spec.limits ?? []).map((limit) => <span class="legend-entry muted" key={limit.label}>╌ {limit.label}</span>)
        : <span class="legend-entry muted">{cursorText(spec, cursor)}</span>}
    </div>
  );
}
