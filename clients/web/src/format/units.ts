// Channels end in their unit ("q1_mm", "t07_degC"). What stands on the page: the unit's sign, the symbol, and lengths in
// nm where nm is meant. No prefix is made up: only a length's unit to nm or mm and degC <-> mK, by these functions.
const signs: Record<string, string> = { degC: '°C', pct: '%', deg: '°', um: 'µm', '1': '' };

export const unitSign = (unit: string): string => signs[unit] ?? unit;

export function splitChannel(channel: string): { symbol: string; unit: string } {
  const at = channel.lastIndexOf('_');
  return at < 0 ? { symbol: channel, unit: '' } : { symbol: channel.slice(0, at), unit: channel.slice(at + 1) };
}

// Robot of a channel, with its dot: "mn." of "mn.q1_mm"; "" where the cell has one robot only.
export const robotOf = (channel: string): string => channel.slice(0, channel.lastIndexOf('.') + 1);

// Kind of a channel, or of its symbol: motors, lengths or tilts of the pose; undefined: something else.
export function kindOf(channel: string): 'motor' | 'pose' | 'tilt' | undefined {
  const name = channel.slice(robotOf(channel).length);
  return /^q\d/.test(name) ? 'motor' : /^[xyz](_[^_]+)?$/.test(name) ? 'pose' : /^r[xyz](_[^_]+)?$/.test(name) ? 'tilt' : undefined;
}

// Those of the robot that has the most of them: two robots share no picture.
export function ofOneRobot(channels: readonly string[]): string[] {
  const of = (robot: string) => channels.filter((channel) => robotOf(channel) === robot);
  return channels.map((channel) => of(robotOf(channel))).reduce((most, mine) => (mine.length > most.length ? mine : most), []);
}

const nmPerUnit = new Map([['m', 1e9], ['mm', 1e6], ['um', 1e3], ['nm', 1]]); // as is_length of the daemon

export const isLength = (unit: string): boolean => nmPerUnit.has(unit);
export const isAngle = (unit: string): boolean => unit === 'rad' || unit === 'deg' || unit === 'arcsec';

export const nmFromMm = (mm: number): number => mm * 1e6;
// A length in its channel's unit; NaN: no length. From mm to mm nothing is rounded.
export const nmFrom = (value: number, unit: string): number => value * (nmPerUnit.get(unit) ?? NaN);
export const mmFrom = (value: number, unit: string): number => (unit === 'mm' ? value : nmFrom(value, unit) / 1e6);
export const mkFromKelvin = (kelvin: number): number => kelvin * 1e3;

// Digits after the point that a live value of this unit is worth; lengths to the nanometre.
export function liveDigits(unit: string): number {
  switch (unit) {
    case 'm': return 9;
    case 'mm': return 6;
    case 'um': return 3;
    case 'nm': return 1;
    case 'degC': return 3;
    case 'K': return 3;
    case 'arcsec': return 2;
    case 'deg': return 6;
    case 'rad': return 8;
    case 'N': return 3;
    case 'hPa': return 2;
    case 'pct': return 1;
    default: return 3;
  }
}
