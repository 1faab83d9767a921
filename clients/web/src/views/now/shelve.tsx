// Shelves an alarm: how long, and why. It comes back by itself, or when somebody brings it back.
import { useState } from 'preact/hooks';
import { api } from '@/api/client';
import type { Alarm } from '@/api/gen/driftwise/v1/watch_service_pb';
import { Button, CommandButton } from '@/ui/button';
import { Field, numberTyped } from '@/ui/field';
import { Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';
import { useTyped } from '@/ui/use_typed';

const mostHours = 24;

function ShelveForm({ alarm, taken, close }: { alarm: Alarm; taken: (alarm: Alarm) => void; close: () => void }) {
  const [hours, setHours, hoursTaken] = useTyped(`shelve.hours.${alarm.id}`, '2');
  const [reason, setReason, reasonTaken] = useTyped(`shelve.${alarm.id}`);
  const asked = numberTyped(hours);
  const good = asked !== undefined && asked > 0 && asked <= mostHours;
  const shelve = useCommand(async () => {
    const seconds = Math.round((asked ?? 0) * 3600);
    const answer = await api.watch().shelveAlarm({ alarmId: alarm.id, shelveDuration: { seconds: BigInt(seconds), nanos: 0 }, reason: reason.trim() });
    if (answer.alarm) taken(answer.alarm);
    reasonTaken(), hoursTaken();
    close();
  });
  const off = !good ? `Between 0 and ${mostHours} hours` : reason.trim() ? undefined : 'Say why';
  return (
    <div class="actions">
      <Field label="Shelve for" unit="h" type="number" value={hours} onInput={setHours} wrong={good ? undefined : `Above 0, at most ${mostHours}`} />
      <Field label="Reason" value={reason} onInput={setReason} hint="stands in the record" />
      <CommandButton small busy={shelve.busy} off={off} onPress={() => void shelve.send()}>Shelve</CommandButton>
      <Button small onPress={close}>Not now</Button>
      {shelve.failure && <Failed asked="Shelve" failure={shelve.failure} />}
    </div>
  );
}

export function Shelve({ alarm, taken }: { alarm: Alarm; taken: (alarm: Alarm) => void }) {
  const [open, setOpen] = useState(false);
  const back = useCommand(async () => {
    const answer = await api.watch().unshelveAlarm({ alarmId: alarm.id });
    if (answer.alarm) taken(answer.alarm);
  });
  if (alarm.shelvedUntilTime)
    return (
      <>
        <CommandButton small busy={back.busy} onPress={() => void back.send()} label={`Bring back: ${alarm.message}`}>Bring back</CommandButton>
        {back.failure && <Failed asked="Bring back" failure={back.failure} />}
      </>
    );
  if (open) return <ShelveForm alarm={alarm} taken={taken} close={() => setOpen(false)} />;
  return <Button onPress={() => setOpen(true)} label={`Shelve: ${alarm.message}`}>Shelve…</Button>;
}
