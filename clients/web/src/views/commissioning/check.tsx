// Every device against what the cell file expects.
import { CheckVerdict, type CheckCellResponse } from '@/api/gen/driftwise/v1/commissioning_service_pb';
import { useState } from 'preact/hooks';
import { dateClock, ms } from '@/format/time';
import { CommandButton } from '@/ui/button';
import { Panel } from '@/ui/panel';
import { Empty, Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { useCommand } from '@/ui/use_command';
import { Verdict } from '@/ui/verdict';
import { commissioningApi } from './api';

const words: Record<CheckVerdict, ['good' | 'warn' | 'bad' | 'idle', string]> = {
  [CheckVerdict.UNSPECIFIED]: ['idle', 'unknown'],
  [CheckVerdict.GOOD]: ['good', 'good'],
  [CheckVerdict.WARNING]: ['warn', 'look'],
  [CheckVerdict.BAD]: ['bad', 'bad'],
  [CheckVerdict.UNKNOWN]: ['idle', 'not declared'],
};

export function Check() {
  const [found, setFound] = useState<CheckCellResponse>();
  const check = useCommand(async () => setFound(await commissioningApi().checkCell({})));
  return (
    <Panel title="Devices against the cell file" actions={<CommandButton kind="main" busy={check.busy} onPress={() => void check.send()}>Check the cell</CommandButton>}>
      {check.failure && <Failed asked="Check the cell" failure={check.failure} />}
      {!found && !check.failure && <Empty>Asks every device for its identity, range, light, resolution, clock and certificate. Nothing moves.</Empty>}
      {found && (
        <>
          <p class="muted">{dateClock(ms(found.checkTime))}</p>
          <Table
            caption="What was asked of each device"
            rows={found.items}
            keyOf={(item) => `${item.deviceId} ${item.asked}`}
            columns={[
              { title: 'device', of: (item) => item.deviceId },
              { title: 'asked', of: (item) => item.asked },
              { title: 'found', of: (item) => item.found },
              { title: 'expected', of: (item) => item.expected },
              { title: 'verdict', of: (item) => <Verdict kind={words[item.verdict][0]}>{words[item.verdict][1]}</Verdict> },
              { title: 'what to do', of: (item) => item.advice || '–' },
            ]}
          />
        </>
      )}
    </Panel>
  );
}
