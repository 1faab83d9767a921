// The improve loop, turn by turn.
import { useState } from 'preact/hooks';
import { api } from '@/api/client';
import { Improvement_State, type Improvement, type ImprovementTurn, type ImprovementTurn_Gain } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { significant } from '@/format/numbers';
import { dateClock, ms } from '@/format/time';
import { useEvents } from '@/live/events';
import { Bar } from '@/ui/bar';
import { CommandButton } from '@/ui/button';
import { meanFigure } from '@/ui/accuracy';
import { A90 } from '@/ui/explained';
import { Panel } from '@/ui/panel';
import { Awaiting, Empty, Failed } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { useWhile } from '@/ui/use_while';
import { Mark, Verdict } from '@/ui/verdict';
import { ViewTitle } from '@/ui/view_title';
import { improvementWords } from './list';
import { withCauses } from './causes';
import { sentenceCase, turnLines } from './words';

export function ImprovementPage({ id }: { id: bigint }) {
  const asked = useAsked(`improvement ${id}`, async (signal) => (await api.diagnosis().getImprovement({ improvementId: id }, { signal })).improvement!);
  const [step, setStep] = useState('');
  useEvents('improvement', (progress) => {
    if (progress.improvementId !== id) return;
    setStep(`turn ${progress.turn}: ${progress.step}`);
    asked.again();
  });
  useWhile(asked.value?.state === Improvement_State.RUNNING, asked);
  const cancel = useCommand(async () => {
    await api.diagnosis().cancelImprovement({ improvementId: id });
    asked.again();
  });
  const one = asked.value;
  return (
    <>
      <ViewTitle
        sub={one && <>{one.trajectoryName}{one.formula && <> · <code>{one.formula}</code></>} · begun {dateClock(ms(one.createTime))}{one.createdBy && ` by ${one.createdBy}`}</>}
        actions={one?.state === Improvement_State.RUNNING && <CommandButton busy={cancel.busy} onPress={() => cancel.send()}>Cancel</CommandButton>}
      >
        {`Improvement ${id}`}
      </ViewTitle>
      {cancel.failure && <Failed asked="Cancel" failure={cancel.failure} />}
      {asked.failure && <Failed asked={`Show improvement ${id}`} failure={asked.failure} again={asked.again} />}
      {one ? <Turns one={one} step={step} /> : !asked.failure && <Awaiting what={`improvement ${id}`} />}
    </>
  );
}

function Turns({ one, step }: { one: Improvement; step: string }) {
  const [kind, word] = improvementWords(one.state);
  const most = Math.max(...one.turns.flatMap((turn) => turn.gains.map((gain) => startOf(gain) || 0)), 1e-9);
  return (
    <>
      <Panel class="diagnosis-banner">
        <div>
          <p class="state"><Mark kind={kind} size={32} /> {word[0].toUpperCase() + word.slice(1)}</p>
          <p class="muted">{sentenceCase(withCauses(one.reason)) || withCauses(step ?? '') || 'waiting for the first turn'}</p>
        </div>
        <Summary turns={standing(one)} all={standing(one).length === one.turns.length} />
      </Panel>
      {one.turns.length === 0 && <Empty>No turn is complete yet.</Empty>}
      {one.turns.map((turn) => <Turn key={turn.number} turn={turn} most={most} undone={!standing(one).includes(turn)} />)}
    </>
  );
}

// Turns whose extension was not taken back in the end.
export function standing({ turns, reason }: Pick<Improvement, 'turns' | 'reason'>): ImprovementTurn[] {
  const undone = /diagnosis (\d+): it was undone/.exec(reason)?.[1];
  return turns.filter((turn) => undone === undefined || String(turn.diagnosisId) !== undone);
}

// A90 of a gain: on the fresh points by both models where they were measured, else as the diagnosis held it out.
const startOf = (gain: ImprovementTurn_Gain): number => (gain.measuredBefore ?? gain.before)?.a90 ?? NaN;
const reached = (gain: ImprovementTurn_Gain): number => (gain.measured ?? gain.predicted ?? gain.before)?.a90 ?? NaN;

