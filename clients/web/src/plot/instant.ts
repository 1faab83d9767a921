// One instant in every plot against time, in all views: a click pins it, the bar moves it or lets it go.
import { signal } from '@preact/signals';
import type { Range } from './ranges';
import type { PlotSpec } from './spec';

export interface Pinned {
  atMs: number;
  fromMs: number; // range of the plot in which it was pinned
  toMs: number;
}

export const pinned = signal<Pinned | undefined>(undefined);

export function pin(spec: PlotSpec, x: number, seen: Range): void {
  const startMs = spec.x.startMs;
  if (startMs === undefined || spec.x.unit !== 'h') return;
  const ms = (hours: number) => startMs + hours * 3600e3;
  pinned.value = { atMs: ms(x), fromMs: ms(seen.from), toMs: ms(seen.to) };
}

// In the unit of x; undefined: none, not within what is seen, or no plot against time.
export function pinnedX(spec: PlotSpec, seen: Range): number | undefined {
  if (pinned.value === undefined || spec.x.startMs === undefined || spec.x.unit !== 'h') return undefined;
  const x = (pinned.value.atMs - spec.x.startMs) / 3600e3;
  return x >= seen.from && x <= seen.to ? x : undefined;
}
