// Whom alarms reach outside the machine ([[notify]] of the cell file), and what each was told.
import type { Receiver, Telling } from '@/api/gen/driftwise/v1/watch_service_pb';
import { api } from '@/api/client';
import { count } from '@/format/numbers';
import { dateClock, ms } from '@/format/time';
import { CommandButton } from '@/ui/button';
import { Panel } from '@/ui/panel';
import { Awaiting, Empty, Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { Verdict } from '@/ui/verdict';

const mostTellings = 50;

function Test({ receiver, done }: { receiver: Receiver; done: () => void }) {
  const test = useCommand(async () => {
    await api.watch().testReceiver({ name: receiver.name });
    done();
  });
  return (
    <>
      <CommandButton small busy={test.busy} label={`Send a test message to ${receiver.name}`} onPress={() => void test.send()}>Send a test</CommandButton>
      {test.failure && <Failed asked="Send the test message" failure={test.failure} />}
    </>
  );
}

const state = (one: Receiver) =>
  one.failingTime ? <Verdict kind="bad">nothing arrives since {dateClock(ms(one.failingTime))}: {one.answer}</Verdict>
  : one.deliverTime ? <Verdict kind="good">last message {dateClock(ms(one.deliverTime))}</Verdict>
  : <Verdict kind="idle">nothing was sent since the daemon's start</Verdict>;

const told = (one: Telling) => (one.error ? `${one.error} (${count(one.failedCount)} tries)` : one.resolvedTime ? `over, told ${dateClock(ms(one.resolvedTime))}` : `told ${dateClock(ms(one.lastTime))}`);

export function Receivers() {
  const asked = useAsked('receivers', async (signal) => api.watch().listReceivers({ limit: mostTellings }, { signal }));
  const found = asked.value;
  return (
    <Panel title="Receivers of alarms">
      {asked.failure && <Failed asked="List the receivers" failure={asked.failure} again={asked.again} />}
      {!found && !asked.failure && <Awaiting what="the receivers" />}
      {found?.receivers.length === 0 && <Empty next="[[notify]] in the cell file names them.">Alarms reach nobody outside this machine.</Empty>}
      {found && found.receivers.length > 0 && (
        <Table
          caption="Receivers of alarms"
          rows={found.receivers}
          keyOf={(one) => one.name}
          columns={[
            { title: 'name', of: (one) => one.name },
            { title: 'way', of: (one) => one.way },
            { title: 'state', of: state },
            { title: 'waiting', number: true, of: (one) => count(one.waitingCount) },
            { title: 'try', of: (one) => <Test receiver={one} done={asked.again} /> },
          ]}
        />
      )}
      {found && found.tellings.length > 0 && (
        <Table
          caption="What they were told, newest alarm first"
          rows={found.tellings}
          keyOf={(one) => `${one.alarmId} ${one.receiver}`}
          columns={[
            { title: 'alarm', of: (one) => String(one.alarmId) },
            { title: 'receiver', of: (one) => one.receiver },
            { title: 'messages', number: true, of: (one) => count(one.messageCount) },
            { title: 'last', of: told },
          ]}
        />
      )}
    </Panel>
  );
}
