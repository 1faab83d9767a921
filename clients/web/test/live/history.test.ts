// What came live behind what was recorded.
import { expect, it } from 'vitest';
import { usualStep } from '@/live/history';

it('knows how far apart live values usually are, whatever one gap is', () => {
  expect(usualStep([0, 36, 72, 900, 936])).toBe(36);
  expect(usualStep([5])).toBe(0);
  expect(usualStep([])).toBe(0);
});
