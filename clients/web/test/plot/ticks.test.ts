import { describe, expect, it } from 'vitest';
import { paddedRange, tickTexts, ticks, xTicks } from '@/plot/ticks';

describe('ticks', () => {
  it('stand at 1, 2 or 5 times a power of ten within the range', () => {
    expect(ticks(-37, 51, 5)).toEqual([-20, 0, 20, 40]);
    expect(ticks(20.8, 21.8, 5).length).toBe(6);
  });
  it('carry no more digits than their step', () => {
    expect(tickTexts(ticks(20.8, 21.8, 5))).toEqual(['20.8', '21.0', '21.2', '21.4', '21.6', '21.8']);
    expect(tickTexts([-20, 0, 20])).toEqual(['−20', '0', '20']);
  });
  it('are at least two, or a scale cannot be read', () => {
    expect(ticks(-1.7, 1.8, 2)).toEqual([-1, 0, 1]);
    for (let low = -9.7; low < 10; low += 0.37) for (const wanted of [1.5, 2, 3]) expect(ticks(low, low + 3.1, wanted).length).toBeGreaterThan(1);
  });
  it('of counts stand at whole numbers', () => {
    expect(xTicks({ whole: true })(0, 6, 20)).toEqual([0, 1, 2, 3, 4, 5, 6]);
    expect(xTicks({})(0, 6, 20)[1]).toBe(0.5);
  });
  it('survive a constant', () => {
    const [low, high] = paddedRange(5, 5);
    expect(low).toBeLessThan(5);
    expect(high).toBeGreaterThan(5);
  });
});
