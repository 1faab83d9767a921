// A bar beside a number: the picture of a figure that stands in text next to it, so screen readers pass it over.
import type { Colour } from '@/plot/spec';
import './bar.css';

export function Bar({ share, low, high, colour = 'q1', faint }: {
  share: number; // 0 to 1 of the width
  low?: number; // a whisker from here ...
  high?: number; // ... to there, shares too
  colour?: Colour;
  faint?: boolean;
}) {
  const at = (value: number) => Math.min(100, Math.max(0, 100 * value));
  return (
    <svg class="bar-svg" viewBox="0 0 100 12" preserveAspectRatio="none" aria-hidden="true">
      <rect class="bar-track" x="0" y="0" width="100" height="12" rx="0.5" />
      <rect class={`bar-fill bar-${colour}${faint ? ' bar-faint' : ''}`} x="0" y="0" width={at(share)} height="12" />
      {low !== undefined && high !== undefined && (
        <path class="bar-whisker" d={`M${at(low)} 6H${at(high)}M${at(low)} 2V10M${at(high)} 2V10`} vector-effect="non-scaling-stroke" />
      )}
    </svg>
  );
}
