// Which data, which formula, how chosen: then a fit on the daemon's worker. What was typed stays until it was taken.
import { useState } from 'preact/hooks';
import { api } from '@/api/client';
import { Run_State } from '@/api/gen/driftwise/v1/run_pb';
import { go, query } from '@/app/router';
import { FormulaField } from '@/formula/formula_field';
import { count } from '@/format/numbers';
import { dateClock, ms } from '@/format/time';
import { useEvents } from '@/live/events';
import { CommandButton } from '@/ui/button';
import { Field, numberTyped } from '@/ui/field';
import { FileInput } from '@/ui/file_input';
import { Panel } from '@/ui/panel';
import { Failed } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { useTyped } from '@/ui/use_typed';

const firstFormula = 'q ~ ';

// Runs that have points, newest first.
function useRunsWithPoints() {
  const asked = useAsked('runs with points', async (signal) => {
    const { runs } = await api.run().listRuns({ limit: 200 }, { signal });
    return runs.filter((run) => run.acceptedCount > 0n);
  });
  useEvents('run', (run) => run.state >= Run_State.DONE && asked.again());
  return asked;
}

export function FitForm() {
  const runs = useRunsWithPoints();
  const wanted = query('run');
  const [marked, setMarked] = useState<readonly string[] | undefined>(wanted ? wanted.split(',') : undefined);
  const [file, setFile] = useState<{ name: string; bytes: Uint8Array }>();
  const [formula, setFormula, formulaTaken] = useTyped('fit.formula', firstFormula);
  const [name, setName, nameTaken] = useTyped('fit.name');
  const [pEnter, setPEnter] = useTyped('fit.p_enter', '0.05');
  const [pRemove, setPRemove] = useTyped('fit.p_remove', '0.10');
  const [select, setSelect] = useState('stepwise');
  const [criterion, setCriterion] = useState('p');
  const known = runs.value ?? [];
  const chosen = file ? [] : (marked ?? (known[0] ? [String(known[0].id)] : []));
  const data = file ? { runIds: [], csv: file.bytes } : { runIds: chosen.map(BigInt) };
  const enter = numberTyped(pEnter);
  const remove = numberTyped(pRemove);
  const badP = enter === undefined || remove === undefined || !(enter > 0 && enter <= remove && remove < 1);
  const fit = useCommand(async () => {
    const { model } = await api.model().createFit({
      ...data, formula, name, select, criterion, ...(select === 'stepwise' && criterion === 'p' ? { pEnter: enter, pRemove: remove } : {}),
    });
    formulaTaken();
    nameTaken();
    go(`/models/${model!.id}`);
  });
  const off = !file && chosen.length === 0 ? 'Choose a run or a file first'
    : formula.trim() === '' || formula.trim() === firstFormula.trim() ? 'Type a formula first'
    : badP ? 'The two probabilities need 0 < enter ≤ remove < 1' : undefined;
  return (
    <Panel title="Fit a model">
      <form class="stack" onSubmit={(event) => { event.preventDefault(); if (!off) void fit.send(); }}>
        <FormulaField label="Formula" value={formula} onInput={setFormula} data={data} onEnter={() => !off && fit.send()} />
        <div class="row models-data">
          <details class="models-runs">
            <summary>{file ? `data: ${file.name}` : chosen.length ? `data: ${chosen.length === 1 ? 'run' : 'runs'} ${chosen.join(', ')}` : 'data: choose runs'}</summary>
            <fieldset disabled={file !== undefined}>
              <legend class="sr-only">Runs to fit from</legend>
              {known.map((run) => (
                <label key={String(run.id)} class="models-run">
                  <input
                    type="checkbox"
                    checked={chosen.includes(String(run.id))}
                    onChange={() => setMarked(chosen.includes(String(run.id)) ? chosen.filter((one) => one !== String(run.id)) : [...chosen, String(run.id)])}
                  />
                  <span>run {String(run.id)} {run.name}</span>
                  <span class="note muted">{count(run.acceptedCount)} points, {dateClock(ms(run.startTime))}</span>
                </label>
              ))}
              {runs.value && known.length === 0 && <p class="muted">No run has points yet. <a href="/trajectories">Start one</a>, or take a file.</p>}
            </fieldset>
            {runs.failure && <Failed asked="List the runs" failure={runs.failure} again={runs.again} />}
          </details>
          <FileInput label="or a dataset, CSV" accept=".csv,text/csv" chosen={file?.name} onFile={setFile} onClear={() => setFile(undefined)} mostBytes={32 << 20} />
        </div>
        <details>
          <summary>How terms are chosen: {select === 'all' ? 'all of them' : criterion === 'p' ? `stepwise, p to enter ${pEnter}, to remove ${pRemove}` : `stepwise, by ${criterion.toUpperCase()}`}</summary>
          <div class="row models-options">
            <label class="field"><span>terms</span>
              <select value={select} onChange={(event) => setSelect(event.currentTarget.value)}>
                <option value="stepwise">stepwise: those that help</option>
                <option value="all">all that are offered</option>
              </select>
            </label>
            {select === 'stepwise' && (
              <label class="field"><span>criterion</span>
                <select value={criterion} onChange={(event) => setCriterion(event.currentTarget.value)}>
                  <option value="p">p-value</option>
                  <option value="bic">BIC</option>
                  <option value="aic">AIC</option>
                </select>
              </label>
            )}
            {select === 'stepwise' && criterion === 'p' && (
              <>
                <Field label="p to enter" type="number" value={pEnter} onInput={setPEnter} wrong={badP ? 'between 0 and p to remove' : undefined} />
                <Field label="p to remove" type="number" value={pRemove} onInput={setPRemove} />
              </>
            )}
            <Field label="name" value={name} onInput={setName} hint="empty: the formula" />
          </div>
        </details>
        <div class="actions">
          <CommandButton kind="main" submit busy={fit.busy} off={off}>Fit</CommandButton>
          {fit.busy && <span class="muted">Fitting on the daemon's worker …</span>}
        </div>
        {fit.failure && <Failed asked="Fit" failure={fit.failure} />}
      </form>
    </Panel>
  );
}
