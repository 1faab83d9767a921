// Procedure: the study's steps 0 to 5, each with a state that the daemon computes from its record, what is missing, the command
// that does it, and where to go back to when the wanted accuracy is not reached.
import { useRef } from 'preact/hooks';
import { ProcedureStep_State, type ProcedureStep, type ProcedureStep_Figure } from '@/api/gen/driftwise/v1/study_service_pb';
import { fixed, significant } from '@/format/numbers';
import { useEvents } from '@/live/events';
import { Button } from '@/ui/button';
import { Panel } from '@/ui/panel';
import { Awaiting, Failed, Warned } from '@/ui/states';
import { Table, type Column } from '@/ui/table';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { Verdict } from '@/ui/verdict';
import { ViewTitle } from '@/ui/view_title';
import { studyApi } from './api';
import './view.css';

export default function ProcedureView() {
  const asked = useAsked('procedure', (signal) => studyApi().getProcedure({}, { signal }));
  const told = useRef('');
  useEvents('run', (run) => {
    const now = `${run.id} ${run.state}`;
    if (now !== told.current) asked.again();
    told.current = now;
  });
  return (
    <>
      <ViewTitle sub="Each state is computed from the record: nothing here is ticked by hand">Procedure</ViewTitle>
      {asked.failure && <Failed asked="Show the procedure" failure={asked.failure} again={asked.again} />}
      {!asked.value && !asked.failure && <Awaiting what="the procedure" />}
      {asked.value && (
        <div class="stack">
          <Outcome steps={asked.value.steps} />
          <ol class="procedure-steps">{asked.value.steps.map((step) => <li key={step.number}><Step step={step} /></li>)}</ol>
        </div>
      )}
    </>
  );
}

// One sentence above the steps: reached, not reached and back to where, or what comes next.
function Outcome({ steps }: { steps: readonly ProcedureStep[] }) {
  const last = steps.at(-1);
  const open = steps.find((step) => step.state === ProcedureStep_State.OPEN);
  if (last?.state === ProcedureStep_State.NOT_REACHED)
    return (
      <p>
        <Verdict kind="bad">
          The wanted accuracy is not reached: <a href={`#step-${last.backToStep ?? 0}`}>back to step {last.backToStep ?? 0}</a>
          {last.largestUNm !== undefined && `; the largest line of the budget is ${last.largestLine}, ${fixed(last.largestUNm, 1)} nm`}
        </Verdict>
      </p>
    );
  if (last?.state === ProcedureStep_State.DONE) return <p><Verdict kind="good">The wanted accuracy is reached</Verdict></p>;
  return open ? <p><Verdict kind="warn">Next: <a href={`#step-${open.number}`}>step {open.number}, {open.name}</a></Verdict></p> : null;
}

const kinds = { [ProcedureStep_State.DONE]: 'good', [ProcedureStep_State.OPEN]: 'warn', [ProcedureStep_State.NOT_REACHED]: 'bad', [ProcedureStep_State.UNSPECIFIED]: 'idle' } as const;
const words = { [ProcedureStep_State.DONE]: 'done', [ProcedureStep_State.OPEN]: 'open', [ProcedureStep_State.NOT_REACHED]: 'not reached', [ProcedureStep_State.UNSPECIFIED]: 'unknown' } as const;

function Step({ step }: { step: ProcedureStep }) {
  return (
    <Panel
      title={<span id={`step-${step.number}`}>{step.number} · {step.name}</span>}
      actions={<Verdict kind={kinds[step.state]}>{words[step.state]}</Verdict>}
    >
      {step.sources.length === 0 && step.found && <p>{step.found}</p>}
      {step.sources.length > 0 && <Sources step={step} />}
      {step.figures.length > 0 && <Figures step={step} />}
      {step.missing && step.sources.length === 0 && <Warned>{step.missing}</Warned>}
      {step.command && <Command text={step.command} step={step.number} />}
    </Panel>
  );
}

function Sources({ step }: { step: ProcedureStep }) {
  return (
    <Table
      caption="Sources of inaccuracy"
      rows={step.sources}
      keyOf={(source) => source.name}
      columns={[
        { title: 'source', of: (source) => source.name },
        { title: 'considered', of: (source) => (source.considered ? <Verdict kind="good">measured</Verdict> : <Verdict kind="warn">not measured</Verdict>) },
        { title: 'by', of: (source) => <span class="procedure-channels">{source.measuredBy || '–'}</span> },
      ]}
    />
  );
}

const isMissed = (figure: ProcedureStep_Figure) => figure.a90 !== undefined && figure.wantedA90 !== undefined && figure.a90 > figure.wantedA90;

function Figures({ step }: { step: ProcedureStep }) {
  const columns: Column<ProcedureStep_Figure>[] = [
    { title: 'coordinate', of: (figure) => figure.coordinate || (figure.unit === 'arcsec' ? 'every rotation' : 'every length') },
    { title: 'wanted A90', number: true, of: (figure) => (figure.wantedA90 === undefined ? 'nothing' : `${significant(figure.wantedA90, 3)} ${figure.unit}`) },
  ];
  if (step.figures.some((figure) => figure.a90 !== undefined)) {
    columns.splice(1, 0, { title: 'A90', number: true, of: (figure) => (figure.a90 === undefined ? 'not measured' : `${significant(figure.a90, 3)} ${figure.unit}`) });
    columns.push({ title: 'verdict', of: (figure) => (figure.a90 === undefined || figure.wantedA90 === undefined ? '–' : isMissed(figure) ? <Verdict kind="bad">missed</Verdict> : <Verdict kind="good">reached</Verdict>) });
  }
  return <Table caption={`Accuracy of step ${step.number}`} rows={step.figures} keyOf={(figure) => `${figure.coordinate} ${figure.unit}`} columns={columns} />;
}

// A command line to copy: it is for a shell on the measuring computer, where what it moves is asked about.
function Command({ text, step }: { text: string; step: number }) {
  const copy = useCommand(() => navigator.clipboard.writeText(text), 'reads');
  return (
    <div class="procedure-command">
      <code>{text}</code>
      <Button small busy={copy.busy} onPress={() => void copy.send()} label={`Copy the command of step ${step}`}>Copy</Button>
      {copy.failure && <Failed asked="Copy" failure={copy.failure} />}
    </div>
  );
}
