// A channel that fell silent in a live plot: its gap reaches to now, and the cursor reads no old value there.
import { describe, expect, it } from 'vitest';
import type { History } from '@/live/history';
import { environmentPlot } from '@/parts/history_plot';
import { withTimeMarks } from '@/plot/marks';
import { gapsOf, wholeRange } from '@/plot/ranges';
import type { PlotSpec } from '@/plot/spec';
import { valueAt } from '@/plot/values';

const hour = 3600e3;
const midnight = Date.UTC(2026, 4, 15);
// Readings every minute of a window from 06:00 to 12:00; bucketS 30 s: a value holds for 5 min.
const spec = (...spans: [from: number, to: number][]): PlotSpec => {
  const history: History = {
    fromMs: midnight + 6 * hour, toMs: midnight + 12 * hour, bucketS: 30, failure: undefined, waiting: false, again: () => undefined,
    of: (channel) => {
      const [from, to] = spans[Number(channel[1])];
      const atMs = Array.from({ length: Math.max(0, Math.round((to - from) * 60)) }, (_, i) => midnight + from * hour + i * 60e3);
      return { channel, unit: 'degC', atMs, mean: atMs.map(() => 21) };
    },
  };
  return environmentPlot('Temperatures', spans.map((_, i) => `t${i}_degC`), history);
};
const near = (hours: number) => expect.closeTo(hours, 1) as number;

describe('a live plot', () => {
  it('spans its window, also where the channel fell silent', () => {
    expect(wholeRange(spec([6, 9]))).toEqual({ from: 6, to: 12 });
  });
  it('is hatched from the last value to now, and from the start of the window to the first', () => {
    expect(gapsOf(spec([7, 9]))).toEqual([{ from: 6, to: near(7) }, { from: near(9), to: 12 }]);
    expect(gapsOf(spec([6, 12]))).toEqual([]);
    expect(gapsOf(spec([6, 11.97]))).toEqual([]); // within what a value holds
  });
  it('is hatched where all of its channels are silent, also one that was never read', () => {
    expect(gapsOf(spec([6, 9], [6, 12]))).toEqual([]);
    expect(gapsOf(spec([6, 9], [6, 6], [8, 10]))).toEqual([{ from: near(10), to: 12 }]);
  });
  it('has no value under the cursor beyond the ends of the channel', () => {
    const [series] = spec([7, 9]).series;
    expect(valueAt(series, 8.9)).toContain('21');
    expect(valueAt(series, 9.05)).toContain('21');
    for (const x of [6.5, 9.5, 12]) expect(valueAt(series, x)).toContain('–');
  });
  it('shows marks in its gap', () => {
    const restart = { atMs: midnight + 11 * hour, kind: 'restart' as const, label: 'a restarted daemon went on' };
    expect(withTimeMarks(spec([6, 9]), [restart]).marks).toHaveLength(1);
  });
});

it('reads no old value in a gap between two values, and each one along a line', () => {
  const one = { name: 't', unit: 'degC', colour: 'q1' as const, holds: 0.1, x: [0, 1, 2.5, 4, 5], y: [20, 21, NaN, 24, 25] };
  expect(valueAt(one, 0.4)).toContain('20');
  expect(valueAt(one, 1.05)).toContain('21');
  expect(valueAt(one, 1.5)).toContain('–');
  expect(valueAt(one, 3.5)).toContain('–');
  expect(valueAt({ ...one, holds: undefined }, 9)).toContain('25');
});
