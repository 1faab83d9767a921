// What stands now and what nobody has acknowledged: asked once, then as it happens. Each alarm is acknowledged by itself.
import { signal } from '@preact/signals';
import { useEffect, useMemo } from 'preact/hooks';
import { api } from '@/api/client';
import { Alarm_Level, type Alarm } from '@/api/gen/driftwise/v1/watch_service_pb';
import { say } from '@/app/live_region';
import { useAsked, type Asked } from '@/ui/use_asked';
import { connection } from './connection';
import { useEvents } from './events';

export const levelWords: Record<Alarm_Level, string> = {
  [Alarm_Level.UNSPECIFIED]: 'Notice',
  [Alarm_Level.NOTICE]: 'Notice',
  [Alarm_Level.WARNING]: 'Warning',
  [Alarm_Level.FAILED]: 'Failed',
};

// What the shell's one watcher knows (app/alarm_watch.tsx): lasting ones first, the worst first; undefined: nothing asked yet.
export const standing = signal<Asked<Alarm[]> | undefined>(undefined);

// Alarms that began to need a person while the page was open, the newest that came together: one fault raises several, and after a
// break they are replayed at once. live/alarm_signals.ts sounds them.
export const arrived = signal<readonly Alarm[]>([]);
let together: readonly Alarm[] = [];

function hand(alarm: Alarm): void {
  if (together.length === 0) queueMicrotask(() => void (together = []));
  together = [...together, alarm];
  arrived.value = together;
}

// While the record takes nothing an alarm has no number yet: it is known by what it is of and since when, also once it has one.
const occurrence = (alarm: Alarm): string => `${alarm.kind} ${alarm.subject} ${alarm.sinceTime?.seconds} ${alarm.sinceTime?.nanos}`;
export const isOnRecord = (alarm: Alarm): boolean => alarm.id !== 0n;
export const alarmKey = (alarm: Alarm): string => (isOnRecord(alarm) ? String(alarm.id) : occurrence(alarm));
const isSame = (a: Alarm, b: Alarm): boolean => (isOnRecord(a) && isOnRecord(b) ? a.id === b.id : occurrence(a) === occurrence(b));

const inOrder = (a: Alarm, b: Alarm): number =>
  Number(a.shelvedUntilTime !== undefined) - Number(b.shelvedUntilTime !== undefined) ||
  Number(a.clearedTime !== undefined) - Number(b.clearedTime !== undefined) || b.priority - a.priority || b.level - a.level ||
  Number(isOnRecord(a)) - Number(isOnRecord(b)) || Number(b.id - a.id);

export const stands = (alarm: Alarm): boolean => alarm.clearedTime === undefined || alarm.acknowledgeTime === undefined;

// It came, it became worse, or its shelf ended.
const beginsToNeed = (alarm: Alarm, before: Alarm | undefined): boolean =>
  stands(alarm) && !alarm.shelvedUntilTime && (!before || before.level < alarm.level || before.shelvedUntilTime !== undefined);

const askAgainMs = 2000;

// Asks for itself: one watcher, so that a new alarm is said once. The stream brings only what changes: without the list that it
// changes there is no alarm on the page. So a list that could not be had is asked for until it is there, by a hidden page too.
export function useAlarms(): Asked<Alarm[]> {
  const asked = useAsked('alarms', async (signal) => (await api.watch().listAlarms({}, { signal })).alarms);
  useEvents('alarm', (alarm) => {
    let told = false;
    asked.set((old) => {
      if (!told && beginsToNeed(alarm, old.find((one) => isSame(one, alarm)))) {
        told = true;
        say(`${levelWords[alarm.level]}: ${alarm.message}`);
        hand(alarm);
      }
      return [alarm, ...old.filter((one) => !isSame(one, alarm))].filter(stands);
    });
  });
  const live = connection.value.phase === 'live';
  // Those without a number are known to the daemon alone: another one does not have them.
  useEffect(() => {
    if (live && asked.value?.some((alarm) => !isOnRecord(alarm))) asked.again();
  }, [live]);
  useEffect(() => {
    if (!live || asked.failure === undefined || asked.waiting) return undefined;
    const timer = setTimeout(asked.again, askAgainMs);
    return () => clearTimeout(timer);
  }, [live, asked.failure, asked.waiting]);
  const sorted = useMemo(
    () => asked.value && [...asked.value].sort(inOrder),
    [asked.value],
  );
  return { ...asked, ...(sorted && { value: sorted }) };
}
