// One model in full.
import { modelApi } from '@/api/model';
import { usePrintFacts } from '@/app/print_head';
import { MeasuredUnder } from '@/parts/configuration';
import { Rests } from '@/parts/rests';
import type { GetModelResponse, Model, ModelOutput } from '@/api/gen/driftwise/v1/model_service_pb';
import { count, countRows, fixed, significant } from '@/format/numbers';
import { dateClock, ms, secondsOf } from '@/format/time';
import { useEvents } from '@/live/events';
import { AccuracyHeading, figure, meanFigure } from '@/ui/accuracy';
import { A90 } from '@/ui/explained';
import { Panel } from '@/ui/panel';
import { Awaiting, Failed, Warned } from '@/ui/states';
import { Tabs, tabOf } from '@/ui/tabs';
import { useAsked } from '@/ui/use_asked';
import { Verdict } from '@/ui/verdict';
import { ViewTitle } from '@/ui/view_title';
import { ExportButtons, Promote } from './actions';
import { BudgetTab } from './budget';
import { heldOut, outputSymbol, sourceText, summaryUnit } from './figures';
import { LineageTab } from './lineage';
import { ResidualsTab } from './residuals';
import { StepsTab } from './steps';
import { TermsTab } from './terms';

const tabs = [
  { id: 'terms', title: 'Terms' },
  { id: 'residuals', title: 'Residuals' },
  { id: 'steps', title: 'Steps' },
  { id: 'uncertainty', title: 'Uncertainty' },
  { id: 'lineage', title: 'Lineage' },
];

export function ModelPage({ id }: { id: bigint }) {
  const asked = useAsked(`model ${id}`, (signal) => modelApi().getModel({ modelId: id }, { signal }));
  useEvents('model', (change) => change.modelId === id && asked.again());
  const model = asked.value?.model;
  usePrintFacts([['hash of the model', model?.hash ?? ''], ['its data set', model?.lineage?.datasetHash ?? ''], ['rows kept out', model?.lineage?.exclusionsHash ?? '']]);
  return (
    <>
      <ViewTitle
        sub={model && <code>{model.formula}</code>}
        actions={model && (<><Promote model={model} onDone={asked.again} /><ExportButtons id={id} geometry={model.kinematics !== undefined} /></>)}
      >
        {`Model ${id}${model && model.name !== model.formula ? `, ${model.name}` : ''}`}
      </ViewTitle>
      {asked.failure && <Failed asked={`Show model ${id}`} failure={asked.failure} again={asked.again} />}
      {model ? <Page answer={asked.value!} model={model} /> : !asked.failure && <Awaiting what={`model ${id}`} />}
    </>
  );
}

function Page({ answer, model }: { answer: GetModelResponse; model: Model }) {
  return (
    <>
      <p class="row">
        {model.serving ? <Verdict kind="good">serves targets</Verdict> : <Verdict kind="idle">does not serve</Verdict>}
        <span class="muted">
          from {sourceText(model)}: {count(model.lineage?.calibrationRowCount)} calibration, {count(model.lineage?.validationRowCount)} validation rows;{' '}
          {model.accuracy.length > 0 ? `fitted in ${fixed((secondsOf(model.fitDuration) ?? 0) * 1000, 1)} ms` : 'imported, no data judged it'}, {dateClock(ms(model.createTime))}{model.createdBy && `, by ${model.createdBy}`}
        </span>
      </p>
      {model.accuracy.length > 0 && <Panel class="models-heading"><AccuracyHeading of={model.accuracy} /></Panel>}
      <Rests marks={model.corrections} what="fitted on data with" />
      <MeasuredUnder answer={answer} />
      <div class="tiles models-outputs">{model.outputs.map((output) => <OutputTile output={output} />)}</div>
      {model.warnings.length > 0 && (
        <details class="panel">
          <summary><Warned>{model.warnings.length === 1 ? 'one remark of the fit' : `${model.warnings.length} remarks of the fit`}</Warned></summary>
          <ul class="models-warnings">{model.warnings.map((warning) => <li>{warning}</li>)}</ul>
        </details>
      )}
      {model.kinematics ? (
        <>
          <Panel title={`Geometry: ${model.kinematics.kind}`}><pre>{model.kinematics.robotToml}</pre></Panel>
          <LineageTab model={model} />
        </>
      ) : (
        <Parts answer={answer} model={model} />
      )}
    </>
  );
}

function Parts({ answer, model }: { answer: GetModelResponse; model: Model }) {
  const tab = tabOf(tabs);
  return (
    <>
      <Tabs tabs={tabs} label="Parts of the model" />
      {tab === 'terms' && <TermsTab model={model} />}
      {tab === 'residuals' && <ResidualsTab model={model} />}
      {tab === 'steps' && <StepsTab model={model} />}
      {tab === 'uncertainty' && <BudgetTab answer={answer} />}
      {tab === 'lineage' && <LineageTab model={model} />}
    </>
  );
}

function OutputTile({ output }: { output: ModelOutput }) {
  const accuracy = output.accuracy;
  const unit = summaryUnit(output);
  const held = heldOut(accuracy);
  const offered = output.terms.filter((term) => term.term !== '1');
  return (
    <section class="tile" aria-label={`Accuracy of ${outputSymbol(output)}`}>
      <p class="label">{outputSymbol(output)}, <A90 /> on {held?.from ?? 'the fit’s own rows'}</p>
      <p class="value">{figure(held?.value ?? accuracy?.a90Calibration)} <span class="unit">{unit}</span></p>
      {accuracy?.a90Validation !== undefined && <p class="note muted">validation {figure(accuracy.a90Validation)} (mean {meanFigure(accuracy.meanValidation, accuracy.a90Validation)}, S90 {figure(accuracy.u90Validation)}) {unit}</p>}
      {accuracy?.validationSets.map((set) => (
        <p class="note muted" key={set.name}>of them {set.name}, {countRows(set.figures?.rowCount)} {figure(set.figures?.a90)} (mean {meanFigure(set.figures?.mean, set.figures?.a90)}, S90 {figure(set.figures?.u90)}) {unit}</p>
      ))}
      {accuracy?.a90Blocks !== undefined && (
        <p class="note muted">
          held-out blocks {figure(accuracy.a90Blocks)} (mean {meanFigure(accuracy.meanBlocks, accuracy.a90Blocks)}, S90 {figure(accuracy.u90Blocks)}; 90 %: {figure(accuracy.a90BlocksLow)} to {figure(accuracy.a90BlocksHigh)}) {unit}
        </p>
      )}
      <p class="note muted">calibration {figure(accuracy?.a90Calibration)} (mean {meanFigure(accuracy?.meanCalibration, accuracy?.a90Calibration)}) {unit}</p>
      <p class="note muted">
        RMSE {significant(accuracy?.rmse, 2)} {unit}; {offered.filter((term) => term.included).length} of {offered.length} terms in
        {accuracy?.pureError !== undefined && `; repeats ${significant(accuracy.pureError, 2)} ${unit}`}
      </p>
    </section>
  );
}
