// What needs attention: one line per alarm, each acknowledged by itself.
import { api } from '@/api/client';
import { Alarm_Level, type Alarm } from '@/api/gen/driftwise/v1/watch_service_pb';
import { dayClock, ms } from '@/format/time';
import { levelWords, useAlarms } from '@/live/alarms';
import { CommandButton } from '@/ui/button';
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
  return (
    <li class={`panel alarm alarm-${kinds[alarm.level]}`}>
      <Verdict kind={kinds[alarm.level]}>{levelWords[alarm.level]}</Verdict>
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

export function AlarmList() {
  const alarms = useAlarms();
  if (alarms.failure) return <Failed asked="List the alarms" failure={alarms.failure} again={alarms.again} />;
  if (!alarms.value?.length) return null;
  const taken = (alarm: Alarm) => alarms.set((old) => old.map((one) => (one.id === alarm.id ? alarm : one)));
  return <ul class="alarms" aria-label="What needs attention">{alarms.value.map((alarm) => <AlarmLine key={String(alarm.id)} alarm={alarm} taken={taken} />)}</ul>;
}
