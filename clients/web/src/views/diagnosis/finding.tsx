// One cause: the sentence, where it acts and how sure that is, its parameters, the gain, and on demand the one plot that
// shows it.
import { useMemo, useState } from 'preact/hooks';
import type { Diagnosis, DiscrepancyRows, Finding, OutputDiscrepancy } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { probability, significant } from '@/format/numbers';
import { Plot } from '@/plot/plot';
import { Button } from '@/ui/button';
import { figure, meanFigure } from '@/ui/accuracy';
import { A90 } from '@/ui/explained';
import { Panel } from '@/ui/panel';
import { causeText } from './causes';
import { Accept } from './extension';
import { Parameters } from './parameter_table';
import { axisOf, discrepancySpec, likelihoodSpec } from './specs';
import { appliesWords, headline } from './words';

export function FindingPanel({ finding, diagnosis, output, rows, again }: {
  finding: Finding;
  diagnosis: Diagnosis;
  output: OutputDiscrepancy;
  rows: DiscrepancyRows | undefined;
  again: () => void;
}) {
  const [evidence, setEvidence] = useState(false);
  const shown = finding.outputs.find((one) => one.output === output.output && one.shown) ?? finding.outputs.find((one) => one.shown) ?? finding.outputs[0];
  return (
    <Panel class="diagnosis-finding">
      <div class="diagnosis-finding-head">
        <div class="stack">
          <h2 class="finding" title={finding.sentence}>{finding.number}. {headline(finding.sentence)}</h2>
          <p>
            Where: {finding.where}{finding.subject && `, ${finding.subject}`} · cause <code>{finding.cause}</code> · {appliesWords[finding.appliesTo] ?? finding.appliesTo}
          </p>
          {finding.indistinguishableFrom.length > 0 && (
            <p class="diagnosis-ambiguous">These data do not tell it from {finding.indistinguishableFrom.map((cause) => causeText(cause)).join(', ')}.</p>
          )}
          <Parameters finding={finding} />
        </div>
        <div class="diagnosis-side">
          {shown && shown.a90Before !== undefined && (
            <>
              <p class="muted"><A90 /> held out, {shown.output}: without it → with it</p>
              <p class="diagnosis-change nowrap"><span class="muted">{significant(shown.a90Before)}</span> → <strong>{significant(shown.a90After)}</strong> {shown.unit}</p>
              <p class="note muted">mean {meanFigure(shown.meanBefore, shown.a90Before)} → {meanFigure(shown.meanAfter, shown.a90After)}, S90 {figure(shown.u90Before)} → {figure(shown.u90After)} {shown.unit}</p>
              {shown.a90AfterCi90 && <p class="note muted">90 % interval of A90: {significant(shown.a90AfterCi90.low)} to {significant(shown.a90AfterCi90.high)} {shown.unit}</p>}
            </>
          )}
          <p class="note muted">adjusted p {probability(finding.pAdjusted)}; 2 ln L {significant(2 * finding.logLikelihoodRatio, 3)}</p>
          <div class="actions">
            <Accept diagnosis={diagnosis} findings={[finding]} again={again} plain={diagnosis.findings.length > 1} />
            {rows && <Button onPress={() => setEvidence(!evidence)}>{evidence ? 'Hide evidence' : 'Evidence'}</Button>}
          </div>
        </div>
      </div>
      {evidence && rows && <Evidence finding={finding} output={output} rows={rows} />}
    </Panel>
  );
}

function Evidence({ finding, output, rows }: { finding: Finding; output: OutputDiscrepancy; rows: DiscrepancyRows }) {
  const specs = useMemo(() => {
    const of = { ...output };
    const against = rows.variables.some((one) => one.symbol === finding.subject) ? finding.subject : 'time';
    const colour = finding.cause === 'backlash' ? 'direction' : 'set';
    return [
      discrepancySpec(rows, of, axisOf(rows, against), colour, 'before', `The discrepancy against ${against}`),
      ...finding.parameters.filter((one) => one.curveValue.length > 1).map((one) => likelihoodSpec(one, finding.cause)),
    ];
  }, [finding, output, rows]);
  return <div class="columns">{specs.map((spec) => <Plot key={spec.title} spec={spec} height={200} />)}</div>;
}
