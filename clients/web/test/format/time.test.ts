import { describe, expect, it } from 'vitest';
import { duration, fromUtc, ms, timestampOf, utc } from '@/format/time';

describe('times', () => {
  it.each([
    [0.4, '0.4 s'],
    [48, '48 s'],
    [560, '9 min 20 s'],
    [600, '10 min'],
    [21900, '6 h 05 min'],
    [219600, '2 d 13 h'],
  ])('writes %s s as %s', (seconds, text) => expect(duration(seconds)).toBe(text));

  it('goes to an address and back', () => {
    const at = Date.UTC(2011, 4, 13, 5, 40, 12);
    expect(utc(at)).toBe('2011-05-13T05:40:12Z');
    expect(fromUtc(utc(at))).toBe(at);
    expect(fromUtc('yesterday')).toBeUndefined();
  });

  it('goes to a proto and back', () => expect(ms(timestampOf(-1500.25))).toBeCloseTo(-1500.25, 6));
});
