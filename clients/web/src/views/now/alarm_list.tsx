// What needs attention: one line per alarm, each acknowledged by itself or all that are listed at once. Those that are over
// stand behind those that last, and from the fourth line on they wait behind a button, so that the numbers stay in sight.
import { useState } from 'preact/hooks';
import { api } from '@/api/client';
import { Alarm_Level, Alarm_Priority, type Alarm } from '@/api/gen/driftwise/v1/watch_service_pb';
import { ms } from '@/format/time';
import { alarmKey, isOnRecord, levelWords, standing } from '@/live/alarms';
import { dayOrDate } from '@/live/state';
import { AlarmSwitches } from '@/parts/alarm_switches';
import { Button, CommandButton } from '@/ui/button';
import { Awaiting, Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';
import { Verdict, type VerdictKind } from '@/ui/verdict';
import { AcknowledgeAll } from './acknowledge_all';
import { Shelve } from './shelve';

const kinds: Record<Alarm_Level, VerdictKind> = {
  [Alarm_Level.UNSPECIFIED]: 'idle',
  [Alarm_Level.NOTICE]: 'idle',
  [Alarm_Level.WARNING]: 'warn',
  [Alarm_Level.FAILED]: 'bad',
};

// One that is over waits to be acknowledged; it must not look like one that lasts.
const kindOf = (alarm: Alarm): VerdictKind => (alarm.clearedTime || alarm.shelvedUntilTime ? 'idle' : kinds[alarm.level]);

function Words({ alarm }: { alarm: Alarm }) {
  return (
    <>
      <Verdict kind={kindOf(alarm)}>{levelWords[alarm.level]}{alarm.priority === Alarm_Priority.CRITICAL && ', critical'}{alarm.clearedTime && ', over'}{alarm.shelvedUntilTime && ', shelved'}</Verdict>
      <p>
        {alarm.message}{' '}
        <span class="muted">
          since {dayOrDate(ms(alarm.sinceTime))}
          {alarm.clearedTime && `, over since ${dayOrDate(ms(alarm.clearedTime))}`}
          {alarm.shelvedUntilTime && `, shelved by ${alarm.shelvedBy} until ${dayOrDate(ms(alarm.shelvedUntilTime))}: ${alarm.shelveReason}`}
          {alarm.acknowledgeTime ? `, seen by ${alarm.acknowledgedBy}` : ', not acknowledged'}
        </span>
      </p>
      {alarm.consequences.length > 0 && (
        <ul class="alarm-hence" aria-label="What follows from it">{alarm.consequences.map((one) => <li key={one}>hence: {one}</li>)}</ul>
      )}
    </>
  );
}

const classOf = (alarm: Alarm): string => `panel alarm alarm-${kindOf(alarm)}${alarm.clearedTime ? ' alarm-over' : ''}`;

function AlarmLine({ alarm, taken }: { alarm: Alarm; taken: (alarm: Alarm) => void }) {
  const acknowledge = useCommand(async () => {
    const answer = await api.watch().acknowledgeAlarm({ alarmId: alarm.id });
    if (answer.alarm) taken(answer.alarm);
  });
  return (
    <li class={classOf(alarm)}>
      <Words alarm={alarm} />
      <div class="alarm-answers">
        {!isOnRecord(alarm) && <span class="muted">not on record yet: it can be acknowledged once the record takes it</span>}
        {isOnRecord(alarm) && !alarm.acknowledgeTime && (
          <CommandButton busy={acknowledge.busy} onPress={() => void acknowledge.send()} label={`Acknowledge: ${alarm.message}`}>Acknowledge</CommandButton>
        )}
        {isOnRecord(alarm) && <Shelve alarm={alarm} taken={taken} />}
      </div>
      {acknowledge.failure && <Failed asked="Acknowledge" failure={acknowledge.failure} />}
    </li>
  );
}

const linesShown = 3;

export function AlarmList() {
  const alarms = standing.value;
  const [all, setAll] = useState(false);
  const failed = alarms?.failure && <Failed asked="List the alarms" failure={alarms.failure} again={alarms.again} />;
  if (!alarms?.value?.length) return <>{failed ?? (!alarms?.value && <Awaiting what="the alarms" />)}<AlarmSwitches /></>;
  const taken = (alarm: Alarm) => alarms.set((old) => old.map((one) => (one.id === alarm.id ? alarm : one)));
  const lasting = alarms.value.filter((alarm) => !alarm.clearedTime && !alarm.shelvedUntilTime);
  const shown = all ? alarms.value : alarms.value.slice(0, Math.max(linesShown, lasting.length));
  const more = alarms.value.length - shown.length;
  return (
    <>
      {failed}
      <ul class="alarms" aria-label="What needs attention">{shown.map((alarm) => <AlarmLine key={alarmKey(alarm)} alarm={alarm} taken={taken} />)}</ul>
      {more > 0 && <p><Button small onPress={() => setAll(true)}>Show {more} more that are over{alarms.value.some((one) => one.shelvedUntilTime) && ' or shelved'}</Button></p>}
      <AcknowledgeAll alarms={alarms.value} taken={taken} />
      <AlarmSwitches />
    </>
  );
}

// Across a room: above everything else, without controls.
export function WallAlarms() {
  const alarms = standing.value;
  const failed = alarms?.failure && <Failed asked="List the alarms" failure={alarms.failure} />;
  if (!alarms?.value) return failed ?? <Awaiting what="the alarms" />;
  if (alarms.value.length === 0) return failed ?? null;
  const more = alarms.value.length - linesShown;
  return (
    <section aria-label="What needs attention">
      {failed}
      <ul class="alarms">{alarms.value.slice(0, linesShown).map((alarm) => <li key={alarmKey(alarm)} class={classOf(alarm)}><Words alarm={alarm} /></li>)}</ul>
      {more > 0 && <p>and {more} more {more === 1 ? 'alarm' : 'alarms'}</p>}
    </section>
  );
}
