// Corrections that data rest on: of a run, or of the runs that a model was fitted from.
import type { CorrectionMark } from '@/api/gen/driftwise/v1/provenance_pb';
import { countRows, significant } from '@/format/numbers';
import { dateClock, ms } from '@/format/time';
import { splitChannel } from '@/format/units';
import { Verdict } from '@/ui/verdict';

export function Rests({ marks, what }: { marks: readonly CorrectionMark[]; what: string }) {
  if (marks.length === 0) return null;
  return (
    <ul class="plain-list">
      {marks.map((mark) => (
        <li key={String(mark.correctionId)} class="row">
          {mark.endTime
            ? <Verdict kind="bad">rests on a correction that was taken back</Verdict>
            : <Verdict kind="warn">rests on a correction</Verdict>}
          <span>
            {what} correction {String(mark.correctionId)}
            {mark.diagnosisId !== undefined && <> of <a href={`/diagnosis/${mark.diagnosisId}`}>diagnosis {String(mark.diagnosisId)}</a></>}
            {`, accepted ${dateClock(ms(mark.acceptTime))} by ${mark.acceptedBy || 'the daemon'}`}
            {mark.endTime && `, taken back ${dateClock(ms(mark.endTime))} by ${mark.endedBy || 'the daemon'}`}
            {mark.changes.map((change) => `; ${splitChannel(change.channel).symbol} of run ${change.runId} by up to ${significant(change.largestNm, 3)} nm in ${countRows(change.rowCount)}`)}
          </span>
        </li>
      ))}
    </ul>
  );
}
