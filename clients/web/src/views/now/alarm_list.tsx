// What needs attention: one line per alarm, each acknowledged by itself. Those that are over stand behind those that last, and
// from the fourth line on they wait behind a button, so that the numbers stay in sight.
import { useState } from 'preact/hooks';
import { api } from '@/api/client';
import { Alarm_Level, type Alarm } from '@/api/gen/driftwise/v1/watch_service_pb';
import { dayClock, ms } from '@/format/time';
import { levelWords, useAlarms } from '@/live/alarms';
import { Button, CommandButton } from '@/ui/button';
import { Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';
import { Verdict, type VerdictKind } from '@/ui/verdict';

const kinds: Record<Alarm_Level, VerdictKind> = {
  [Alarm_Level.UNSPECIFIED]: 'idle',
  [Alarm_Level.NOTICE]: 'idle',
  [Alarm_Level.WARNING]: 'warn',
  [Alarm_Level.FAILED]: 'bad',
};

function AlarmLine({ alarm, taken }: { alarm: Alarm; taken: (alarm: Alarm) => void }) {
  const acknowledge = useCommand(async () => {
    const answer = await api.watch().acknowledgeAlarm({ alarmId: alarm.id });
    if (answer.alarm) taken(answer.alarm);
  });
  // One that is over waits to be acknowledged; it must not look like one that lasts.
  const over = alarm.clearedTime !== undefined;
  const kind = over ? 'idle' : kinds[alarm.level];
  return (
    <li class={`panel alarm alarm-${kind}${over ? ' alarm-over' : ''}`}>
      <Verdict kind={kind}>{levelWords[alarm.level]}{over && ', over'}</Verdict>
      <p>
        {alarm.message}{' '}
        <span class="muted">
          since {dayClock(ms(alarm.sinceTime))}
          {alarm.clearedTime && `, over since ${dayClock(ms(alarm.clearedTime))}`}
          {alarm.acknowledgeTime ? `, seen by ${alarm.acknowledgedBy}` : ', not acknowledged'}
        </span>
      </p>
      {!alarm.acknowledgeTime && (
        <CommandButton busy={acknowledge.busy} onPress={() => void acknowledge.send()} label={`Acknowledge: ${alarm.message}`}>Acknowledge</CommandButton>
      )}
      {acknowledge.failure && <Failed asked="Acknowledge" failure={acknowledge.failure} />}
    </li>
  );
}

const linesShown = 3;

export function AlarmList() {
  const alarms = useAlarms();
  const [all, setAll] = useState(false);
  if (alarms.failure) return <Failed asked="List the alarms" failure={alarms.failure} again={alarms.again} />;
  if (!alarms.value?.length) return null;
  const taken = (alarm: Alarm) => alarms.set((old) => old.map((one) => (one.id === alarm.id ? alarm : one)));
  const lasting = alarms.value.filter((alarm) => !alarm.clearedTime);
  const sorted = [...lasting, ...alarms.value.filter((alarm) => alarm.clearedTime)];
  const shown = all ? sorted : sorted.slice(0, Math.max(linesShown, lasting.length));
  return (
    <>
      <ul class="alarms" aria-label="What needs attention">{shown.map((alarm) => <AlarmLine key={String(alarm.id)} alarm={alarm} taken={taken} />)}</ul>
      {sorted.length > shown.length && <p><Button small onPress={() => setAll(true)}>Show {sorted.length - shown.length} more that are over</Button></p>}
    </>
  );
}
