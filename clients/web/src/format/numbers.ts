// Numbers as people write them: a true minus, thin spaces in long figures, no more digits than asked for.
const thin = '\u2009';

function withSpaces(digits: string): string {
  if (digits.length <= 4) return digits;
  return digits.replace(/\B(?=(\d{3})+$)/g, thin);
}

// 12345.678 with 1 digit -> "12 345.7"; not a number -> "–".
export function fixed(value: number | undefined, digits = 0): string {
  if (value === undefined || !Number.isFinite(value)) return '–';
  const text = Math.abs(value).toFixed(digits);
  const [whole, fraction] = text.split('.');
  const sign = value < 0 && Number(text) !== 0 ? '−' : '';
  return sign + withSpaces(whole) + (fraction ? `.${fraction}` : '');
}

// With its sign always: "+41".
export function signed(value: number | undefined, digits = 0): string {
  const text = fixed(value, digits);
  return value !== undefined && value > 0 && Number(value.toFixed(digits)) !== 0 ? `+${text}` : text;
}

// To so many significant digits: for figures of accuracy ("43", "3.8", "0.041"). Whole numbers keep all their digits.
export function significant(value: number | undefined, figures = 2): string {
  if (value === undefined || !Number.isFinite(value)) return '–';
  if (value === 0) return '0';
  const before = Math.floor(Math.log10(Math.abs(Number(value.toPrecision(figures))))) + 1;
  return fixed(value, Math.max(0, figures - before));
}

// Digits that tell the two ends of a range apart: two of its span, no fewer than asked for, no more than nine.
export function digitsOfRange(low: number, high: number, least = 0): number {
  const span = Math.abs(high - low);
  return span > 0 && Number.isFinite(span) ? Math.min(9, Math.max(least, 1 - Math.floor(Math.log10(span)))) : least;
}

// "0.001 to 0.004", "−12 to 43".
export function rangeText(low: number, high: number, least = 0): string {
  const digits = digitsOfRange(low, high, least);
  return `${fixed(low, digits)} to ${fixed(high, digits)}`;
}

// 0.49998731 with 8 digits -> "0.499 987 31": results that are read aloud or copied by hand.
export function grouped(value: number | undefined, digits: number): string {
  const [whole, fraction] = fixed(value, digits).split('.');
  return fraction ? `${whole}.${fraction.replace(/(\d{3})(?=\d)/g, `$1${thin}`)}` : whole;
}

// A probability: "0.03", "< 1e-6".
export function probability(p: number | undefined): string {
  if (p === undefined || !Number.isFinite(p)) return '–';
  if (p < 1e-6) return '<\u20091e−6';
  if (p < 0.001) return p.toExponential(1).replace('-', '−');
  return significant(p, 2);
}

export const count = (n: bigint | number | undefined): string => fixed(n === undefined ? undefined : Number(n), 0);

// "1 row", "12 rows".
export const countRows = (n: bigint | number | undefined): string => `${count(n)} ${Number(n) === 1 ? 'row' : 'rows'}`;

// "row 4", "rows 4 to 9".
export const rowSpan = (first: bigint | number, last: bigint | number): string => (first === last ? `row ${count(first)}` : `rows ${count(first)} to ${count(last)}`);
