// What the discrepancy goes with, what is left over, and what these data could not say.
import type { Diagnosis, OutputDiscrepancy } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { probability } from '@/format/numbers';
import { Bar } from '@/ui/bar';
import { Panel } from '@/ui/panel';
import { causeText } from './causes';

const shown = 12;

export function GoesWith({ output }: { output: OutputDiscrepancy }) {
  const shares = [...output.explainedBy].sort((a, b) => b.marginalShare - a.marginalShare).slice(0, shown);
  return (
    <Panel title={`What the discrepancy goes with, ${output.output}`}>
      <p class="note muted">Share of its variance that goes with each variable taken alone; shares overlap.</p>
      {shares.length === 0 ? <p class="muted">With nothing that was recorded.</p> : (
        <dl class="diagnosis-shares">
          {shares.map((one) => (
            <div key={one.variable}>
              <dt>{one.variable}</dt>
              <dd><Bar share={one.marginalShare} /><span>{Math.round(100 * one.marginalShare)} %</span></dd>
            </div>
          ))}
        </dl>
      )}
    </Panel>
  );
}

export function LeftOverPanel({ diagnosis }: { diagnosis: Diagnosis }) {
  if (diagnosis.leftOver.length === 0) return null;
  return (
    <Panel title="Left over">
      <p>Structure remains beyond noise that no cause of the catalogue explains. It goes with:</p>
      <ul class="diagnosis-list">{diagnosis.leftOver.map((one) => <li key={one.goesWith}>{one.goesWith} <span class="muted">(adjusted p {probability(one.pAdjusted)})</span></li>)}</ul>
    </Panel>
  );
}

export function NotTestablePanel({ diagnosis }: { diagnosis: Diagnosis }) {
  if (diagnosis.notTestable.length === 0) return null;
  return (
    <Panel title="What these data could not say">
      <dl class="facts">{diagnosis.notTestable.map((one) => [<dt title={one.cause}>{causeText(one.cause)}</dt>, <dd>{one.why}</dd>])}</dl>
    </Panel>
  );
}
