// Thermometers at one temperature: offset of each from the mean of all.
import { useState } from 'preact/hooks';
import type { CompareThermometersResponse } from '@/api/gen/driftwise/v1/commissioning_service_pb';
import { fixed, signed } from '@/format/numbers';
import { dateClock, ms, timestampOf } from '@/format/time';
import { cellTimeMs } from '@/live/state';
import { Button } from '@/ui/button';
import { Field, numberTyped } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { Empty, Failed, Warned } from '@/ui/states';
import { Table } from '@/ui/table';
import { useCommand } from '@/ui/use_command';
import { Verdict } from '@/ui/verdict';
import { commissioningApi } from './api';

export function Thermometers() {
  const [minutes, setMinutes] = useState('60');
  const [found, setFound] = useState<CompareThermometersResponse>();
  const wanted = numberTyped(minutes);
  const wrong = wanted === undefined || wanted < 8 || wanted > 10080 ? '8 minutes to a week' : undefined;
  const compare = useCommand(async () => {
    const to = cellTimeMs.value ?? Date.now();
    setFound(await commissioningApi().compareThermometers({ fromTime: timestampOf(to - wanted! * 60e3), toTime: timestampOf(to) }));
  }, 'reads');
  return (
    <Panel title="Thermometers side by side" actions={<Button busy={compare.busy} off={wrong} onPress={() => void compare.send()}>Compare</Button>}>
      <Field label="Minutes up to now" value={minutes} onInput={setMinutes} wrong={wrong} />
      {compare.failure && <Failed asked="Compare the thermometers" failure={compare.failure} />}
      {!found && !compare.failure && <Empty>Over a stretch in which nothing changes, all thermometers should read the same.</Empty>}
      {found && (
        <>
          {!found.quiet && <Warned>The mean drifts by {signed(1e3 * found.commonDriftKPerH, 1)} mK/h: offsets may be differences of the places.</Warned>}
          <p class="muted">{fixed(found.meanDegc, 3)} °C, {dateClock(ms(found.fromTime))} to {dateClock(ms(found.toTime))}</p>
          <Table
            caption="Offset of each thermometer from the mean of all"
            rows={found.thermometers}
            keyOf={(one) => one.channel}
            columns={[
              { title: 'thermometer', of: (one) => one.channel },
              { title: 'part', of: (one) => one.part },
              { title: 'offset, mK', number: true, sort: (one) => one.offsetK, of: (one) => signed(1e3 * one.offsetK, 1) },
              { title: 'u', number: true, of: (one) => fixed(1e3 * one.uOffsetK, 1) },
              { title: 'u certificate', number: true, of: (one) => fixed(1e3 * one.uCertificateK, 1) },
              { title: 'drift, mK/h', number: true, of: (one) => signed(1e3 * one.driftKPerH, 1) },
              { title: 'noise, mK', number: true, of: (one) => fixed(1e3 * one.noiseK, 1) },
              { title: 'verdict', of: (one) => (one.out ? <Verdict kind="bad">out: {one.sentence}</Verdict> : <Verdict kind="good">in</Verdict>) },
            ]}
          />
        </>
      )}
    </Panel>
  );
}
