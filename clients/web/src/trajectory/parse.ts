// A trajectory's text as rows, for the picture only. Whether the text is right is the daemon's to say: what this cannot
// read it leaves out.
import type { Pose } from '@/poses/pose';
import { fixed } from '@/format/numbers';
import { kindOf, splitChannel } from '@/format/units';

export interface TrajectoryRow {
  at: number[]; // mm, in order of the coordinates
  validation: boolean;
  zero: boolean;
  line: number;
  forceN?: number;
}

export interface TrajectoryRows {
  coordinates: string[]; // "q1_mm", "x_mm" or, of the robot mn, "mn.x_mm"
  rows: TrajectoryRow[];
}

export function trajectoryRows(text: string): TrajectoryRows {
  const lines = text.replace(/^\ufeff/, '').split(/\r?\n/).map((line) => line.trim()).filter((line) => line !== '' && !line.startsWith('#'));
  const head = (lines[0] ?? '').split(',').map((field) => field.trim());
  const coordinates = head.filter((name) => splitChannel(name).unit === 'mm' && ['motor', 'pose'].includes(kindOf(name) ?? ''));
  const places = coordinates.map((name) => head.indexOf(name));
  const column = (name: string) => head.indexOf(name);
  const [set, zero, line, force] = [column('set'), column('zero'), column('line'), column('force_N')];
  const rows: TrajectoryRow[] = [];
  for (const text of lines.slice(1)) {
    const fields = text.split(',').map((field) => field.trim());
    const at = places.map((i) => Number(fields[i]));
    if (at.length === 0 || !at.every(Number.isFinite)) continue;
    const row: TrajectoryRow = { at, validation: fields[set] === 'validation', zero: fields[zero] === '1', line: line < 0 ? 1 : Number(fields[line]) };
    if (force >= 0 && fields[force] !== '' && Number.isFinite(Number(fields[force]))) row.forceN = Number(fields[force]);
    rows.push(row);
  }
  return { coordinates, rows };
}

export const posesOf = (of: TrajectoryRows): Pose[] =>
  of.rows.map((row, i) => ({
    at: [row.at[0] ?? 0, row.at[1] ?? 0, row.at[2] ?? 0], key: i, set: row.zero ? 'zero' : row.validation ? 'validation' : 'calibration',
  }));

// Forces in the order in which they are wanted, each once per stage.
export function forceStages(of: TrajectoryRows): { forceN: number; points: number }[] {
  const stages: { forceN: number; points: number }[] = [];
  for (const row of of.rows) {
    if (row.forceN === undefined) continue;
    const last = stages[stages.length - 1];
    if (last && last.forceN === row.forceN) ++last.points;
    else stages.push({ forceN: row.forceN, points: 1 });
  }
  return stages;
}

// "0 N, then 0.768 N"; where it goes to and fro, which forces and how often.
export function forceText(of: TrajectoryRows): string {
  const stages = forceStages(of);
  const text = (forceN: number) => `${fixed(forceN, 3).replace(/\.?0+$/, '')} N`;
  if (stages.length <= 6) return stages.map((stage) => text(stage.forceN)).join(', then ');
  const different = [...new Set(stages.map((stage) => stage.forceN))];
  return `${different.slice(0, 8).map(text).join(', ')}${different.length > 8 ? ' and more' : ''}, changed ${stages.length - 1} times`;
}

export function rangesOf(of: TrajectoryRows): { symbol: string; channel: string; low: number; high: number }[] {
  return of.coordinates.map((channel, i) => {
    let [low, high] = [Infinity, -Infinity];
    for (const row of of.rows) {
      low = Math.min(low, row.at[i]);
      high = Math.max(high, row.at[i]);
    }
    return { symbol: splitChannel(channel).symbol, channel, low, high };
  });
}
