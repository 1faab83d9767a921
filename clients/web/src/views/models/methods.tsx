// Our regression and the predecessors' models on the same rows, each judged on rows held out (docs/models.md).
import { useState } from 'preact/hooks';
import { modelApi } from '@/api/model';
import { FormulaField } from '@/formula/formula_field';
import { Field, numberTyped } from '@/ui/field';
import { FileInput } from '@/ui/file_input';
import { Panel } from '@/ui/panel';
import { useTyped } from '@/ui/use_typed';
import { ViewTitle } from '@/ui/view_title';
import { DataFields, useDataChoice } from './data_choice';
import { isFormula } from './fit_formula';
import { methodWords, MethodsResult } from './methods_result';
import { Sections } from './sections';
import { StudyBar } from './study_bar';
import { useStudyFormula } from './study_formula';
import { useStudy } from './use_study';

const names = ['nominal', 'kinematic', 'classic', 'stepwise'];

export function MethodsPage() {
  const choice = useDataChoice();
  const [formula, setFormula] = useStudyFormula();
  const [wanted, setWanted] = useState<readonly string[]>([]);
  const [robot, setRobot] = useState<{ name: string; bytes: Uint8Array }>();
  const [together, setTogether] = useTyped('methods.together');
  const [folds, setFolds] = useTyped('methods.folds', '10');
  const foldCount = numberTyped(folds);
  const foldsWrong = together.trim() !== '' && !(foldCount !== undefined && Number.isInteger(foldCount) && foldCount >= 2 && foldCount <= 1000);
  const study = useStudy('The comparison of methods', `${choice.words}: ${formula}`, (signal) =>
    modelApi().compareMethods({
      fit: { ...choice.data, formula: isFormula(formula) ? formula : '' },
      methods: [...wanted], robotToml: robot ? new TextDecoder().decode(robot.bytes) : '', together: together.trim(),
      ...(together.trim() !== '' && foldCount !== undefined ? { foldCount } : {}),
    }, { signal }));
  const off = choice.missing ? 'Choose a run or a file first' : foldsWrong ? 'Parts: a whole number from 2 to 1000 is expected' : undefined;
  const toggle = (name: string) => setWanted(wanted.includes(name) ? wanted.filter((one) => one !== name) : names.filter((one) => one === name || wanted.includes(one)));
  return (
    <>
      <ViewTitle sub="Our regression and the predecessors’ models on the same rows, each judged on rows that played no part in its fit">Models</ViewTitle>
      <Sections />
      <Panel title="Compare methods">
        <form class="stack" onSubmit={(event) => { event.preventDefault(); if (!off && !study.busy) void study.start(); }}>
          <FormulaField label="Formula" value={formula} onInput={setFormula} data={choice.data} />
          <DataFields choice={choice} label="Runs to compare methods on" />
          <fieldset class="choices models-methods">
            <legend>methods; none marked: all that formula and geometry allow</legend>
            {names.map((name) => (
              <label key={name}><input type="checkbox" checked={wanted.includes(name)} onChange={() => toggle(name)} /> {methodWords[name].title}</label>
            ))}
          </fieldset>
          <details>
            <summary>Geometry: {robot ? robot.name : 'of the cell file'}; held out together: {together.trim() || 'nothing'}</summary>
            <div class="row models-options">
              <FileInput label="another robot, TOML" accept=".toml,text/plain" chosen={robot?.name} onFile={setRobot} onClear={() => setRobot(undefined)} mostBytes={1 << 18} />
              <Field label="rows held out together" value={together} onInput={setTogether} mono hint="line, or channels: goal_x,goal_y; empty: not done" />
              <Field label="in how many parts" type="number" value={folds} onInput={setFolds} wrong={foldsWrong ? '2 to 1000' : undefined} />
            </div>
          </details>
          <StudyBar study={study} verb="Compare methods" off={off} />
        </form>
      </Panel>
      {study.answer && <MethodsResult answer={study.answer} of={study.of} tookMs={study.tookMs} />}
    </>
  );
}
