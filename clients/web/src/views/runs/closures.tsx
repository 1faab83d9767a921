// Returns to zero as they were judged: found, limit, what was expected, and what was done.
import { api } from '@/api/client';
import { Closure_Decision, type Closure, type Run } from '@/api/gen/driftwise/v1/run_pb';
import { fixed, signed } from '@/format/numbers';
import { dateClock, ms } from '@/format/time';
import { splitChannel, unitSign } from '@/format/units';
import { useEvents } from '@/live/events';
import { Panel } from '@/ui/panel';
import { Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { useAsked } from '@/ui/use_asked';
import { Verdict } from '@/ui/verdict';

export const decisionWords: Record<Closure_Decision, string> = {
  [Closure_Decision.UNSPECIFIED]: '', [Closure_Decision.WITHIN]: 'within the limit', [Closure_Decision.EXPLAINED]: 'explained',
  [Closure_Decision.PLAY]: 'play', [Closure_Decision.MARKED]: 'line suspect', [Closure_Decision.REPEATED]: 'line repeated',
  [Closure_Decision.NEW_DATUM]: 'new datum',
};

interface Row { closure: Closure; place: number }

const rowsOf = (closures: readonly Closure[]): Row[] => closures.flatMap((closure) => closure.coordinates.map((_, place) => ({ closure, place })));
const figure = (unit: string, value: number, sign = true) => (sign ? signed(value, unit === 'nm' ? 0 : 2) : fixed(value, unit === 'nm' ? 0 : 2));

export function Closures({ run }: { run: Run }) {
  const closures = useAsked(`closures of run ${run.id}`, async (signal) => (await api.run().listClosures({ runId: run.id }, { signal })).closures);
  useEvents('record', (event) => void (event.runId === run.id && event.what.startsWith('run.closure') && closures.again()));
  if (closures.failure) return <Failed asked="List the returns to zero" failure={closures.failure} again={closures.again} />;
  if (!closures.value?.length) return null;
  const unusual = closures.value.filter((one) => one.decision !== Closure_Decision.WITHIN);
  return (
    <Panel title="Returns to zero">
      {unusual.length === 0 ? <Verdict kind="good">all {closures.value.length} within their limits</Verdict> : (
        <ul>{unusual.map((one) => <li key={String(one.id)}>line {String(one.line)}: {one.sentence}</li>)}</ul>
      )}
      <Table
        caption="Returns to zero as they were judged"
        rows={rowsOf(closures.value)}
        keyOf={({ closure, place }) => `${closure.id}.${place}`}
        page={50}
        columns={[
          { title: 'line', number: true, of: ({ closure }) => `${closure.line}${closure.repetition ? ', again' : ''}` },
          { title: 'measured', of: ({ closure }) => <span class="nowrap">{dateClock(ms(closure.measureTime))}</span> },
          { title: 'coordinate', of: ({ closure, place }) => splitChannel(closure.coordinates[place].channel).symbol },
          { title: 'in', of: ({ closure, place }) => unitSign(closure.coordinates[place].unit) },
          { title: 'found', number: true, of: ({ closure, place }) => figure(closure.coordinates[place].unit, closure.coordinates[place].found) },
          { title: 'limit', number: true, of: ({ closure, place }) => figure(closure.coordinates[place].unit, closure.coordinates[place].limit, false) },
          { title: 'expected', number: true, of: ({ closure, place }) => figure(closure.coordinates[place].unit, closure.coordinates[place].expected) },
          { title: 'play', number: true, of: ({ closure, place }) => figure(closure.coordinates[place].unit, closure.coordinates[place].play) },
          { title: 'noise u', number: true, of: ({ closure, place }) => figure(closure.coordinates[place].unit, closure.coordinates[place].noise, false) },
          { title: 'from', of: ({ closure }) => closure.side },
          { title: 'verdict', of: ({ closure }) => decisionWords[closure.decision] },
        ]}
      />
    </Panel>
  );
}
