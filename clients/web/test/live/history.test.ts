// What came live behind what was recorded.
import { expect, it } from 'vitest';
import { resetCellTime, takeCellTime } from '@/live/channels';
import { changeOf, Tail, usualStep } from '@/live/history';

it('knows how far apart live values usually are, whatever one gap is', () => {
  expect(usualStep([0, 36, 72, 900, 936])).toBe(36);
  expect(usualStep([5])).toBe(0);
  expect(usualStep([])).toBe(0);
});

it('says over which time a value changed, whatever the window is', () => {
  const track = { channel: 'air_degC', unit: 'degC', atMs: [0, 60e3, 120e3, 180e3], mean: [NaN, 20, 20.5, NaN] };
  expect(changeOf(track)).toEqual({ change: 0.5, seconds: 60 });
  expect(changeOf({ ...track, mean: [NaN, 20, NaN, NaN] })).toEqual({ change: NaN, seconds: NaN });
});

it('begins the tail anew when the clock is set back, and keeps it over a little jitter', () => {
  resetCellTime();
  const tail = new Tail();
  const track = { channel: 'x_mm', unit: 'mm', atMs: [], mean: [] };
  const take = (atMs: number, value: number) => {
    takeCellTime(atMs);
    tail.take(['x_mm'], () => [value, atMs]);
    return tail.behind(track, 0, Infinity).mean;
  };
  expect(take(7_200_000, 1)).toEqual([1]);
  expect(take(7_201_000, 2)).toEqual([1, 2]);
  expect(take(7_200_990, 3)).toEqual([1, 2]);
  expect(take(3_600_000, 4)).toEqual([4]);
  expect(take(3_601_000, 5)).toEqual([4, 5]);
});
