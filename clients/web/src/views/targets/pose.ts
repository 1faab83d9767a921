// Which coordinates of a pose the model needs, and what the address says of them (?x=0.5&y=0): its values are the page's
// state, so that a link shows a colleague the same target.
import { place } from '@/app/router';
import { splitChannel } from '@/format/units';
import { numberTyped } from '@/ui/field';

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

// Text of a field: what was typed while it is no number, else what the address says.
export function textOf(field: PoseField, typed: string | undefined): string {
  const address = place.value.query.get(field.symbol) ?? String(startOf(field));
  if (typed === undefined) return address;
  const number = numberTyped(typed);
  return number === undefined || number === numberTyped(address) ? typed : address;
}

export type Typed = Readonly<Record<string, string>>; // by symbol

export const unreadOf = (fields: readonly PoseField[], typed: Typed): readonly PoseField[] =>
  fields.filter((field) => numberTyped(textOf(field, typed[field.symbol])) === undefined);

// Empty while a field is no number: a target of another pose than the fields say is never shown.
export function poseOf(fields: readonly PoseField[], typed: Typed): Pose {
  if (unreadOf(fields, typed).length > 0) return [];
  return fields.map((field) => ({ channel: field.channel, value: numberTyped(textOf(field, typed[field.symbol])) ?? NaN }));
}
