// Which coordinates of a pose the model needs, and what the address says of them (?x=0.5&y=0): its values are the page's
// state, so that a link shows a colleague the same target.
import { place } from '@/app/router';
import { splitChannel } from '@/format/units';

export interface PoseField {
  channel: string; // "x_mm"
  symbol: string;
  unit: string;
  min: number; // of the fitted domain
  max: number;
}

const stated = ['x', 'y', 'z', 'rx', 'ry', 'rz', 'force'];
const unitOf = (symbol: string) => (symbol === 'force' ? 'N' : symbol.length === 2 ? 'arcsec' : 'mm');

export function fieldsOf(domain: readonly { channel: string; min: number; max: number }[]): PoseField[] {
  return stated.flatMap((symbol) => {
    const range = domain.find((one) => splitChannel(one.channel).symbol === symbol);
    return range ? [{ channel: `${symbol}_${unitOf(symbol)}`, symbol, unit: unitOf(symbol), min: range.min, max: range.max }] : [];
  });
}

// Where nothing is said: 0 if the model was fitted there, else the middle of its range.
export const startOf = (field: PoseField): number => (field.min <= 0 && field.max >= 0 ? 0 : Math.round(500 * (field.min + field.max)) / 1000);

export type Pose = readonly { channel: string; value: number }[];

export function poseOf(fields: readonly PoseField[]): Pose {
  return fields.map((field) => {
    const text = place.value.query.get(field.symbol);
    const value = text === null ? NaN : Number(text);
    return { channel: field.channel, value: Number.isFinite(value) && text !== '' ? value : startOf(field) };
  });
}
