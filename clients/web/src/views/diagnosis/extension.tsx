// Making something of findings, and taking it back.
import { useRef } from 'preact/hooks';
import type { Diagnosis, Finding, PreviewExtensionResponse } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { api } from '@/api/client';
import { countRows, rowSpan, significant } from '@/format/numbers';
import { dateClock, ms } from '@/format/time';
import { splitChannel } from '@/format/units';
import { CommandButton } from '@/ui/button';
import { confirm } from '@/ui/confirm';
import { Panel } from '@/ui/panel';
import { Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';
import { Verdict } from '@/ui/verdict';
import { appliesWords } from './words';

const standing = (diagnosis: Diagnosis) => diagnosis.extension && !diagnosis.extension.undoTime;

// "run 3 (weekend): x by up to 3220 nm, rms 812 nm, 200 rows, from 12 Nov 08:12"
export function changeText(change: PreviewExtensionResponse['changes'][number]): string {
  const from = change.fromTime ? `, from ${dateClock(ms(change.fromTime))}` : '';
  return `run ${change.runId}${change.runName && ` (${change.runName})`}: ${splitChannel(change.channel).symbol} by up to ${significant(change.largestNm, 3)} nm, rms ${significant(change.rmsNm, 3)} nm, ${countRows(change.rowCount)}${from}`;
}

function Changes({ preview }: { preview: PreviewExtensionResponse }) {
  const most = 8;
  const rows = preview.excluded.map((one) => `run ${one.runId}: ${rowSpan(one.firstRow, one.lastRow)} kept out of fits`);
  const lines = [...preview.changes.slice(0, most).map(changeText), ...(preview.changes.length > most ? [`... and ${preview.changes.length - most} more`] : []), ...rows, ...preview.further];
  return lines.length === 0 ? <>no data: a model is fitted, <code>{preview.formula}</code></> : <ul class="plain-list">{lines.map((line) => <li>{line}</li>)}</ul>;
}

export function affected(preview: PreviewExtensionResponse): string {
  const who = [];
  if (preview.earlierRuns) who.push('earlier runs too: every export, fit and check of the runs above sees the corrected lengths from now on');
  else if (preview.changes.length > 0) who.push('every export, fit and check of these runs');
  if (preview.laterRuns) who.push('every run that is measured later');
  if (preview.excluded.length > 0 || preview.further.length > 0) who.push('fits from now on');
  who.push('targets: nobody yet; the model that is made serves when it is promoted');
  return who.join('; ');
}

export function Accept({ diagnosis, findings, again, plain }: { diagnosis: Diagnosis; findings: readonly Finding[]; again: () => void; plain?: boolean }) {
  const accept = useCommand(async () => {
    await api.diagnosis().acceptExtension({ diagnosisId: diagnosis.id, findingNumbers: findings.map((one) => one.number), promote: false });
    again();
  });
  const robot = findings.some((one) => one.appliesTo === 'robot');
  const verb = robot ? 'Accept as a model' : findings[0].appliesTo === 'correction' ? 'Accept as a correction' : 'Keep these rows out';
  // What it would change is worked out first, by the daemon: never a question without sizes.
  const seen = useRef<PreviewExtensionResponse | undefined>(undefined);
  const look = useCommand(async () => {
    seen.current = await api.diagnosis().previewExtension({ diagnosisId: diagnosis.id, findingNumbers: findings.map((one) => one.number) });
  }, 'reads');
  const ask = async () => {
    if (!(await look.send()) || !seen.current) return;
    const preview = seen.current;
    const yes = await confirm({
      title: `${verb}?`,
      facts: [
        ['finding', findings.map((one) => one.sentence).join(' ')],
        ['what it does', [...new Set(findings.map((one) => appliesWords[one.appliesTo] ?? one.appliesTo))].join('; ')],
        ['what changes', <Changes preview={preview} />],
        ['who is affected', affected(preview)],
        ['to undo', 'Undo on this page'],
      ],
      verb,
      keep: 'Leave it as it is',
    });
    if (yes) await accept.send();
  };
  return (
    <>
      <CommandButton kind={plain ? 'plain' : 'main'} busy={accept.busy || look.busy} off={standing(diagnosis) ? 'Something of this diagnosis was accepted already: undo that first' : undefined} onPress={ask}>{verb}…</CommandButton>
      {look.failure && <Failed asked={verb} failure={look.failure} />}
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
      facts: [['from then on', 'the model before serves again, the correction ends, the rows are put back'], ['models', 'those that were fitted on corrected data stay, marked: a promotion of one of them asks first']],
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
          {made.excluded.length > 0 && `; kept out: ${made.excluded.map((one) => `${rowSpan(one.firstRow, one.lastRow)} of run ${one.runId}`).join(', ')}`}
          {` · ${dateClock(ms(made.acceptTime))} by ${made.acceptedBy || 'the daemon'}`}
        </span>
      </p>
      {undo.failure && <Failed asked="Undo" failure={undo.failure} />}
    </Panel>
  );
}
