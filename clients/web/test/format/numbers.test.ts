import { describe, expect, it } from 'vitest';
import { countRows, fixed, grouped, probability, rangeText, rowSpan, signed, significant } from '@/format/numbers';

describe('numbers', () => {
  it.each([
    [12345.678, 1, '12\u2009345.7'],
    [-12.34, 1, '−12.3'],
    [-0.04, 1, '0.0'],
    [1234, 0, '1234'],
    [NaN, 1, '–'],
    [undefined, 0, '–'],
  ])('writes %s with %s digits as %s', (value, digits, text) => expect(fixed(value, digits)).toBe(text));

  it('keeps the sign of a change', () => {
    expect(signed(41, 0)).toBe('+41');
    expect(signed(-41, 0)).toBe('−41');
    expect(signed(0.01, 1)).toBe('0.0');
  });

  it('shows no more digits than an accuracy supports, and all of a whole number', () => {
    expect(significant(3.82)).toBe('3.8');
    expect(significant(164.3)).toBe('164');
    expect(significant(0.0412)).toBe('0.041');
    expect(significant(9.96)).toBe('10');
  });

  it.each([
    [0.001, 0.004, '0.0010 to 0.0040'],
    [-12.5, 43, '−12.50 to 43.00'],
    [20.1, 20.1, '20.10 to 20.10'],
    [1, 1 + 1e-12, '1.000000000 to 1.000000000'],
  ])('tells the ends %s and %s of a range apart', (low, high, text) => expect(rangeText(low, high, 2)).toBe(text));

  it('counts one row as one', () => {
    expect([0, 1, 1n, 12n].map(countRows)).toEqual(['0 rows', '1 row', '1 row', '12 rows']);
    expect(rowSpan(4n, 4n)).toBe('row 4');
    expect(rowSpan(4n, 9n)).toBe('rows 4 to 9');
  });

  it('groups decimals for reading aloud', () => expect(grouped(0.49998731, 8)).toBe('0.499\u2009987\u200931'));

  it('never writes a probability as zero', () => {
    expect(probability(1e-9)).toBe('<\u20091e−6');
    expect(probability(0.034)).toBe('0.034');
  });
});
