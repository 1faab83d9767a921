// Pose of the end-effector now, by the model run forward from the motors' scales, beside what an instrument reads of it.
import { failureOf } from '@/api/errors';
import { targetApi } from '@/api/target';
import type { EstimatedCoordinate } from '@/api/gen/driftwise/v1/target_service_pb';
import { fixed, grouped, signed } from '@/format/numbers';
import { splitChannel } from '@/format/units';
import { Panel } from '@/ui/panel';
import { Awaiting, Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { useAsked } from '@/ui/use_asked';
import { useWhile } from '@/ui/use_while';
import { Verdict } from '@/ui/verdict';
import type { Pose } from './pose';
import type { ComputedBy } from './use_target';

// pose: as it was typed. Its force is taken where no device of the cell reads one, and nobody stated one.
export function Where({ pose, by }: { pose: Pose; by: ComputedBy }) {
  const force = pose.find((one) => one.channel === 'force_N');
  const asked = useAsked(`pose ${by.modelId} ${by.datum}`, (signal) => estimate(force, signal));
  useWhile(true, asked);
  return (
    <Panel title="Where the end-effector is now">
      {asked.value?.force && <p class="muted">at the force above, {String(asked.value.force.value)} N: the cell reads none</p>}
      {asked.failure && <Failed asked="Run the model forward" failure={asked.failure} />}
      {asked.value ? <PoseTable coordinates={asked.value.answer.coordinates} /> : !asked.failure && <Awaiting what="the motors' positions" />}
    </Panel>
  );
}

async function estimate(force: Pose[number] | undefined, signal: AbortSignal) {
  try {
    return { answer: await targetApi().estimatePose({}, { signal }) };
  } catch (error) {
    if (!force || failureOf(error).reason !== 'MISSING_VALUE') throw error;
    return { answer: await targetApi().estimatePose({ stated: [force] }, { signal }), force };
  }
}

const isLength = (one: EstimatedCoordinate) => splitChannel(one.channel).unit === 'mm';
const placeText = (one: EstimatedCoordinate, v: number) => (isLength(one) ? `${grouped(v, 7)} mm` : `${fixed(v, 3)} ${splitChannel(one.channel).unit}`);
const distanceText = (one: EstimatedCoordinate, v: number, digits: typeof fixed) => (isLength(one) ? `${digits(v * 1e6, 1)} nm` : `${digits(v, 3)} ${splitChannel(one.channel).unit}`);

function PoseTable({ coordinates }: { coordinates: readonly EstimatedCoordinate[] }) {
  return (
    <Table
      caption="Pose by the model and by the instruments"
      rows={coordinates}
      keyOf={(one) => one.channel}
      columns={[
        { title: 'pose', of: (one) => splitChannel(one.channel).symbol },
        { title: 'simulated', number: true, of: (one) => placeText(one, one.value) },
        { title: 'U (k = 2)', number: true, of: (one) => (Number.isFinite(one.u) ? distanceText(one, 2 * one.u, fixed) : '–') },
        { title: 'measured', number: true, of: (one) => (one.measured === undefined ? '–' : placeText(one, one.measured)) },
        { title: 'discrepancy', number: true, of: (one) => (one.discrepancy === undefined ? '–' : distanceText(one, one.discrepancy, signed)) },
        { title: 'verdict', of: (one) => one.measured !== undefined && Number.isFinite(one.u) && <Verdict kind={one.agrees ? 'good' : 'warn'}>{one.agrees ? 'within U' : 'beyond U'}</Verdict> },
      ]}
    />
  );
}
