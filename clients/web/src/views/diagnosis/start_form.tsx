import { useRef, useState } from 'preact/hooks';
import { api } from '@/api/client';
import { modelApi } from '@/api/model';
import { go, query } from '@/app/router';
import { FormulaField } from '@/formula/formula_field';
import { cell } from '@/live/state';
import { useRuns } from '@/parts/runs';
import { Button, CommandButton } from '@/ui/button';
import { Panel } from '@/ui/panel';
import { Failed } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { useTyped } from '@/ui/use_typed';

// From which simulation the look begins: the model that serves, another, or a formula fitted to the same rows.
export function DiagnoseForm() {
  const models = useAsked('models to begin from', async (signal) => (await modelApi().listModels({}, { signal })).models.reverse());
  const [run, setRun] = useState(query('run') ?? '');
  const runs = useRuns([run]);
  const [from, setFrom] = useState(query('model') ?? '');
  const [formula, setFormula, taken] = useTyped('diagnose.formula', 'q ~ ');
  const chosenRun = run || (runs.newest ? String(runs.newest.id) : '');
  const withPoints = runs.value?.filter((one) => one.acceptedCount > 0n || String(one.id) === chosenRun);
  const first = useRef<bigint | undefined>(undefined); // a model that begins to serve meanwhile is offered, and changes nothing
  const serving = (first.current ??= cell.value?.servingModelId);
  const begin = from || (serving !== undefined ? String(serving) : models.value?.[0] ? String(models.value[0].id) : 'formula');
  const start = useCommand(async () => {
    const { diagnosis } = await api.diagnosis().createDiagnosis({
      runIds: [BigInt(chosenRun)], ...(begin === 'formula' ? { baseline: formula } : { modelId: BigInt(begin) }),
    });
    taken();
    go(`/diagnosis/${diagnosis!.id}`);
  });
  const off = chosenRun === '' ? 'No run has points yet' : begin === 'formula' && formula.replace(/\s/g, '').length < 4 ? 'Type the formula of the simulation first' : undefined;
  return (
    <Panel title="Diagnose a run">
      <form class="stack" onSubmit={(event) => { event.preventDefault(); if (!off) void start.send(); }}>
        <div class="row diagnosis-start">
          <label class="field"><span>run</span>
            <select value={chosenRun} onChange={(event) => setRun(event.currentTarget.value)}>
              {withPoints?.map((one) => <option key={String(one.id)} value={String(one.id)}>run {String(one.id)} {one.name}</option>)}
              {withPoints?.length === 0 && <option value="">none has points yet</option>}
            </select>
          </label>
          {runs.value && !runs.isAll && <Button small busy={runs.asking} onPress={() => void runs.older()}>Load older runs</Button>}
          <label class="field"><span>simulation it is held against</span>
            <select value={begin} onChange={(event) => setFrom(event.currentTarget.value)}>
              {models.value?.map((one) => <option key={String(one.id)} value={String(one.id)}>model {String(one.id)}{one.serving ? ', serves' : ''}: {one.formula}</option>)}
              <option value="formula">a formula, fitted to these rows</option>
            </select>
          </label>
        </div>
        {begin === 'formula' && (
          <FormulaField label="Formula of the simulation" value={formula} onInput={setFormula} data={chosenRun ? { runIds: [BigInt(chosenRun)] } : undefined} />
        )}
        <div class="actions"><CommandButton kind="main" submit busy={start.busy} off={off}>Diagnose</CommandButton></div>
        {start.failure && <Failed asked="Diagnose" failure={start.failure} />}
        {runs.failure && <Failed asked="List the runs" failure={runs.failure} again={runs.again} />}
      </form>
    </Panel>
  );
}
