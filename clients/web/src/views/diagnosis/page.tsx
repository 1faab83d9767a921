// One diagnosis: verdict and gain first, then what it looked like before and after, then the causes by rank, then what
// could not be said.
import { useState } from 'preact/hooks';
import { api } from '@/api/client';
import { Diagnosis_State, type Diagnosis, type DiscrepancyRows } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { query } from '@/app/router';
import { count, significant } from '@/format/numbers';
import { useEvents } from '@/live/events';
import { RowsMarks } from '@/parts/rows_marks';
import { Button, CommandButton } from '@/ui/button';
import { AccuracyHeading, figure } from '@/ui/accuracy';
import { Panel } from '@/ui/panel';
import { download } from '@/ui/download';
import { Awaiting, Failed, Warned } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { useWhile } from '@/ui/use_while';
import { Mark } from '@/ui/verdict';
import { ViewTitle } from '@/ui/view_title';
import { SymbolChoice } from '@/ui/choice';
import { BeforeAfter } from './before_after';
import { withCauses } from './causes';
import { ExtensionPanel } from './extension';
import { FindingPanel } from './finding';
import { GoesWith, LeftOverPanel, NotTestablePanel } from './rest';
import { SeparatingPanel } from './separating';
import { after, before, dataText, judgementOf, outputOf, sentenceCase } from './words';

export function DiagnosisPage({ id }: { id: bigint }) {
  const asked = useAsked(`diagnosis ${id}`, async (signal) => (await api.diagnosis().getDiagnosis({ diagnosisId: id }, { signal })).diagnosis!);
  const diagnosis = asked.value;
  useWhile(diagnosis?.state === Diagnosis_State.RUNNING, asked);
  const whole = useAsked(diagnosis?.state === Diagnosis_State.DONE ? `rows of diagnosis ${id}` : undefined, async (signal) =>
    (await api.diagnosis().getDiagnosis({ diagnosisId: id, withRows: true }, { signal })).rows);
  const [step, setStep] = useState<{ step: string; fraction: number }>();
  useEvents('diagnosis', (progress) => {
    if (progress.diagnosisId !== id) return;
    setStep({ step: progress.step, fraction: progress.fraction });
    if (progress.state !== Diagnosis_State.RUNNING) asked.again();
  });
  const page = useCommand(async () => {
    const { html, fileName } = await api.diagnosis().exportDiagnosis({ diagnosisId: id });
    download(fileName, html, 'text/html');
  });
  return (
    <>
      <ViewTitle
        sub={diagnosis && <>baseline <code>{diagnosis.baselineFormula}</code>{rowsText(whole.value)}{diagnosis.modelId !== undefined && <> · began from <a href={`/models/${diagnosis.modelId}`}>model {String(diagnosis.modelId)}</a></>}</>}
        actions={diagnosis?.state === Diagnosis_State.DONE && <Button busy={page.busy} onPress={() => page.send()}>Save as a page</Button>}
      >
        {diagnosis ? `Diagnosis ${id} of ${dataText(diagnosis)}` : `Diagnosis ${id}`}
      </ViewTitle>
      {page.failure && <Failed asked="Save as a page" failure={page.failure} />}
      {asked.failure && <Failed asked={`Show diagnosis ${id}`} failure={asked.failure} again={asked.again} />}
      {whole.failure && <Failed asked="Read the rows for the plots" failure={whole.failure} again={whole.again} />}
      {diagnosis ? <Body diagnosis={diagnosis} rows={whole.value} step={step} again={asked.again} /> : !asked.failure && <Awaiting what={`diagnosis ${id}`} />}
    </>
  );
}

function rowsText(rows: DiscrepancyRows | undefined): string {
  if (!rows || rows.validation.length === 0) return '';
  const validation = rows.validation.filter(Boolean).length;
  return ` · ${count(rows.validation.length - validation)} calibration, ${count(validation)} validation rows`;
}

