// Targets: a wanted pose, what the motors have to be told under the present conditions, how sure that is, and what the
// correction looks like over the workspace.
import { useState } from 'preact/hooks';
import { api } from '@/api/client';
import { modelApi } from '@/api/model';
import type { Model } from '@/api/gen/driftwise/v1/model_service_pb';
import { cell } from '@/live/state';
import { useEvents } from '@/live/events';
import { BudgetTable } from '@/model/budget_table';
import { Panel } from '@/ui/panel';
import { Awaiting, Empty, Failed } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { Verdict } from '@/ui/verdict';
import { ViewTitle } from '@/ui/view_title';
import { Live } from './live';
import { Parts } from './parts';
import { CorrectionMap } from './map';
import { numberWanted, PoseForm } from './pose_form';
import { fieldsOf, poseOf, unreadOf, type Typed } from './pose';
import { Result } from './result';
import { useTarget } from './use_target';
import { Where } from './where';
import './view.css';

export default function Targets() {
  const asked = useAsked('serving model', async (signal) => {
    const { servingModelId } = await api.cell().getStatus({}, { signal });
    return servingModelId === undefined ? null : ((await modelApi().getModel({ modelId: servingModelId }, { signal })).model ?? null);
  });
  useEvents('model', () => asked.again());
  const [datum, setDatum] = useState('');
  useEvents('record', (event) => event.what === 'datum.opened' && setDatum(String(event.id)));
  const model = asked.value;
  return (
    <>
      <ViewTitle sub={model ? <>by <a href={`/models/${model.id}`}>model {String(model.id)}</a>, <code>{model.formula}</code></> : undefined}>Targets</ViewTitle>
      {asked.failure && <Failed asked="Find the model that serves" failure={asked.failure} again={asked.again} />}
      {model === null && <Empty next={<><a href="/models">Promote a model</a>, or ask for a <a href="/plans">joint target</a> of a serving plan</>}>No model serves, so there are no targets{cell.value ? ` in cell ${cell.value.cellName}` : ''}.</Empty>}
      {model ? <Served model={model} datum={datum} /> : model === undefined && !asked.failure && <Awaiting what="the model that serves" />}
    </>
  );
}

function Served({ model, datum }: { model: Model; datum: string }) {
  const fields = fieldsOf(model.domain);
  const [typed, setTyped] = useState<Typed>({});
  const pose = poseOf(fields, typed);
  const by = { modelId: model.id, datum };
  const target = useTarget(pose, by);
  const unread = unreadOf(fields, typed);
  const form = <PoseForm fields={fields} typed={typed} type={(symbol, text) => setTyped((old) => ({ ...old, [symbol]: text }))} />;
  if (unread.length > 0) {
    return (
      <>
        {form}
        <Panel title="Motor coordinates">
          {unread.map((field) => <Verdict key={field.channel} kind="bad">no target: {field.symbol} is not read, {numberWanted(field)}</Verdict>)}
        </Panel>
        <Where pose={pose} by={by} />
      </>
    );
  }
  return (
    <>
      {form}
      <Result state={target} pose={pose} />
      <div class="columns">
        <div class="stack targets-side">
          {target.target && <Panel title="What the correction is made of"><Parts coordinates={target.target.coordinates} /></Panel>}
          <Live history={target.history} outputs={model.outputs.map((output) => output.channel)} />
        </div>
        <CorrectionMap fields={fields} pose={pose} outputs={model.outputs.map((output) => output.channel)} conditions={target.target?.conditionsTime} by={by} />
      </div>
      <Where pose={pose} by={by} />
      {target.target && <Panel title="What the uncertainty is made of"><BudgetTable coordinates={target.target.coordinates} /></Panel>}
    </>
  );
}
