// The zone of the times that people read: the browser's.
import { dateClock } from './time';

// "Europe/Berlin, UTC+01:00 on 2026-11-22 11:50:12"
export function zoneWords(atMs: number): string {
  const minutes = -new Date(atMs).getTimezoneOffset();
  const two = (n: number) => String(n).padStart(2, '0');
  const offset = `UTC${minutes < 0 ? '−' : '+'}${two(Math.floor(Math.abs(minutes) / 60))}:${two(Math.abs(minutes) % 60)}`;
  return `${Intl.DateTimeFormat().resolvedOptions().timeZone}, ${offset} on ${dateClock(atMs)}`;
}
