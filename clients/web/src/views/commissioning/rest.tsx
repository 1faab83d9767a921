// A cell at rest: since when each length and temperature drifts by no more than its limit.
import type { RestChannel } from '@/api/gen/driftwise/v1/commissioning_service_pb';
import { fixed, signed } from '@/format/numbers';
import { dateClock, ms } from '@/format/time';
import { CommandButton } from '@/ui/button';
import { Panel } from '@/ui/panel';
import { Empty, Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { useWhile } from '@/ui/use_while';
import { Verdict } from '@/ui/verdict';
import { commissioningApi } from './api';

const lookEvery_ms = 10_000;
const digitsOf = (one: RestChannel) => (one.changeUnit === 'nm' ? 1 : 4);

export function RestPanel() {
  const asked = useAsked('rest', async (signal) => commissioningApi().getRest({}, { signal }));
  useWhile(true, asked, lookEvery_ms);
  const begin = useCommand(async () => {
    await commissioningApi().beginRest({});
    asked.again();
  });
  const end = useCommand(async () => {
    await commissioningApi().endRest({});
    asked.again();
  });
  const rest = asked.value?.rest;
  const underWay = rest !== undefined && rest.endTime === undefined;
  const none = asked.failure !== undefined && /NO_REST|no rest/.test(`${asked.failure.reason ?? ''} ${asked.failure.message}`);
  return (
    <Panel
      title="At rest"
      actions={underWay
        ? <CommandButton busy={end.busy} onPress={() => void end.send()}>End the rest</CommandButton>
        : <CommandButton kind="main" busy={begin.busy} onPress={() => void begin.send()}>Begin a rest</CommandButton>}
    >
      {begin.failure && <Failed asked="Begin a rest" failure={begin.failure} />}
      {end.failure && <Failed asked="End the rest" failure={end.failure} />}
      {asked.failure && !none && <Failed asked="Look at the rest" failure={asked.failure} again={asked.again} />}
      {!rest && <Empty>Lengths and temperatures are recorded while nothing moves, until each drifts by less than its limit: 20 nm/h, 0.05 K/h.</Empty>}
      {rest && (
        <>
          <p><Verdict kind={rest.warmTime ? 'good' : 'warn'}>{rest.sentence}</Verdict> <span class="muted">since {dateClock(ms(rest.beginTime))}{underWay ? '' : `, over: ${rest.endReason}`}</span></p>
          <Table
            caption="Drift of every channel"
            rows={rest.channels}
            keyOf={(one) => one.channel}
            columns={[
              { title: 'channel', of: (one) => one.channel },
              { title: 'rate', number: true, of: (one) => `${signed(one.rate, digitsOf(one))} ${one.unit}` },
              { title: 'u', number: true, of: (one) => fixed(one.uRate, digitsOf(one)) },
              { title: 'limit', number: true, of: (one) => String(one.limit) },
              { title: 'change', number: true, of: (one) => `${signed(one.change, digitsOf(one))} ${one.changeUnit}` },
              { title: 'warm since', of: (one) => (one.warmTime ? dateClock(ms(one.warmTime)) : 'not yet') },
            ]}
          />
        </>
      )}
    </Panel>
  );
}
