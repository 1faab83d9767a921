// Drift of the zero as numbers: what the instruments read at each return to zero, minus the first of the same datum. The page and the
// report draw it.
import { isLength, kindOf, nmFrom, splitChannel } from '@/format/units';

export interface ZeroDrift {
  lengths: string[]; // "x_mm", "x_um" of an imported file
  hours: number[];
  nm: number[][]; // per length
  rows: number[];
}

export interface ZeroReturn {
  datum: bigint | number; // NaN: of a report that does not say
  hours: number;
  row: number;
  value: (channel: string) => number; // in the channel's unit
}

export function driftOf(returns: readonly ZeroReturn[], lengths: readonly string[]): ZeroDrift {
  const first = new Map<bigint | number, ZeroReturn>();
  for (const one of returns) if (!first.has(one.datum)) first.set(one.datum, one);
  return {
    lengths: [...lengths],
    hours: returns.map((one) => one.hours),
    nm: lengths.map((channel) => returns.map((one) => nmFrom(one.value(channel) - first.get(one.datum)!.value(channel), splitChannel(channel).unit))),
    rows: returns.map((one) => one.row),
  };
}

// Lengths that the points hold, in whatever unit of length: those of the pose, or all that are neither a motor coordinate nor the spread
// of another channel.
export function lengthsOf(channels: readonly string[]): string[] {
  const all = channels.filter((name) => isLength(splitChannel(name).unit));
  const lengths = all.filter((name) => kindOf(name) === 'pose');
  return lengths.length > 0 ? lengths : all.filter((name) => kindOf(name) !== 'motor' && !/^(goal_|x_target)/.test(name) && !/_(cmd|std)_/.test(name));
}
