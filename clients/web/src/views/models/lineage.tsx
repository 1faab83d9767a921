// Where a model comes from, what came of it, and in which range it was fitted.
import type { Model } from '@/api/gen/driftwise/v1/model_service_pb';
import { count, fixed } from '@/format/numbers';
import { splitChannel, unitSign } from '@/format/units';
import { Panel } from '@/ui/panel';
import { Table } from '@/ui/table';
import { sourceText } from './figures';
import { useModels } from './use_models';

export function lineOf(model: Model, models: readonly Model[]): Model[] {
  const line = [model];
  for (let parent = model.parentModelId; parent !== undefined; ) {
    const found = models.find((one) => one.id === parent);
    if (!found || line.includes(found)) break;
    line.unshift(found);
    parent = found.parentModelId;
  }
  return line;
}

export function LineageTab({ model }: { model: Model }) {
  const { value } = useModels();
  const models = value?.models ?? [];
  const children = models.filter((one) => one.parentModelId === model.id);
  const runs = model.lineage?.runIds ?? [];
  return (
    <div class="columns">
      <Panel title="Where it comes from">
        <ol class="models-line" aria-label="Lineage, oldest first">
          {lineOf(model, models).map((one) => (
            <li key={String(one.id)} aria-current={one.id === model.id ? 'true' : undefined}>
              <a href={`/models/${one.id}`}>model {String(one.id)}</a>{one.serving && ', serves'} <span class="muted note">{one.formula}</span>
            </li>
          ))}
        </ol>
        {children.length > 0 && <p>From it: {children.map((one) => <> <a href={`/models/${one.id}`}>model {String(one.id)}</a></>)}</p>}
        <dl class="facts">
          <dt>data</dt>
          <dd>{runs.length ? runs.map((run) => <a href={`/runs/${run}`}>run {String(run)} </a>) : sourceText(model)}</dd>
          <dt>rows</dt>
          <dd>
            {count(model.lineage?.calibrationRowCount)} calibration, {count(model.lineage?.validationRowCount)} validation, {count(model.lineage?.droppedRowCount)} left out for missing values,{' '}
            {count(model.lineage?.excludedRowCount)} kept out by a person
          </dd>
          <dt>dataset</dt><dd><code>{model.lineage?.datasetHash}</code></dd>
          <dt>model</dt><dd><code>{model.hash}</code></dd>
          <dt>chosen by</dt><dd>{model.select}{model.select === 'stepwise' && `, p to enter ${model.pEnter}, to remove ${model.pRemove}`}</dd>
          {model.note && (<><dt>note</dt><dd>{model.note}</dd></>)}
        </dl>
      </Panel>
      <Panel title="Domain in which it was fitted">
        <Table
          caption="Fitted range of every channel the model reads"
          rows={model.domain}
          keyOf={(range) => range.channel}
          columns={[
            { title: 'channel', of: (range) => splitChannel(range.channel).symbol },
            { title: 'from', number: true, of: (range) => fixed(range.min, 4) },
            { title: 'to', number: true, of: (range) => fixed(range.max, 4) },
            { title: 'unit', of: (range) => unitSign(splitChannel(range.channel).unit) },
          ]}
        />
      </Panel>
    </div>
  );
}
