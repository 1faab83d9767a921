// Axes live within their limits, with hold-to-move, step size and home.
import { useEffect, useRef, useState } from 'preact/hooks';
import { api } from '@/api/client';
import { failureOf, type Failure } from '@/api/errors';
import type { Axis } from '@/api/gen/driftwise/v1/cell_service_pb';
import type { Jog } from '@/api/gen/driftwise/v1/commissioning_service_pb';
import { Run_State } from '@/api/gen/driftwise/v1/run_pb';
import { withLease } from '@/app/lease';
import { named } from '@/app/name';
import { fixed } from '@/format/numbers';
import { channel, type Channel } from '@/live/channels';
import { connection } from '@/live/connection';
import { cell, cellTimeMs, progress } from '@/live/state';
import { askAboutHold, type HoldAnswer } from '@/parts/hold_question';
import { CommandButton } from '@/ui/button';
import { confirm } from '@/ui/confirm';
import { Panel } from '@/ui/panel';
import { Empty, Failed } from '@/ui/states';
import { StaleNote } from '@/ui/tile';
import { useCommand } from '@/ui/use_command';
import { answerWithin_ms, HeldJog } from './held_jog';
import { JogButton } from './jog_button';

const stepsMm = [0.0001, 0.001, 0.01, 0.1, 1];
const stepText = (mm: number) => (mm < 0.001 ? `${mm * 1e6} nm` : mm < 1 ? `${mm * 1e3} µm` : `${mm} mm`);

// A limit as the cell file has it: no digits made up.
const limit = (mm: number) => fixed(mm, Math.min(6, (String(mm).split('.')[1] ?? '').length));

const standing = () => {
  const run = progress.value?.run;
  return run?.state === Run_State.PAUSED || run?.state === Run_State.WAITING ? run : undefined;
};
const offWhy = (): string | undefined => {
  const run = progress.value?.run;
  return run && (run.state === Run_State.RUNNING || run.state === Run_State.QUEUED) ? `Run ${run.id} is under way: pause it first` : undefined;
};

export function Axes() {
  const axes = cell.value?.devices.flatMap((device) => device.axes) ?? [];
  const [stepMm, setStepMm] = useState(0.001);
  const [state, setState] = useState<Jog>();
  const [late, setLate] = useState<Jog>(); // the answer that none has followed in time
  const [blocked, setBlocked] = useState<string>(); // why a press moved nothing
  const [failure, setFailure] = useState<Failure>();
  const [agreed, setAgreed] = useState<{ run: bigint; hold: bigint; answer: HoldAnswer }>();
  const held = useRef<HeldJog | undefined>(undefined);
  const home = useCommand(async () => {
    const run = standing();
    const answer = run ? await askAboutHold(run, cellTimeMs.value, 'Reference the axes') : undefined;
    if (run && !answer) return;
    if (!run && !(await confirm({ title: 'Reference all axes?', words: 'They move to their reference marks; a new datum follows.', verb: 'Home', keep: 'Leave them' }))) return;
    await withLease((leaseToken) => api.cell().home({ leaseToken, ...(answer && { answer }) }));
  });
  const run = standing();
  const answer = run && agreed && agreed.run === run.id && agreed.hold === run.hold?.id ? agreed.answer : undefined;
  const needsAnswer = run !== undefined && answer === undefined;
  const agree = async () => {
    const given = run && (await askAboutHold(run, cellTimeMs.value, 'Jog the axes'));
    if (run && given) setAgreed({ run: run.id, hold: run.hold?.id ?? 0n, answer: given });
  };
  const press = async (axis: Axis, direction: 1 | -1) => {
    if (held.current) return setBlocked(held.current.released ? 'The last movement has not been answered yet' : 'Another button is held');
    const jog = new HeldJog(setState);
    held.current = jog;
    setFailure(undefined);
    try {
      if (await named()) await jog.run({ channel: axis.channel, stepMm: direction * stepMm, answer });
    } catch (error) {
      setFailure(failureOf(error));
    } finally {
      held.current = undefined;
      setBlocked(undefined);
      setState((last) => (last?.over ? last : undefined)); // an answer was lost: where the axis is, only its channel knows now
    }
  };
  useEffect(() => {
    if (!state || state.over) return undefined;
    const timer = setTimeout(() => setLate(state), answerWithin_ms);
    return () => clearTimeout(timer);
  }, [state]);
  // Of the movement under way, which is read more often than the channel, or the channel's; stale: not known to be the present one.
  const position = (name: string): { mm: number; stale: boolean; live?: Channel } => {
    if (held.current && state?.over === false) return { mm: state.positions.find((one) => one.channel === name)?.positionMm ?? NaN, stale: late === state || connection.value.phase !== 'live' };
    const live = channel(name);
    return { mm: live?.value.value ?? NaN, stale: live?.stale.value ?? true, ...(live && { live }) };
  };
  const off = offWhy() ?? (needsAnswer ? 'A run stands: say first that the axes may move' : undefined);
  return (
    <Panel title="Axes" actions={<CommandButton busy={home.busy} off={offWhy()} onPress={() => void home.send()}>Home…</CommandButton>}>
      {axes.length === 0 && <Empty>This cell has no axes.</Empty>}
      {needsAnswer && <CommandButton onPress={() => void agree()}>Run {String(run.id)} stands: may the axes move?…</CommandButton>}
      {off && <p class="note" role="status">{off}</p>}
      <label class="field jog-step">
        <span>Step</span>
        <select class="input" value={String(stepMm)} onChange={(event) => setStepMm(Number(event.currentTarget.value))}>
          {stepsMm.map((mm) => <option key={mm} value={String(mm)}>{stepText(mm)}</option>)}
        </select>
      </label>
      {axes.map((axis) => {
        const { mm: at, stale, live } = position(axis.channel);
        return (
          <div class="jog-axis" key={axis.channel}>
            <b>{axis.channel.replace(/_mm$/, '')}</b>
            <span class={`number${stale ? ' stale muted' : ''}`} title={stale ? 'stale: not the position of now' : undefined}>{fixed(at, 6)} mm</span>
            {stale && live && <StaleNote channel={live} />}
            <meter min={axis.minMm} max={axis.maxMm} value={Number.isFinite(at) ? at : axis.minMm} aria-label={`${axis.channel} between ${axis.minMm} and ${axis.maxMm} mm`} />
            <span class="muted nowrap">{limit(axis.minMm)} to {limit(axis.maxMm)} mm</span>
            <JogButton label={`Hold to move ${axis.channel} down, − ${stepText(stepMm)}`} text={`− ${stepText(stepMm)}`} off={off} press={() => void press(axis, -1)} release={() => held.current?.release()} />
            <JogButton label={`Hold to move ${axis.channel} up, + ${stepText(stepMm)}`} text={`+ ${stepText(stepMm)}`} off={off} press={() => void press(axis, 1)} release={() => held.current?.release()} />
          </div>
        );
      })}
      {blocked && <p class="note" role="status">{blocked}.</p>}
      {state?.over && <p class="muted" role="status">{String(state.stepCount)} steps: {state.endReason}</p>}
      {failure && <Failed asked="Move the axis" failure={failure} />}
      {home.failure && <Failed asked="Home" failure={home.failure} />}
    </Panel>
  );
}