function Summary({ turns, all }: { turns: readonly ImprovementTurn[]; all: boolean }) {
  const gains = turns.flatMap((turn) => turn.gains);
  const outputs = [...new Set(gains.map((gain) => gain.output))];
  if (outputs.length === 0) return null;
  return (
    <div class="diagnosis-figure">
      <p class="muted"><A90 />, {all ? 'first to last turn' : 'at first and of what stands'}</p>
      {outputs.map((output) => {
        const of = gains.filter((gain) => gain.output === output);
        return <p class="diagnosis-change nowrap" key={output}>{output} <span class="muted">{significant(startOf(of[0]))}</span> → <strong>{significant(reached(of[of.length - 1]))}</strong> {of[0].unit}</p>;
      })}
    </div>
  );
}

// What fresh points said of a turn.
function Worth({ gains, undone }: { gains: readonly ImprovementTurn_Gain[]; undone: boolean }) {
  const measured = gains.filter((gain) => gain.measured !== undefined && gain.measuredBefore !== undefined);
  if (measured.length === 0) return <Verdict kind="idle">no fresh points yet</Verdict>;
  const worse = measured.filter((gain) => gain.measured!.a90 >= gain.measuredBefore!.a90).map((gain) => gain.output);
  if (worse.length === 0) return <Verdict kind="good">better on fresh points</Verdict>;
  return <Verdict kind="warn">{undone && 'undone: '}not better on fresh points: {worse.join(', ')}</Verdict>;
}

function Turn({ turn, most, undone }: { turn: ImprovementTurn; most: number; undone: boolean }) {
  return (
    <Panel title={`Turn ${turn.number}`} actions={turn.gains.length > 0 && <Worth gains={turn.gains} undone={undone} />}>
      <ul class="diagnosis-list">{turnLines(turn.what).map((line) => <li key={line}>{line}</li>)}</ul>
      <p class="row muted">
        {turn.runIds.map((run) => <a key={String(run)} href={`/runs/${run}`}>run {String(run)}</a>)}
        {turn.modelId !== undefined && <a href={`/models/${turn.modelId}`}>model {String(turn.modelId)}</a>}
        {turn.diagnosisId !== undefined && <a href={`/diagnosis/${turn.diagnosisId}`}>diagnosis {String(turn.diagnosisId)}</a>}
        <span>{ms(turn.endTime) === ms(turn.startTime) ? `since ${dateClock(ms(turn.startTime))}` : `${dateClock(ms(turn.startTime))} to ${dateClock(ms(turn.endTime))}`}</span>
      </p>
      {turn.gains.length > 0 && (
        <div class="table-scroll diagnosis-turn" tabIndex={0} role="region" aria-label={`Gains of turn ${turn.number}`}>
          <table>
            <thead><tr><th scope="col">output</th><th scope="col">A90 before</th><td /><th scope="col">measured on fresh points</th><td /><th scope="col" class="number">mean</th><th scope="col" class="number">held out, promised</th></tr></thead>
            <tbody>
              {turn.gains.map((gain) => (
                <tr key={gain.output}>
                  <td>{gain.output}</td>
                  <td><Bar share={startOf(gain) / most} colour="idle" /></td>
                  <td class="number">{significant(startOf(gain))} {gain.unit}</td>
                  <td>{gain.measured && <Bar share={gain.measured.a90 / most} />}</td>
                  <td class="number">{gain.measured ? `${significant(gain.measured.a90)} ${gain.unit}` : '–'}</td>
                  <td class="number">{gain.measured ? `${meanFigure(gain.measured.mean, gain.measured.a90)} ${gain.unit}` : '–'}</td>
                  <td class="number">{gain.predicted ? `${significant(gain.before?.a90)} → ${significant(gain.predicted.a90)} ${gain.unit}` : '–'}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
    </Panel>
  );
}
