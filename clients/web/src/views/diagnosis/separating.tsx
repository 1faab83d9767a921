// Where the data leave two causes standing: what would tell them apart, and what that costs.
import type { Diagnosis, SeparatingExperiment } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { duration } from '@/format/time';
import { Button } from '@/ui/button';
import { Panel } from '@/ui/panel';
import { StartRun } from '@/trajectory/start_run';
import { download } from '@/ui/download';

export function SeparatingPanel({ experiment, diagnosis }: { experiment: SeparatingExperiment; diagnosis: Diagnosis }) {
  const rows = experiment.trajectoryText.split('\n').filter((line) => line !== '' && !line.startsWith('#')).length - 1;
  const name = `separating-diagnosis-${diagnosis.id}`;
  if (!experiment.trajectoryText) return <Panel title="No separating experiment"><p>{experiment.why}</p></Panel>;
  return (
    <Panel
      title="What would tell them apart"
      actions={
        <>
          <Button onPress={() => download(`${name}.csv`, experiment.trajectoryText, 'text/csv')}>Save the trajectory</Button>
          <StartRun text={experiment.trajectoryText} name={name} verb="Start the separating run" />
        </>
      }
    >
      <p>{experiment.why}</p>
      <p class="muted">
        {rows} points, {duration(experiment.estimatedS)}
        {experiment.predictedPower !== undefined && `; it names the right one with probability ${experiment.predictedPower.toFixed(2)}`}
      </p>
    </Panel>
  );
}
