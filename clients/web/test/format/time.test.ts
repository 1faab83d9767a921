import { afterAll, beforeAll, describe, expect, it, vi } from 'vitest';
import { dayClock, duration, fromUtc, ms, timestampOf, utc } from '@/format/time';

describe('times', () => {
  it.each([
    [0.4, '0.4 s'],
    [48, '48 s'],
    [560, '9 min 20 s'],
    [600, '10 min'],
    [21900, '6 h 05 min'],
    [219600, '2 d 13 h'],
  ])('writes %s s as %s', (seconds, text) => expect(duration(seconds)).toBe(text));

  it('names the weekday within six days of now, and the date elsewhere', () => {
    const sunday = Date.UTC(2011, 4, 15, 7, 40);
    const days = (n: number) => dayClock(sunday, sunday + n * 86400e3);
    expect([0, 5.9, -5.9].map(days)).toEqual(Array(3).fill('Sun 07:40 UTC'));
    expect([6, 7, 21, -7, NaN].map(days)).toEqual(Array(5).fill('2011-05-15 07:40 UTC'));
    expect(dayClock(undefined, sunday)).toBe('–');
  });

  it('goes to an address and back', () => {
    const at = Date.UTC(2011, 4, 13, 5, 40, 12);
    expect(utc(at)).toBe('2011-05-13T05:40:12Z');
    expect(fromUtc(utc(at))).toBe(at);
    expect(fromUtc('yesterday')).toBeUndefined();
  });

  describe('in a browser of another zone', () => {
    beforeAll(() => void vi.stubEnv('TZ', 'Europe/Zurich'));
    afterAll(() => void vi.unstubAllEnvs());

    it('have that zone in this test', () => expect(new Date(0).getTimezoneOffset()).toBe(-60));
    it.each([
      ['2026-12-25T23:00:00Z', Date.UTC(2026, 11, 25, 23)],
      ['2026-07-25T23:00:00.25Z', Date.UTC(2026, 6, 25, 23, 0, 0, 250)],
      ['2024-02-29T00:00:00.000000000Z', Date.UTC(2024, 1, 29)],
    ])('read %s as the UTC that it says', (text, at) => expect(fromUtc(text)).toBe(at));
    it.each([
      '', '1', 'Dec 25', '2026-12-25', '2026-12-25T23:00', '2026-12-25T23:00Z', '2026-12-25T23:00:00', '2026-12-25 23:00:00Z', '2026-12-25T23:00:00+01:00',
      '2026-12-25T23:00:00.Z', '2026-12-25T23:00:00.1234567890Z', '2026-02-30T00:00:00Z', '2026-13-01T00:00:00Z', '2026-12-25T24:00:00Z',
      '2026-12-25T23:59:60Z', '1969-12-31T23:59:59Z', '2262-01-01T00:00:00Z', ' 2026-12-25T23:00:00Z', '2026-12-25t23:00:00z',
    ])('refuse "%s", as the daemon does', (text) => expect(fromUtc(text)).toBeUndefined());
  });

  it('goes to a proto and back', () => expect(ms(timestampOf(-1500.25))).toBeCloseTo(-1500.25, 6));
});
