// What a study of thermometers found: the best set of each size, what it costs against the best of all, and the fewest that
// suffice; from there a model of these alone is one press away.
import { useMemo } from 'preact/hooks';
import { modelApi } from '@/api/model';
import type { SensorSet, StudySensorsResponse } from '@/api/gen/driftwise/v1/model_service_pb';
import { go } from '@/app/router';
import { count, fixed, signed, significant } from '@/format/numbers';
import { unitSign } from '@/format/units';
import { Plot } from '@/plot/plot';
import { CommandButton } from '@/ui/button';
import { A90 } from '@/ui/explained';
import { Panel } from '@/ui/panel';
import { Empty, Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { useCommand } from '@/ui/use_command';
import { Verdict } from '@/ui/verdict';
import { sensorsSpec } from './sensors_plot';

export interface StudiedFit {
  runIds: bigint[];
  csv?: Uint8Array;
  formula: string;
}

export function SensorsResult({ answer, fit, of, tookMs }: { answer: Omit<StudySensorsResponse, '$typeName'>; fit: StudiedFit; of: string; tookMs: number }) {
  const unit = unitSign(answer.unit);
  const all = answer.best[0]?.sensors ?? [];
  const suffices = answer.best[answer.recommended];
  const spec = useMemo(() => sensorsSpec(answer.best, answer.recommended, answer.tolerance, answer.unit), [answer]);
  if (!suffices) return <Panel><Empty>The daemon answered with no set at all.</Empty></Panel>;
  const lowest = Math.min(...answer.best.map((set) => set.a90BlocksRms));
  const costOf = (set: SensorSet) => set.a90BlocksRms - answer.best[0].a90BlocksRms;
  const outputs = suffices.outputs;
  return (
    <>
      <Panel class="models-suffice">
        <div>
          <p class="result">{suffices.sensors.length === 0 ? 'No thermometer is needed' : `${suffices.sensors.length} of ${all.length} thermometers suffice`}</p>
          <p class="models-chips"><Chips all={all} set={suffices.sensors} /></p>
          <p class="muted">
            the fewest within {fixed(100 * answer.tolerance)} % of the best{outputs.some((one) => one.a90Validation !== undefined) && ', on the validation rows as well'}; the best of {count(answer.triedSetCount)} sets tried in {fixed(tookMs / 1000, 1)} s
          </p>
        </div>
        <div class="models-suffice-side">
          <p class="muted"><A90 /> on blocks of time, all outputs</p>
          <p class="result nowrap">{significant(suffices.a90BlocksRms, 2)} {unit}</p>
          <p class="muted">{signed(costOf(suffices), 1)} {unit} against all {all.length}</p>
          {suffices.sensors.length > 0 && <FitThese fit={fit} all={all} set={suffices.sensors} main />}
        </div>
      </Panel>
      <Panel><Plot spec={spec} height={230} /></Panel>
      <Panel title="The best set of each size">
        <p class="note muted"><code>{of}</code>; {unit}, held out by blocks of time; in brackets: on the validation rows, which rank nothing and can only say no. The best of many sets looks a little better than it is.</p>
        <Table
          caption="The best set of each number of thermometers"
          rows={answer.best}
          keyOf={(set) => set.sensors.length}
          rowClass={(set) => (set === suffices ? 'chosen' : undefined)}
          columns={[
            { title: 'thermometers', number: true, of: (set) => set.sensors.length },
            { title: `A90, ${unit}`, number: true, of: (set) => <strong>{fixed(set.a90BlocksRms, 1)}</strong> },
            { title: `cost, ${unit}`, number: true, of: (set) => signed(costOf(set), 1) },
            ...outputs.map((_, at) => ({
              title: `${outputs[at].output}, ${unit}`, number: true,
              of: (set: SensorSet) => <>{fixed(set.outputs[at]?.a90Blocks, 1)}{set.outputs[at]?.a90Validation !== undefined && <span class="muted"> ({fixed(set.outputs[at].a90Validation, 1)})</span>}</>,
            })),
            { title: 'the best set', of: (set) => <span class="models-chips"><Chips all={all} set={set.sensors} /></span> },
            { title: 'verdict', of: (set) => (set === suffices ? <Verdict kind="good">suffices</Verdict> : set.a90BlocksRms === lowest ? <Verdict kind="idle">least error</Verdict> : '') },
          ]}
        />
      </Panel>
    </>
  );
}

// Each thermometer has its place in the row, so that the eye follows one down the table; one that was left out is an empty one.
function Chips({ all, set }: { all: readonly string[]; set: readonly string[] }) {
  return (
    <>
      <span class="sr-only">{set.length ? set.join(', ') : 'none'}</span>
      {all.map((one) => <span key={one} aria-hidden="true" class={`models-chip${set.includes(one) ? '' : ' models-chip-out'}`}>{one}</span>)}
    </>
  );
}

function FitThese({ fit, all, set, main }: { fit: StudiedFit; all: readonly string[]; set: readonly string[]; main?: boolean }) {
  const make = useCommand(async () => {
    const { model } = await modelApi().createFit({ ...fit, select: 'stepwise', name: `with ${set.join(', ')}`, excludeSymbols: all.filter((one) => !set.includes(one)) });
    go(`/models/${model!.id}`);
  });
  return (
    <>
      <CommandButton kind={main ? 'main' : 'plain'} busy={make.busy} onPress={() => make.send()}>Fit a model with these</CommandButton>
      {make.failure && <Failed asked="Fit" failure={make.failure} />}
    </>
  );
}
