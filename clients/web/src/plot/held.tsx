// A plot that follows now says nothing; one that zoom or pan hold says since when it stands and how to let go.
import type { Signal } from '@preact/signals';
import { clock, duration } from '@/format/time';
import type { Range } from './ranges';
import { wholeRange } from './ranges';
import type { PlotSpec } from './spec';

export function Held({ spec, range, live }: { spec: PlotSpec; range: Signal<Range | undefined>; live: boolean }) {
  if (range.value === undefined) return null;
  const whole = wholeRange(spec);
  const behindS = whole && spec.x.unit === 'h' ? (whole.to - range.value.to) * 3600 : 0;
  return (
    <span class="held">
      {live && spec.x.startMs !== undefined && (
        <> · held at {clock(spec.x.startMs + range.value.to * 3600e3)}{behindS > 1 && `, ${duration(behindS)} behind`}</>
      )}{' '}
      <button type="button" class="link" onClick={() => (range.value = undefined)}>{live ? 'Back to live' : 'Show all'}</button>
    </span>
  );
}
