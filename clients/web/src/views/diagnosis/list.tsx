import { api } from '@/api/client';
import { Diagnosis_State, Improvement_State, type Diagnosis, type Improvement } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { significant } from '@/format/numbers';
import { dateClock, ms } from '@/format/time';
import { useEvents } from '@/live/events';
import { Panel } from '@/ui/panel';
import { Awaiting, Empty, Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { useAsked } from '@/ui/use_asked';
import { Verdict } from '@/ui/verdict';
import { ViewTitle } from '@/ui/view_title';
import { causeText } from './causes';
import { ImproveForm } from './improve_form';
import { DiagnoseForm } from './start_form';
import { after, before, dataText, judgementOf, sentenceCase } from './words';

export function DiagnosisList() {
  const diagnoses = useAsked('diagnoses', async (signal) => (await api.diagnosis().listDiagnoses({}, { signal })).diagnoses);
  const improvements = useAsked('improvements', async (signal) => (await api.diagnosis().listImprovements({}, { signal })).improvements);
  useEvents('diagnosis', (progress) => (progress.state !== Diagnosis_State.RUNNING || !diagnoses.value?.some((one) => one.id === progress.diagnosisId)) && diagnoses.again());
  useEvents('improvement', () => improvements.again());
  return (
    <>
      <ViewTitle sub="What the simulation gets wrong, why, and what was made of it">Diagnosis</ViewTitle>
      <DiagnoseForm />
      <Panel title="Diagnoses">
        {diagnoses.failure && <Failed asked="List the diagnoses" failure={diagnoses.failure} again={diagnoses.again} />}
        {diagnoses.value ? <Diagnoses rows={diagnoses.value} /> : !diagnoses.failure && <Awaiting what="the diagnoses" />}
      </Panel>
      <ImproveForm />
      <Panel title="Improvements">
        {improvements.failure && <Failed asked="List the improvements" failure={improvements.failure} again={improvements.again} />}
        {improvements.value ? <Improvements rows={improvements.value} /> : !improvements.failure && <Awaiting what="the improvements" />}
      </Panel>
    </>
  );
}

function Diagnoses({ rows }: { rows: readonly Diagnosis[] }) {
  if (rows.length === 0) return <Empty next="Choose a run above and press Diagnose.">No diagnosis yet.</Empty>;
  return (
    <Table
      caption="Diagnoses, newest first"
      rows={rows}
      keyOf={(one) => String(one.id)}
      columns={[
        { title: 'diagnosis', number: true, of: (one) => <a href={`/diagnosis/${one.id}`}>{String(one.id)}</a> },
        { title: 'verdict', of: (one) => <Verdict kind={judgementOf(one).kind}>{judgementOf(one).word.toLowerCase()}</Verdict> },
        { title: 'of', of: dataText },
        { title: 'baseline', of: (one) => <code class="models-formula">{one.baselineFormula}</code> },
        { title: 'causes', of: (one) => one.findings.map((finding) => causeText(finding.cause, finding.subject)).join('; ') || '–' },
        { title: 'A90', of: (one) => one.outputs.map((output) => <span class="nowrap diagnosis-gain">{output.output} {significant(before(output))} → {significant(after(output))} {output.unit}</span>) },
        { title: 'made', of: (one) => <span class="nowrap">{dateClock(ms(one.createTime))}</span> },
        { title: 'by', of: (one) => one.createdBy },
      ]}
    />
  );
}

const stateWords: Record<number, readonly ['good' | 'warn' | 'bad' | 'idle', string]> = {
  [Improvement_State.RUNNING]: ['good', 'under way'],
  [Improvement_State.DONE]: ['good', 'done'],
  [Improvement_State.CANCELLED]: ['idle', 'cancelled'],
  [Improvement_State.FAILED]: ['bad', 'failed'],
};
export const improvementWords = (state: Improvement_State) => stateWords[state] ?? (['idle', 'unknown'] as const);

function Improvements({ rows }: { rows: readonly Improvement[] }) {
  if (rows.length === 0) return <Empty>No improvement yet: the loop measures, fits, diagnoses, extends and measures again.</Empty>;
  return (
    <Table
      caption="Improvements, newest first"
      rows={rows}
      keyOf={(one) => String(one.id)}
      columns={[
        { title: 'improvement', number: true, of: (one) => <a href={`/diagnosis/improve/${one.id}`}>{String(one.id)}</a> },
        { title: 'state', of: (one) => <Verdict kind={improvementWords(one.state)[0]}>{improvementWords(one.state)[1]}</Verdict> },
        { title: 'turns', number: true, of: (one) => one.turns.length },
        { title: 'ended because', of: (one) => sentenceCase(one.reason) || '–' },
        { title: 'trajectory', of: (one) => one.trajectoryName },
        { title: 'begun', of: (one) => <span class="nowrap">{dateClock(ms(one.createTime))}</span> },
        { title: 'by', of: (one) => one.createdBy },
      ]}
    />
  );
}
