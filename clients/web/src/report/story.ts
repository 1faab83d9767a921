// The events of a report in order of time: from the queue, the alarms and the record of a report.
import { count, countRows } from '@/format/numbers';
import type { VerdictKind } from '@/ui/verdict';
import type { Report } from './data';

export interface StoryLine {
  time: string; // ISO 8601 UTC
  kind: VerdictKind;
  what: string;
}

// Events of the record that tell the story: all that a person did to the run, the queue or the axes, every new datum, and what the daemon
// did by itself. Alarms, the queue's entries, closures and rows given up are told by their own lists.
const names: Partial<Record<VerdictKind, string>> = {
  bad:
    'hold.ends_daemon run.abort run.failed run.trouble queue.failed queue.set_aside queue.follow_up_failed stop ' +
    'stop.pending stop.repeated stop.unconfirmed axes.home_failed motion.halted motion.controller_error record.unwritten ' +
    'record.dropped database.damaged',
  warn:
    'hold.begun hold.set_aside run.pause run.resume_refused run.restarted run.unmeasured queue.held stop.confirmed ' +
    'stop.kept axes.home axes.jog axes.jog_lost axes.move motion.servo_on datum.opened zero.surprising data.excluded ' +
    'daemon.paused clock.stepped closure.repeat device.lost device.clock_jumped stabiliser.set_failed',
  good:
    'hold.ended run.resume run.resumed queue.released device.back',
  idle:
    'hold.in_force run.tagged queue.changed queue.moved queue.removed axes.waiting data.restored note.added note.pinned ' +
    'daemon.started daemon.stopping load.confirmed load.changed stabiliser.set stabiliser.tuned',
};
export const told: Record<string, VerdictKind> = Object.fromEntries(Object.entries(names).flatMap(([kind, of]) => of.split(' ').map((name) => [name, kind as VerdictKind])));

const priorities: Record<string, VerdictKind> = { low: 'idle', medium: 'warn', high: 'bad', critical: 'bad' };

export function storyOf(report: Report): StoryLine[] {
  const lines: StoryLine[] = [];
  const tell = (time: string | null, kind: VerdictKind, what: string) => {
    if (time) lines.push({ time, kind, what });
  };
  for (const entry of report.queue?.entries ?? []) {
    const name = `queue entry ${entry.id} "${entry.name}"`;
    tell(entry.queued, 'idle', `${entry.by} queued ${name}${entry.condition && `, to start when ${entry.condition}`}`);
    tell(entry.begun, 'good', `${name} begins as run ${entry.run}`);
    tell(entry.ended, entry.run_state === 'done' ? 'good' : 'bad', `run ${entry.run} of ${name} is ${entry.run_state ?? 'over'}: ${count(entry.accepted ?? 0)} of ${countRows(entry.rows ?? 0)} accepted, ${count(entry.given_up ?? 0)} given up`);
    for (const result of entry.results) tell(result.time, result.good ? 'good' : 'bad', `${name}: ${result.text}`);
  }
  if (!report.queue) {
    tell(report.run.start, 'good', `run ${report.run.id} begins`);
    tell(report.run.end, report.run.state === 'done' ? 'good' : 'bad', `run ${report.run.id} is ${report.run.state}`);
  }
  for (const alarm of report.alarms) {
    const name = `alarm ${alarm.kind} of ${alarm.subject}`;
    tell(alarm.since, priorities[alarm.priority] ?? 'warn', `${name}: ${alarm.message}`);
    tell(alarm.acknowledged, 'good', `${alarm.acknowledged_by} acknowledged ${name}`);
    tell(alarm.over, 'good', `${name} is over`);
  }
  for (const event of report.events) if (event.what in told) tell(event.time, told[event.what], event.detail || event.what);
  for (const closure of report.closures ?? [])
    if (!['within', 'explained', 'play'].includes(closure.decision)) tell(closure.time, 'warn', `return to zero of line ${closure.line} ${closure.decision.replaceAll('_', ' ')}: ${closure.sentence}`);
  const startMs = Date.parse(report.run.start ?? '');
  if (Number.isFinite(startMs))
    for (const attempt of report.attempts)
      if (attempt.verdict === 'given_up') tell(new Date(startMs + 1000 * attempt.time_s).toISOString(), 'bad', `row ${attempt.row} given up: ${attempt.reason}`);
  return lines.sort((a, b) => Date.parse(a.time) - Date.parse(b.time));
}
