// Pose of the end-effector now, by the model run forward from the motors' scales, beside what an instrument reads of it.
import { targetApi } from '@/api/target';
import type { EstimatedCoordinate } from '@/api/gen/driftwise/v1/target_service_pb';
import { fixed, grouped, signed } from '@/format/numbers';
import { splitChannel } from '@/format/units';
import { Panel } from '@/ui/panel';
import { Awaiting, Failed } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { useWhile } from '@/ui/use_while';
import { Verdict } from '@/ui/verdict';

export function Where() {
  const asked = useAsked('pose', (signal) => targetApi().estimatePose({}, { signal }));
  useWhile(true, asked.again);
  return (
    <Panel title="Where the end-effector is now">
      {asked.failure && <Failed asked="Run the model forward" failure={asked.failure} />}
      {asked.value ? <PoseTable coordinates={asked.value.coordinates} /> : !asked.failure && <Awaiting what="the motors' positions" />}
    </Panel>
  );
}

function PoseTable({ coordinates }: { coordinates: readonly EstimatedCoordinate[] }) {
  return (
    <div class="table-scroll" tabIndex={0} role="region" aria-label="Pose by the model and by the instruments">
      <table>
        <thead>
          <tr><th scope="col">pose</th><th scope="col" class="number">simulated</th><th scope="col" class="number">U (k = 2)</th><th scope="col" class="number">measured</th><th scope="col" class="number">discrepancy</th><th scope="col" /></tr>
        </thead>
        <tbody>{coordinates.map((one) => <PoseRow key={one.channel} one={one} />)}</tbody>
      </table>
    </div>
  );
}

function PoseRow({ one }: { one: EstimatedCoordinate }) {
  const { symbol, unit } = splitChannel(one.channel);
  const length = unit === 'mm';
  const value = (v: number) => (length ? `${grouped(v, 7)} mm` : `${fixed(v, 3)} ${unit}`);
  const small = (v: number) => (length ? `${fixed(v * 1e6, 1)} nm` : `${fixed(v, 3)} ${unit}`);
  return (
    <tr>
      <td>{symbol}</td>
      <td class="number nowrap">{value(one.value)}</td>
      <td class="number nowrap">{small(2 * one.u)}</td>
      <td class="number nowrap">{one.measured === undefined ? '-' : value(one.measured)}</td>
      <td class="number nowrap">{one.discrepancy === undefined ? '-' : length ? `${signed(one.discrepancy * 1e6, 1)} nm` : `${signed(one.discrepancy, 3)} ${unit}`}</td>
      <td>{one.measured !== undefined && <Verdict kind={one.agrees ? 'good' : 'warn'}>{one.agrees ? 'within U' : 'beyond U'}</Verdict>}</td>
    </tr>
  );
}
