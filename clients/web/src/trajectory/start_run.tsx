// Starts a run of a trajectory: says first what it will do, then takes the lease for the start alone.
import { useState } from 'preact/hooks';
import { api } from '@/api/client';
import { withLease } from '@/app/lease';
import { go } from '@/app/router';
import { count, countRows } from '@/format/numbers';
import { duration, secondsOf } from '@/format/time';
import { progress } from '@/live/state';
import { CommandButton } from '@/ui/button';
import { confirm } from '@/ui/confirm';
import { Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';
import { SetupChoice, useSetups } from '@/parts/setup_choice';
import { useLimits } from './limits';
import { bandText, estimatedEnd } from './estimate';
import { forceText, trajectoryRows } from './parse';

const over = 5; // Run.State: DONE and what follows

export function StartRun({ text, name, runName, compensate, onStarted, verb = 'Start a run', off }: {
  text: string;
  name: string; // of the trajectory, for people
  runName?: string;
  compensate?: boolean; // move to the targets of the model that serves
  onStarted?: () => void; // the daemon has taken it
  verb?: string;
  off?: string | undefined;
}) {
  const limits = useLimits();
  const setups = useSetups();
  const [setup, setSetup] = useState('');
  const [requestId] = useState(() => crypto.randomUUID()); // a second press is the same run
  const start = useCommand(async () => {
    const { run } = await withLease((leaseToken) =>
      api.run().createRun({ name: runName || name, trajectoryName: name, trajectoryText: text, leaseToken, requestId, setup, compensate: compensate ?? false }));
    onStarted?.();
    go(`/runs/${run!.id}`);
  });
  const look = useCommand(async () => {
    const check = await api.run().checkTrajectory({ trajectoryText: text });
    const seconds = secondsOf(check.estimatedDuration) ?? 0;
    const forces = forceText(trajectoryRows(text));
    const byHand = limits.value?.actuator ? '' : '; by hand: the run waits for each';
    const yes = await confirm({
      title: `${verb}?`,
      facts: [
        ['trajectory', `${name}: ${count(check.rowCount)} points, ${count(check.lineCount)} lines`],
        ['it moves', check.coordinates.join(', ') + (compensate ? ', to the targets of the model that serves' : '')],
        ...(setup ? [['set-up', `${setup}: only its instruments are read`] as const] : []),
        ['soft limits', `${countRows(check.rowCount)} checked, all within`],
        ['takes about', `${duration(seconds)}${check.estimatedBand ? ` (${bandText(check.estimatedBand)})` : ''}${estimatedEnd(seconds) && `; ready ${estimatedEnd(seconds)}`}`],
        ['weights', forces === '' ? 'none' : forces + byHand],
        ...(check.warnings.length ? [['remarks', `${check.warnings.length}: see the page`] as const] : []),
      ],
      verb, keep: 'Do nothing',
    });
    if (yes) await start.send();
  });
  const other = progress.value?.run && progress.value.run.state < over ? `Run ${progress.value.run.id} is under way: one at a time` : undefined;
  return (
    <>
      <SetupChoice names={setups.value} value={setup} onChoose={setSetup} />
      <CommandButton kind="main" busy={start.busy || look.busy} off={off ?? other} onPress={() => look.send()}>{verb}…</CommandButton>
      {(off ?? other) && <span class="note muted" aria-hidden="true">{off ?? other}</span>}
      {look.failure && <Failed asked="Check the trajectory" failure={look.failure} />}
      {start.failure && <Failed asked={verb} failure={start.failure} />}
    </>
  );
}
