import { useState } from 'preact/hooks';
import { api } from '@/api/client';
import { trajectoryApi } from '@/api/trajectory';
import { withLease } from '@/app/lease';
import { go } from '@/app/router';
import { countRows } from '@/format/numbers';
import { cell } from '@/live/state';
import { SetupChoice, useSetups } from '@/parts/setup_choice';
import { CommandButton } from '@/ui/button';
import { confirm } from '@/ui/confirm';
import { Field, numberTyped } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { Failed } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { useTyped } from '@/ui/use_typed';

// Measure, fit, diagnose, extend, measure fresh points, again: until nothing beyond noise is left, or the turns or hours
// are used up.
export function ImproveForm() {
  const trajectories = useAsked('trajectories', async (signal) => (await trajectoryApi().listTrajectories({}, { signal })).trajectories);
  const [chosen, setChosen] = useState('');
  const [formula, setFormula, formulaTaken] = useTyped('improve.formula');
  const [turns, setTurns] = useTyped('improve.turns', '5');
  const [hours, setHours] = useTyped('improve.hours', '24');
  const setups = useSetups();
  const [setup, setSetup] = useState('');
  const [serve, setServe] = useState(false);
  const id = chosen || (trajectories.value?.[0] ? String(trajectories.value[0].id) : '');
  const [most, budget] = [numberTyped(turns), numberTyped(hours)];
  const start = useCommand(async () => {
    const { trajectory } = await trajectoryApi().getTrajectory({ trajectoryId: BigInt(id) });
    const { improvement } = await withLease((leaseToken) =>
      api.diagnosis().createImprovement({
        leaseToken, trajectoryName: trajectory!.name, trajectoryText: trajectory!.text, formula, maxTurns: most ?? 0, budgetS: (budget ?? 0) * 3600,
        promote: serve, setup, requestId: crypto.randomUUID(),
      }), true);
    formulaTaken();
    go(`/diagnosis/improve/${improvement!.id}`);
  });
  const off = id === '' ? 'Upload or generate a trajectory first'
    : formula.trim() === '' && cell.value?.servingModelId === undefined ? 'No model serves: type the formula of the first one'
    : most === undefined || most < 1 ? 'A number of turns from 1 is expected' : budget === undefined ? 'A number of hours is expected' : undefined;
  const ask = async () => {
    const name = trajectories.value?.find((one) => String(one.id) === id)?.name ?? '';
    const yes = await confirm({
      title: 'Start the improvement?',
      facts: [
        ['it moves', `the robot, over ${name}, once a turn and over fresh points between`],
        ['at most', `${turns} turns, ${hours} h (time of the cell)`],
        ['who is affected', serve ? 'every controller that asks for targets: a model whose gain fresh points have shown is promoted by itself. Corrections that it accepts change the data of earlier runs too' : 'no target: models are only proposed. Corrections that it accepts change the data of earlier runs too, until they are undone'],
        ['to end it', 'Cancel; Stop motion only halts it where it is'],
      ],
      verb: 'Start the improvement', keep: 'Do nothing',
    });
    if (yes) await start.send();
  };
  return (
    <Panel title="Improve in a loop">
      <p class="muted">Measures, fits, diagnoses, extends what it found, and measures fresh points to see what that was worth; until nothing beyond noise is left.</p>
      <div class="row diagnosis-start">
        <label class="field"><span>trajectory of every turn</span>
          <select value={id} onChange={(event) => setChosen(event.currentTarget.value)}>
            {trajectories.value?.map((one) => <option key={String(one.id)} value={String(one.id)}>{one.name}, {countRows(one.rowCount)}</option>)}
            {!trajectories.value?.length && <option value="">none yet</option>}
          </select>
        </label>
        <Field label="formula of the first model" value={formula} onInput={setFormula} mono hint={cell.value?.servingModelId !== undefined ? `empty: model ${cell.value.servingModelId}, which serves` : undefined} />
        <Field label="turns, at most" type="number" value={turns} onInput={setTurns} />
        <Field label="time of the cell, at most" unit="h" type="number" value={hours} onInput={setHours} hint="0: no limit" />
        <SetupChoice names={setups.value} value={setup} onChoose={setSetup} />
        <label class="diagnosis-check"><input type="checkbox" checked={serve} onChange={(event) => setServe(event.currentTarget.checked)} /> promote what fresh points have confirmed</label>
      </div>
      <div class="actions"><CommandButton busy={start.busy} off={off} onPress={ask}>Start the improvement…</CommandButton></div>
      {start.failure && <Failed asked="Start the improvement" failure={start.failure} />}
    </Panel>
  );
}
