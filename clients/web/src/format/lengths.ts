// A length as the page shows it: nm below 100 um, mm above.
import { fixed, grouped } from './numbers';
import { nmFromMm } from './units';

export function lengthText(mm: number | undefined): { text: string; unit: 'nm' | 'mm' } {
  if (mm === undefined || !Number.isFinite(mm)) return { text: '–', unit: 'nm' };
  return Math.abs(mm) < 0.1 ? { text: fixed(nmFromMm(mm), 1), unit: 'nm' } : { text: grouped(mm, 6), unit: 'mm' };
}
