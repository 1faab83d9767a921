// One kept trajectory.
import { useState } from 'preact/hooks';
import { trajectoryApi } from '@/api/trajectory';
import type { Trajectory } from '@/api/gen/driftwise/v1/trajectory_service_pb';
import { countRows } from '@/format/numbers';
import { dateClock, ms } from '@/format/time';
import { cell } from '@/live/state';
import { Button } from '@/ui/button';
import { Field } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { download } from '@/ui/download';
import { Awaiting, Failed } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { useTyped } from '@/ui/use_typed';
import { ViewTitle } from '@/ui/view_title';
import { TrajectoryCheck, useTrajectoryCheck } from './check';
import { StartRun } from '@/trajectory/start_run';

export function TrajectoryPage({ id }: { id: bigint }) {
  const asked = useAsked(`trajectory ${id}`, async (signal) => (await trajectoryApi().getTrajectory({ trajectoryId: id }, { signal })).trajectory!);
  const one = asked.value;
  return (
    <>
      <ViewTitle
        sub={one && `${countRows(one.rowCount)}, kept ${dateClock(ms(one.createTime))}${one.createdBy && ` by ${one.createdBy}`}`}
        actions={one && <Button onPress={() => download(`${one.name.replace(/\.csv$/, '')}.csv`, one.text, 'text/csv')}>Save as CSV</Button>}
      >
        {one ? `Trajectory ${id}, ${one.name}` : `Trajectory ${id}`}
      </ViewTitle>
      {asked.failure && <Failed asked={`Show trajectory ${id}`} failure={asked.failure} again={asked.again} />}
      {one ? <Kept one={one} /> : !asked.failure && <Awaiting what={`trajectory ${id}`} />}
    </>
  );
}

function Kept({ one }: { one: Trajectory }) {
  const check = useTrajectoryCheck(one.text);
  const [runName, setRunName, nameTaken] = useTyped(`run.name.${one.id}`);
  const [compensate, setCompensate] = useState(false);
  const coordinates = check.value?.coordinates ?? [];
  const poses = coordinates.some((channel) => !/^(\w+\.)?q\d/.test(channel));
  const byPlan = coordinates.some((channel) => channel.includes('.')); // several robots
  const noModel = !byPlan && cell.value?.servingModelId === undefined;
  return (
    <>
      <Panel title="Run it">
        <div class="row trajectories-run">
          <Field label="name of the run" value={runName} onInput={setRunName} hint={`empty: ${one.name}`} />
          {poses && (
            <label class="trajectories-check">
              <input type="checkbox" checked={compensate} onChange={(event) => setCompensate(event.currentTarget.checked)} />
              <span>compensated: move to the targets of {byPlan ? 'the serving plan' : noModel ? 'the model that serves (none does now)' : `model ${cell.value?.servingModelId}`}</span>
            </label>
          )}
          <div class="actions">
            <StartRun
              text={one.text}
              name={one.name}
              runName={runName}
              onStarted={nameTaken}
              compensate={compensate}
              off={check.failure ? 'It cannot be run: see below' : compensate && noModel ? 'No model serves: promote one first' : undefined}
            />
          </div>
        </div>
      </Panel>
      <TrajectoryCheck text={one.text} name={one.name} asked={check} />
    </>
  );
}
