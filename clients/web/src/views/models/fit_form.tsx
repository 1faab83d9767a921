// Which data, which formula, how chosen: then a fit on the daemon's worker. What was typed stays until it was taken.
import { useState } from 'preact/hooks';
import { modelApi } from '@/api/model';
import { go } from '@/app/router';
import { FormulaField } from '@/formula/formula_field';
import { CommandButton } from '@/ui/button';
import { Field, numberTyped } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';
import { useTyped } from '@/ui/use_typed';
import { DataFields, useDataChoice } from './data_choice';
import { firstFormula, isFormula } from './fit_formula';

export function FitForm() {
  const choice = useDataChoice();
  const [formula, setFormula, formulaTaken] = useTyped('fit.formula', firstFormula);
  const [name, setName, nameTaken] = useTyped('fit.name');
  const [pEnter, setPEnter] = useTyped('fit.p_enter', '0.05');
  const [pRemove, setPRemove] = useTyped('fit.p_remove', '0.10');
  const [select, setSelect] = useState('stepwise');
  const [criterion, setCriterion] = useState('p');
  const enter = numberTyped(pEnter);
  const remove = numberTyped(pRemove);
  const badP = enter === undefined || remove === undefined || !(enter > 0 && enter <= remove && remove < 1);
  const fit = useCommand(async () => {
    const { model } = await modelApi().createFit({
      ...choice.data, formula, name, select, criterion, ...(select === 'stepwise' && criterion === 'p' ? { pEnter: enter, pRemove: remove } : {}),
    });
    formulaTaken();
    nameTaken();
    go(`/models/${model!.id}`);
  });
  const off = choice.missing ? 'Choose a run or a file first'
    : !isFormula(formula) ? 'Type a formula first'
    : badP ? 'The two probabilities need 0 < enter ≤ remove < 1' : undefined;
  return (
    <Panel title="Fit a model">
      <form class="stack" onSubmit={(event) => { event.preventDefault(); if (!off) void fit.send(); }}>
        <FormulaField label="Formula" value={formula} onInput={setFormula} data={choice.data} onEnter={() => !off && fit.send()}>
          {fit.failure && <Failed asked="Fit" failure={fit.failure} />}
        </FormulaField>
        <DataFields choice={choice} label="Runs to fit from" />
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
      </form>
    </Panel>
  );
}
