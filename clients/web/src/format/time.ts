// Instants and durations for people. Instants are in UTC and say so, as on the command line and on paper.
import type { Duration, Timestamp } from '@bufbuild/protobuf/wkt';

export const ms = (t: Timestamp | undefined): number | undefined =>
  t === undefined ? undefined : Number(t.seconds) * 1000 + t.nanos / 1e6;
export const secondsOf = (d: Duration | undefined): number | undefined =>
  d === undefined ? undefined : Number(d.seconds) + d.nanos / 1e9;
export const timestampOf = (atMs: number): Timestamp => {
  const seconds = Math.floor(atMs / 1000);
  return { $typeName: 'google.protobuf.Timestamp', seconds: BigInt(seconds), nanos: Math.round((atMs - seconds * 1000) * 1e6) };
};

const days = ['Sun', 'Mon', 'Tue', 'Wed', 'Thu', 'Fri', 'Sat'];
const two = (n: number) => String(n).padStart(2, '0');

// "10:21:07 UTC"
export function clock(atMs: number | undefined): string {
  if (atMs === undefined) return '–';
  const d = new Date(atMs);
  return `${two(d.getUTCHours())}:${two(d.getUTCMinutes())}:${two(d.getUTCSeconds())} UTC`;
}
// "Sun 07:40 UTC"; farther from now than a weekday can tell: "2011-05-13 07:40 UTC"
const weekdaysMs = 6 * 86400e3;
export function dayClock(atMs: number | undefined, nowMs: number): string {
  if (atMs === undefined) return '–';
  const d = new Date(atMs);
  if (!(Math.abs(atMs - nowMs) < weekdaysMs)) return dateClock(atMs).replace(/:\d\d UTC$/, ' UTC');
  return `${days[d.getUTCDay()]} ${two(d.getUTCHours())}:${two(d.getUTCMinutes())} UTC`;
}
// "2011-05-13 07:40:12 UTC"
export function dateClock(atMs: number | undefined): string {
  if (atMs === undefined) return '–';
  const d = new Date(atMs);
  return `${d.getUTCFullYear()}-${two(d.getUTCMonth() + 1)}-${two(d.getUTCDate())} ${clock(atMs)}`;
}
// "48 s", "9 min 20 s", "6 h 05 min", "2 d 13 h"
export function duration(seconds: number | undefined): string {
  if (seconds === undefined || !Number.isFinite(seconds)) return '–';
  const s = Math.max(0, Math.round(seconds));
  if (s < 60) return s < 10 && seconds % 1 >= 0.05 && seconds < 9.95 ? `${seconds.toFixed(1)} s` : `${s} s`;
  if (s < 3600) return s % 60 ? `${Math.floor(s / 60)} min ${s % 60} s` : `${s / 60} min`;
  if (s < 86400) return `${Math.floor(s / 3600)} h ${two(Math.floor((s % 3600) / 60))} min`;
  return `${Math.floor(s / 86400)} d ${Math.floor((s % 86400) / 3600)} h`;
}
// For addresses and fields: "2011-05-13T05:40:12Z" and back. What is read is what the daemon reads (server/core/cell_time.h), and
// nothing else: Date.parse takes the browser's zone where there is no Z, and makes a date of "1".
const instant = /^(\d{4})-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d{1,9})?Z$/;
export const utc = (atMs: number): string => new Date(atMs).toISOString().replace(/\.000Z$/, 'Z');
export function fromUtc(text: string | undefined): number | undefined {
  const year = Number(instant.exec(text ?? '')?.[1]);
  if (!(year >= 1970 && year <= 2261)) return undefined;
  const at = Date.parse(text!);
  // The 30th of February and 24:00 become another day.
  return !Number.isNaN(at) && utc(at).slice(0, 19) === text!.slice(0, 19) ? at : undefined;
}

// The last midnight in UTC, where axes of time of day start.
export function lastMidnight(atMs: number): number {
  return Math.floor(atMs / 86400e3) * 86400e3;
}
