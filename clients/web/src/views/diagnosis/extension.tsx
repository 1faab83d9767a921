// Making something of findings, and taking it back.
import type { Diagnosis, Finding } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { api } from '@/api/client';
import { dateClock, ms } from '@/format/time';
import { CommandButton } from '@/ui/button';
import { confirm } from '@/ui/confirm';
import { Panel } from '@/ui/panel';
import { Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';
import { Verdict } from '@/ui/verdict';
import { appliesWords } from './words';

const standing = (diagnosis: Diagnosis) => diagnosis.extension && !diagnosis.extension.undoTime;

export function Accept({ diagnosis, findings, again, plain }: { diagnosis: Diagnosis; findings: readonly Finding[]; again: () => void; plain?: boolean }) {
  const accept = useCommand(async () => {
    await api.diagnosis().acceptExtension({ diagnosisId: diagnosis.id, findingNumbers: findings.map((one) => one.number), promote: false });
    again();
  });
  const robot = findings.some((one) => one.appliesTo === 'robot');
  const verb = robot ? 'Accept as a model' : findings[0].appliesTo === 'correction' ? 'Accept as a correction' : 'Keep these rows out';
  const ask = async () => {
    const yes = await confirm({
      title: `${verb}?`,
      facts: [
        ['finding', findings.map((one) => one.sentence).join(' ')],
        ['what it does', [...new Set(findings.map((one) => appliesWords[one.appliesTo] ?? one.appliesTo))].join('; ')],
        ['who is affected', robot ? 'nobody yet: the model is made, and serves when it is promoted' : findings[0].appliesTo === 'correction' ? 'every reading of that instrument from now on' : 'fits from now on'],
        ['to undo', 'Undo on this page'],
      ],
      verb,
      keep: 'Leave it as it is',
    });
    if (yes) await accept.send();
  };
  return (
    <>
      <CommandButton kind={plain ? 'plain' : 'main'} busy={accept.busy} off={standing(diagnosis) ? 'Something of this diagnosis was accepted already: undo that first' : undefined} onPress={ask}>{verb}…</CommandButton>
      {accept.failure && <Failed asked={verb} failure={accept.failure} />}
    </>
  );
}

export function ExtensionPanel({ diagnosis, again }: { diagnosis: Diagnosis; again: () => void }) {
  const undo = useCommand(async () => {
    await api.diagnosis().undoExtension({ diagnosisId: diagnosis.id });
    again();
  });
  const made = diagnosis.extension;
  const ask = async () => {
    const yes = await confirm({
      title: 'Take the extension back?',
      facts: [['from then on', 'the model before serves again, the correction ends, the rows are put back']],
      verb: 'Undo', keep: 'Keep it', bad: true,
    });
    if (yes) await undo.send();
  };
  if (!made) return diagnosis.findings.length > 1 ? <div class="actions"><Accept diagnosis={diagnosis} findings={diagnosis.findings} again={again} /><span class="muted">{diagnosis.findings.length === 2 ? 'both' : `all ${diagnosis.findings.length}`} findings at once</span></div> : null;
  return (
    <Panel title="What was made of it" actions={!made.undoTime && <CommandButton busy={undo.busy} onPress={ask}>Undo…</CommandButton>}>
      <p class="row">
        {made.undoTime ? <Verdict kind="idle">taken back {dateClock(ms(made.undoTime))}</Verdict> : <Verdict kind="good">accepted</Verdict>}
        <span>
          findings {made.findingNumbers.join(', ')}
          {made.modelId !== undefined && <>: <a href={`/models/${made.modelId}`}>model {String(made.modelId)}</a>{made.promoted ? ', serves' : ', not promoted yet'}</>}
          {made.correctionId !== undefined && `; correction ${made.correctionId}`}
          {made.excluded.length > 0 && `; rows kept out of ${made.excluded.map((one) => `run ${one.runId}: ${one.firstRow} to ${one.lastRow}`).join(', ')}`}
          {` · ${dateClock(ms(made.acceptTime))} by ${made.acceptedBy || 'the daemon'}`}
        </span>
      </p>
      {undo.failure && <Failed asked="Undo" failure={undo.failure} />}
    </Panel>
  );
}
