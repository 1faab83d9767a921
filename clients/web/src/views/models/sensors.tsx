// Which thermometers suffice, and what each fewer costs: every set of those in the formula is tried.
import { modelApi } from '@/api/model';
import { FormulaField } from '@/formula/formula_field';
import { Field, numberTyped } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { useTyped } from '@/ui/use_typed';
import { ViewTitle } from '@/ui/view_title';
import { DataFields, useDataChoice } from './data_choice';
import { isFormula } from './fit_formula';
import { Sections } from './sections';
import { SensorsResult } from './sensors_result';
import { StudyBar } from './study_bar';
import { useStudyFormula } from './study_formula';
import { useStudy } from './use_study';

export function SensorsPage() {
  const choice = useDataChoice();
  const [formula, setFormula] = useStudyFormula();
  const [percent, setPercent] = useTyped('sensors.tolerance', '10');
  const tolerance = numberTyped(percent);
  const wrong = tolerance === undefined || tolerance < 0 || tolerance > 1000;
  const fit = { ...choice.data, formula };
  const study = useStudy('The study of thermometers', `${choice.words}: ${formula}`, async function* (signal) {
    for await (const message of modelApi().studySensors({ fit, tolerance: tolerance! / 100 }, { signal })) yield { ...message, fit };
  });
  const off = choice.missing ? 'Choose a run or a file first' : !isFormula(formula) ? 'Type a formula with thermometers in it first' : wrong ? 'Tolerance: 0 to 1000 % is expected' : undefined;
  return (
    <>
      <ViewTitle sub="Every set of the formula’s thermometers is tried, and judged on blocks of time held out of its fit">Models</ViewTitle>
      <Sections />
      <Panel title="Choose thermometers">
        <form class="stack" onSubmit={(event) => { event.preventDefault(); if (!off && !study.busy) void study.start(); }}>
          <FormulaField label="Formula" value={formula} onInput={setFormula} data={choice.data} />
          <DataFields choice={choice} label="Runs to study" />
          <div class="models-tolerance">
            <Field label="what fewer may cost" unit="%" hint="of the best A90" type="number" value={percent} onInput={setPercent} wrong={wrong ? '0 to 1000' : undefined} />
          </div>
          <StudyBar study={study} verb="Try all sets" off={off} />
        </form>
      </Panel>
      {study.answer && <SensorsResult answer={study.answer} fit={study.answer.fit} of={study.of} tookMs={study.tookMs} />}
    </>
  );
}
