// Channels end in their unit ("q1_mm", "t07_degC"). What stands on the page: the unit's sign, the symbol, and lengths in
// nm where nm is meant. No prefix is made up: only mm <-> nm and degC <-> mK, by these functions.
const signs: Record<string, string> = { degC: '°C', pct: '%', deg: '°', um: 'µm', '1': '' };

export const unitSign = (unit: string): string => signs[unit] ?? unit;

export function splitChannel(channel: string): { symbol: string; unit: string } {
  const at = channel.lastIndexOf('_');
  return at < 0 ? { symbol: channel, unit: '' } : { symbol: channel.slice(0, at), unit: channel.slice(at + 1) };
}

export const nmFromMm = (mm: number): number => mm * 1e6;
export const mkFromKelvin = (kelvin: number): number => kelvin * 1e3;

// Digits after the point that a live value of this unit is worth; lengths to the nanometre.
export function liveDigits(unit: string): number {
  switch (unit) {
    case 'mm': return 6;
    case 'um': return 3;
    case 'nm': return 1;
    case 'degC': return 3;
    case 'arcsec': return 2;
    case 'N': return 3;
    case 'hPa': return 2;
    case 'pct': return 1;
    default: return 3;
  }
}
