// The two documents of an indentation, as the daemon hands them on: docs/indentation.md has their keys.
import { flagsInWords } from '@/parts/flag_words';

interface Touch {
  x_mm: number;
  y_mm: number;
  height_mm: number;
  u_nm: number;
  steps: number;
  contact: number; // number on the substrate, from 1
}

export interface Contact extends Touch {
  stage: string;
  round: number; // corrections made before it
  indent: string; // empty: no indent
  rx_arcsec: number; // commanded to the robot below
  ry_arcsec: number;
  by: string;
  at: string; // UTC, ISO 8601; empty: unknown
  trouble: string; // empty: found and recorded
}

export interface Round {
  round: number;
  accepted: boolean;
  spread_nm: number;
  rx_arcsec: number; // commanded from then on
  ry_arcsec: number;
  height_mm: number;
  by: string;
  at: string;
}

export interface IndentationRecord {
  driftwise_indentation: number;
  stage: string;
  corrections: number;
  log: string[];
  contact_list: Contact[];
  rounds: Round[];
}

export interface IndentRow {
  id: string;
  line: string;
  wanted_um: number;
  rx_arcsec: number;
  ry_arcsec: number;
  measured_um: number;
  half_width_um: number;
  u_um: number;
  error_um: number;
  rotations_um: number;
  lever_um: number;
  rest_um: number;
  force_mN?: number;
}

export interface IndentTable {
  driftwise_indents: number;
  lever_mm: number;
  indents: IndentRow[];
  lines: { line: string; rms_um: number; lever_factor: number; u_lever_factor: number; scale_ppm: number; u_scale_ppm: number; correlation: number }[];
  indistinguishable: string[];
  separating: string[];
  verdict: string;
  change: string[];
}

// undefined: written by a later version, or damaged.
function read<T>(text: string, version: string): T | undefined {
  try {
    const found = JSON.parse(text);
    return found[version] === 1 ? found : undefined;
  } catch {
    return undefined;
  }
}
export function recordFrom(text: string): IndentationRecord | undefined {
  const record = read<IndentationRecord>(text, 'driftwise_indentation');
  return record && { ...record, contact_list: record.contact_list ?? [], rounds: record.rounds ?? [] };
}
export const tableFrom = (text: string) => read<IndentTable>(text, 'driftwise_indents');

// "plan 1, mn=5, ma=coarse:2 OUTSIDE_DOMAIN(t19_degC)" as the client records it: "plan 1: mn by model 5, ma by model 2 (coarse)", and
// the flags in words. Anything else stays as it is.
export function answerInWords(by: string): { who: string; doubts: string[] } {
  const flags = by.search(/ [A-Z][A-Z_]{3,}/);
  const source = flags < 0 ? by : by.slice(0, flags);
  const [plan, ...robots] = source.split(', ');
  const models = robots.map((robot) => {
    const [, id, kind, numbers] = /^(\w*)=(?:(\w+):)?([\d+]+)$/.exec(robot) ?? [];
    return numbers && `${id || 'the robot'} by ${numbers.includes('+') ? 'models' : 'model'} ${numbers.replace('+', ' and ')}${kind ? ` (${kind})` : ''}`;
  });
  return { who: models.length > 0 && models.every(Boolean) ? `${plan}: ${models.join(', ')}` : source, doubts: flags < 0 ? [] : flagsInWords([by.slice(flags)]) };
}

// Models that answered, with the contacts that they moved to.
export function answers(contacts: readonly Contact[]): { by: string; contacts: string }[] {
  const found = new Map<string, number[]>();
  for (const one of contacts) found.set(one.by, [...(found.get(one.by) ?? []), one.contact]);
  return [...found].map(([by, numbers]) => ({ by: by || 'unknown', contacts: numbers.join(', ') }));
}
