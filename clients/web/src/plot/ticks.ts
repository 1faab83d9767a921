// Ticks of our own: steps of 1, 2 or 5 times a power of ten, never more digits than the step needs.
import { fixed } from '@/format/numbers';

export function niceStep(range: number, wanted: number): number {
  const rough = range / Math.max(1, wanted);
  const power = 10 ** Math.floor(Math.log10(rough));
  const lead = rough / power;
  return (lead <= 1 ? 1 : lead <= 2 ? 2 : lead <= 5 ? 5 : 10) * power;
}

export function ticks(low: number, high: number, wanted: number): number[] {
  if (!(high > low)) return [low];
  // A scale needs two numbers to be read; a low plot may have room for one of the wanted step only. A step of a fifth always does.
  for (let n = wanted; ; n += 1) {
    const at = ticksEvery(niceStep(high - low, n), low, high);
    if (at.length > 1 || n > 5) return at;
  }
}

function ticksEvery(step: number, low: number, high: number): number[] {
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, i) => (first + i) * step);
}

export function tickTexts(at: readonly number[]): string[] {
  const step = at.length > 1 ? at[1] - at[0] : Math.abs(at[0] ?? 1) || 1;
  const digits = Math.min(9, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
  return at.map((value) => fixed(Math.abs(value) < step * 1e-6 ? 0 : value, digits));
}

// A range that shows everything with 5 % of room; constants get room too.
export function paddedRange(low: number, high: number): [number, number] {
  if (!(low <= high)) return [-1, 1];
  const room = high > low ? (high - low) * 0.05 : Math.abs(high) * 0.05 || 1;
  return [low - room, high + room];
}

const clockSteps = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 10800, 21600, 43200, 86400];

// Of an axis in hours since a local midnight: round times of day.
export function clockTicks(low: number, high: number, wanted: number): number[] {
  const rough = ((high - low) * 3600) / Math.max(1, wanted);
  const step = (clockSteps.find((one) => one >= rough) ?? Math.ceil(rough / 86400) * 86400) / 3600;
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, i) => (first + i) * step);
}

export function clockTexts(at: readonly number[]): string[] {
  const two = (n: number) => String(n).padStart(2, '0');
  const withSeconds = at.length > 1 && at[1] - at[0] < 1 / 60 - 1e-9;
  return at.map((hours) => {
    const s = ((Math.round(hours * 3600) % 86400) + 86400) % 86400;
    return `${two(Math.floor(s / 3600))}:${two(Math.floor(s / 60) % 60)}${withSeconds ? `:${two(s % 60)}` : ''}`;
  });
}

// The x axis of a plot, as its spec wants it.
const wholeTicks = (low: number, high: number, wanted: number): number[] =>
  ticksEvery(Math.max(1, niceStep(Math.max(high - low, 1), wanted)), low, high);

export const xTicks = (x: { clock?: boolean; whole?: boolean }) => (x.clock ? clockTicks : x.whole ? wholeTicks : ticks);
export const xTexts = (x: { clock?: boolean }) => (x.clock ? clockTexts : tickTexts);