function Body({ diagnosis, rows, step, again }: { diagnosis: Diagnosis; rows: DiscrepancyRows | undefined; step: { step: string; fraction: number } | undefined; again: () => void }) {
  const output = outputOf(diagnosis, query('out'));
  const running = diagnosis.state === Diagnosis_State.RUNNING;
  return (
    <>
      <Banner diagnosis={diagnosis} output={output} />
      {running && <Running diagnosis={diagnosis} step={step} again={again} />}
      <Remarks warnings={diagnosis.warnings} />
      {diagnosis.state === Diagnosis_State.DONE && output && (
        <>
          {rows ? <RowsMarks runIds={diagnosis.runIds}><BeforeAfter rows={rows} output={output} symbols={symbolsOf(diagnosis, output.output)} /></RowsMarks> : <SymbolChoice symbols={symbolsOf(diagnosis, output.output)} />}
          <ExtensionPanel diagnosis={diagnosis} again={again} />
          {diagnosis.findings.map((finding) => (
            <FindingPanel key={finding.number} finding={finding} diagnosis={diagnosis} output={output} rows={rows} again={again} />
          ))}
          {diagnosis.separatingExperiment && <SeparatingPanel experiment={diagnosis.separatingExperiment} diagnosis={diagnosis} />}
          <div class="columns">
            <GoesWith output={output} />
            <div class="stack">
              <LeftOverPanel diagnosis={diagnosis} />
              <NotTestablePanel diagnosis={diagnosis} />
            </div>
          </div>
        </>
      )}
    </>
  );
}

// One is shown, more wait: they tell how the search went, not what it found.
function Remarks({ warnings }: { warnings: readonly string[] }) {
  const lines = warnings.map((warning) => <Warned key={warning}>{sentenceCase(withCauses(warning)).replaceAll(' -> ', ' → ')}</Warned>);
  if (lines.length < 2) return <>{lines}</>;
  return (
    <details class="diagnosis-remarks">
      <summary><Mark kind="warn" /> {lines.length} remarks of the search</summary>
      <div class="stack">{lines}</div>
    </details>
  );
}

// The one shown first stands first, so that its choice needs no word in the address.
const symbolsOf = (diagnosis: Diagnosis, first: string) => {
  const all = diagnosis.outputs.map((one) => one.output);
  return query('out') ? all : [first, ...all.filter((one) => one !== first)];
};

function Banner({ diagnosis, output }: { diagnosis: Diagnosis; output: ReturnType<typeof outputOf> }) {
  const judged = judgementOf(diagnosis);
  return (
    <Panel class="diagnosis-banner">
      <div>
        <p class="state"><Mark kind={judged.kind} size={32} /> {judged.word}</p>
        <p class="muted">{judged.sentence}</p>
      </div>
      {output && diagnosis.state === Diagnosis_State.DONE && (
        <div class="diagnosis-figure">
          <AccuracyHeading of={diagnosis.accuracy} />
          {diagnosis.outputs.length > 1 && (
            <p class="note muted">
              all outputs: {diagnosis.outputs.map((one) => `${one.output} ${figure(before(one))} → ${figure(after(one))} ${one.unit}${after(one) > before(one) ? ' (worse)' : ''}`).join('; ')}
            </p>
          )}
          <p class="muted">{output.noiseFloor !== undefined ? `noise floor ${significant(output.noiseFloor)} ${output.unit}` : 'nothing was repeated: no noise floor'}</p>
        </div>
      )}
    </Panel>
  );
}

function Running({ diagnosis, step, again }: { diagnosis: Diagnosis; step: { step: string; fraction: number } | undefined; again: () => void }) {
  const cancel = useCommand(async () => {
    await api.diagnosis().cancelDiagnosis({ diagnosisId: diagnosis.id });
    again();
  });
  return (
    <Panel>
      <div class="row diagnosis-progress">
        <progress max={1} value={step?.fraction} aria-label="Progress of the diagnosis" />
        <span class="muted">{step?.step || 'waiting for the worker'}{step && `, ${Math.round(step.fraction * 100)} %`}</span>
        <CommandButton busy={cancel.busy} onPress={() => cancel.send()}>Cancel</CommandButton>
      </div>
      {cancel.failure && <Failed asked="Cancel" failure={cancel.failure} />}
    </Panel>
  );
}
