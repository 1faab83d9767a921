import { useState } from 'preact/hooks';
import type { Model, Promotion } from '@/api/gen/driftwise/v1/model_service_pb';
import { Promotion_Action } from '@/api/gen/driftwise/v1/model_service_pb';
import { go } from '@/app/router';
import { count } from '@/format/numbers';
import { dateClock, ms } from '@/format/time';
import { unitSign } from '@/format/units';
import { Button } from '@/ui/button';
import { figure, rowsInWords } from '@/ui/accuracy';
import { A90 } from '@/ui/explained';
import { Panel } from '@/ui/panel';
import { Awaiting, Empty, Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { Verdict } from '@/ui/verdict';
import { ViewTitle } from '@/ui/view_title';
import { sourceText } from './figures';
import { FitForm } from './fit_form';
import { RollBack } from './roll_back';
import { Sections } from './sections';
import { useModels } from './use_models';

export function ModelList() {
  const asked = useModels();
  const [chosen, setChosen] = useState<readonly bigint[]>([]);
  const toggle = (id: bigint) => setChosen((old) => (old.includes(id) ? old.filter((one) => one !== id) : [...old.slice(-1), id]));
  const serving = asked.value?.models.find((model) => model.serving);
  return (
    <>
      <ViewTitle
        sub={serving ? <>Model <a href={`/models/${serving.id}`}>{String(serving.id)}</a> serves targets</> : 'No model serves targets'}
        actions={asked.value && <RollBack promotions={asked.value.promotions} onDone={asked.again} />}
      >
        Models
      </ViewTitle>
      <Sections />
      <FitForm />
      {asked.failure && <Failed asked="List the models" failure={asked.failure} again={asked.again} />}
      {asked.value ? (
        <Panel
          title="Fitted so far"
          actions={
            <Button
              small
              off={chosen.length === 2 ? undefined : 'Mark two models in the list first'}
              onPress={() => go(`/models/compare?a=${chosen[0]}&b=${chosen[1]}`)}
            >
              Compare the two marked
            </Button>
          }
        >
          {asked.value.models.length === 0 ? (
            <Empty next="Choose runs above, type a formula and press Fit.">No model yet.</Empty>
          ) : (
            <ModelTable models={asked.value.models} chosen={chosen} toggle={toggle} />
          )}
        </Panel>
      ) : (
        !asked.failure && <Awaiting what="the models" />
      )}
      {asked.value && asked.value.promotions.length > 0 && <Promotions promotions={asked.value.promotions} />}
    </>
  );
}

function ModelTable({ models, chosen, toggle }: { models: readonly Model[]; chosen: readonly bigint[]; toggle: (id: bigint) => void }) {
  return (
    <>
      <p class="note muted"><A90 />: the worst output on the rows held out of the fit, per unit; of calibration where none were</p>
      <Table
        caption="Models, newest first"
        rows={models}
        keyOf={(model) => String(model.id)}
        columns={[
          {
            title: 'mark',
            of: (model) => (
              <label class="models-mark">
                <input type="checkbox" checked={chosen.includes(model.id)} onChange={() => toggle(model.id)} />
                <span class="sr-only">compare model {String(model.id)}</span>
              </label>
            ),
          },
          { title: 'model', number: true, sort: (model) => Number(model.id), of: (model) => <a href={`/models/${model.id}`}>{String(model.id)}</a> },
          { title: 'state', of: (model) => (model.damage ? <Verdict kind="bad">damaged: {model.damage}</Verdict> : model.serving ? <Verdict kind="good">serves</Verdict> : '') },
          ...(models.some((model) => model.corrections.length > 0) ? [{ title: 'rests on', of: (model: Model) => model.corrections.map((mark) => <Verdict kind={mark.endTime ? 'bad' : 'warn'}>correction {String(mark.correctionId)}{mark.endTime && ', taken back'}</Verdict>) }] : []),
          { title: 'name', of: (model) => model.name !== model.formula && model.name },
          { title: 'formula', of: (model) => <code class="models-formula">{model.formula}</code> },
          { title: 'from', of: (model) => <span class="nowrap">{sourceText(model)}</span> },
          { title: 'rows', number: true, of: (model) => count(model.lineage?.calibrationRowCount) },
          { title: 'A90', of: (model) => model.accuracy.map((one) => <span class="nowrap" key={one.unit}>{figure(one.figures?.a90)} {unitSign(one.unit)} <span class="note muted">{one.output}, {rowsInWords(one.rows)}</span></span>) },
          { title: 'made', of: (model) => <span class="nowrap">{dateClock(ms(model.createTime))}</span> },
          { title: 'by', of: (model) => model.createdBy },
        ]}
      />
    </>
  );
}

function Promotions({ promotions }: { promotions: readonly Promotion[] }) {
  return (
    <Panel title="What served when">
      <Table
        caption="Promotions and rollbacks, newest first"
        rows={promotions}
        page={10}
        keyOf={(promotion) => `${ms(promotion.promoteTime)}`}
        columns={[
          { title: 'since', of: (p) => dateClock(ms(p.promoteTime)) },
          { title: 'model', of: (p) => (p.modelId === undefined ? 'none' : <a href={`/models/${p.modelId}`}>model {String(p.modelId)}</a>) },
          { title: 'how', of: (p) => (p.action === Promotion_Action.ROLLBACK ? 'rolled back' : 'promoted') },
          { title: 'by', of: (p) => p.promotedBy },
        ]}
      />
    </Panel>
  );
}
