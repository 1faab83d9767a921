// One answer to many alarms. The dialog names each of them; what arrives while it is read is not part of the answer.
import { api } from '@/api/client';
import type { Alarm } from '@/api/gen/driftwise/v1/watch_service_pb';
import { isOnRecord, levelWords, standing } from '@/live/alarms';
import { CommandButton } from '@/ui/button';
import { confirm } from '@/ui/confirm';
import { Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';

// An alarm that became worse since it was shown is another one than was read.
const asShown = (shown: Alarm): boolean => (standing.value?.value?.find((one) => one.id === shown.id)?.level ?? shown.level) <= shown.level;

async function acknowledge(shown: readonly Alarm[], taken: (alarm: Alarm) => void): Promise<void> {
  const yes = await confirm({
    title: `Acknowledge ${shown.length} alarms?`,
    words: 'These are acknowledged. An alarm that arrives meanwhile stays.',
    facts: shown.map((alarm) => [`${levelWords[alarm.level]}${alarm.clearedTime ? ', over' : ''}`, alarm.message]),
    verb: `Acknowledge these ${shown.length}`,
    keep: 'Not yet',
  });
  if (!yes) return;
  let failure: unknown;
  for (const { id } of shown.filter(asShown)) {
    try {
      const { alarm } = await api.watch().acknowledgeAlarm({ alarmId: id });
      if (alarm) taken(alarm);
    } catch (error) {
      failure ??= error; // the others are acknowledged all the same
    }
  }
  if (failure !== undefined) throw failure;
}

export function AcknowledgeAll({ alarms, taken }: { alarms: readonly Alarm[]; taken: (alarm: Alarm) => void }) {
  const all = useCommand((shown: readonly Alarm[]) => acknowledge(shown, taken));
  const open = alarms.filter((alarm) => isOnRecord(alarm) && !alarm.acknowledgeTime);
  if (open.length < 2 && !all.busy && !all.failure) return null;
  return (
    <div class="actions">
      <CommandButton small busy={all.busy} off={open.length === 0 ? 'All are acknowledged' : undefined} onPress={() => void all.send(open)}>Acknowledge all…</CommandButton>
      {all.failure && <Failed asked="Acknowledge all" failure={all.failure} />}
    </div>
  );
}
