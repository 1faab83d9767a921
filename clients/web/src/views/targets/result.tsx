import { useRef } from 'preact/hooks';
import { Target_Flag, type MotorCoordinate, type Target } from '@/api/gen/driftwise/v1/target_service_pb';
import { Code, ConnectError } from '@connectrpc/connect';
import { api } from '@/api/client';
import { targetApi } from '@/api/target';
import { withLease } from '@/app/lease';
import { fixed, grouped, signed, significant } from '@/format/numbers';
import { clock, ms } from '@/format/time';
import { splitChannel, unitSign } from '@/format/units';
import { cellTimeMs, progress } from '@/live/state';
import { flagInWords } from '@/parts/flag_words';
import { askAboutHold, type HoldAnswer } from '@/parts/hold_question';
import { Button, CommandButton } from '@/ui/button';
import { confirm } from '@/ui/confirm';
import { U90 } from '@/ui/explained';
import { Panel } from '@/ui/panel';
import { Awaiting, Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';
import { Verdict } from '@/ui/verdict';
import type { Pose } from './pose';
import type { TargetState } from './use_target';

export function Result({ state, pose }: { state: TargetState; pose: Pose }) {
  const { target, failure } = state;
  return (
    <Panel title="Motor coordinates" actions={target && <Actions target={target} pose={pose} />}>
      {failure && <Failed asked="Ask for the target" failure={failure} />}
      {target ? (
        <>
          <dl class="targets-result">{target.coordinates.map((one) => <Coordinate key={one.channel} one={one} />)}</dl>
          <p class="row"><Flags target={target} /></p>
          <p class="note muted">
            conditions of {clock(ms(target.conditionsTime))}, good until {clock(ms(target.validUntilTime))}
          </p>
        </>
      ) : !failure && <Awaiting what="the target" />}
    </Panel>
  );
}

// A joint of an arm is in its channel's unit.
const position = (one: MotorCoordinate) => one.joint?.position ?? one.positionMm;

function Coordinate({ one }: { one: MotorCoordinate }) {
  const unit = useRef<CorrectionUnit | undefined>(undefined);
  if (one.correctionNm !== undefined) unit.current ??= correctionUnit(one.correctionNm);
  return (
    <div class="targets-coordinate">
      <dt>{splitChannel(one.channel).symbol}</dt>
      <dd>
        <span class="result">{grouped(position(one), 8)} <span class="unit">{splitChannel(one.channel).unit}</span></span>
        <span>± {uncertaintyText(one)} (<U90 />)</span>
        {one.minMm !== undefined && <span>not reachable: limits {significant(one.minMm, 4)} to {significant(one.maxMm ?? NaN, 4)}{'\u00a0'}mm</span>}
        {one.correctionNm !== undefined && <span class="muted">correction {correctionText(one.correctionNm, unit.current)}</span>}
      </dd>
    </div>
  );
}

// nm below 100 um, mm above: chosen once, so that a live figure keeps its unit.
export type CorrectionUnit = 'nm' | 'mm';
export const correctionUnit = (nm: number): CorrectionUnit => (Math.abs(nm) < 1e5 ? 'nm' : 'mm');
export function correctionText(nm: number, unit: CorrectionUnit = correctionUnit(nm)): string {
  return unit === 'nm' ? `${signed(nm, 1)} nm` : `${signed(nm / 1e6, 6)} mm`;
}

// Reasons that hold a target back, in words, with the channels that are meant.
export function doubtsOf(target: Target): { flag: Target_Flag; words: string }[] {
  const named: Partial<Record<Target_Flag, readonly string[]>> = {
    [Target_Flag.OUTSIDE_DOMAIN]: target.outsideChannels,
    [Target_Flag.STALE_TEMPERATURE]: target.staleChannels,
    [Target_Flag.MISSING_TEMPERATURE]: target.missingChannels,
    [Target_Flag.OUTSIDE_LIMITS]: target.unreachableChannels,
    [Target_Flag.UNKNOWN_LIMITS]: target.unlimitedChannels,
    [Target_Flag.IGNORED_COORDINATE]: target.ignoredChannels,
    [Target_Flag.ZERO_OUTSIDE_DOMAIN]: target.zeroOutsideChannels,
  };
  return target.flags.map((flag) => {
    return { flag, words: flagInWords(Target_Flag[flag] ?? `flag ${flag}`, named[flag]) };
  });
}

function Flags({ target }: { target: Target }) {
  if (target.flags.length === 0) return <Verdict kind="good">inside the fitted domain, conditions fresh</Verdict>;
  return <>{doubtsOf(target).map(({ flag, words }) => <Verdict kind={flag === Target_Flag.OUTSIDE_LIMITS ? 'bad' : 'warn'} key={flag}>{words}</Verdict>)}</>;
}

const uncertaintyText = (one: MotorCoordinate) => (one.joint ? `${significant(one.joint.u90Arcsec, 2)} arcsec` : `${significant(one.u90Nm, 2)} nm`);

// Another target than was shown: a coordinate differs by more than its U90, or doubts have come.
export function movedBeyond(shown: Target, now: Target): boolean {
  return now.flags.some((flag) => !shown.flags.includes(flag))
    || now.coordinates.some((one, i) => !(Math.abs(one.positionMm - (shown.coordinates[i]?.positionMm ?? NaN)) * 1e6 <= one.u90Nm));
}

function Actions({ target, pose }: { target: Target; pose: Pose }) {
  const text = target.coordinates.map((one) => `${one.channel} = ${position(one).toFixed(8)}`).join('\n');
  const copy = useCommand(() => navigator.clipboard.writeText(text));
  // shown: the target that the person agreed to, which may have run out while the question stood.
  const move = useCommand(async (shown: Target, answer: HoldAnswer) => {
    const isOver = (cellTimeMs.peek() ?? Infinity) > (ms(shown.validUntilTime) ?? 0);
    const now = isOver ? (await targetApi().computeTarget({ pose: [...pose] })).target! : shown;
    if (movedBeyond(shown, now))
      throw new ConnectError('Nothing was moved: the target that was shown is no longer good, and the one of now differs by more than its uncertainty. Look at it and ask again', Code.FailedPrecondition);
    await withLease((leaseToken) =>
      api.cell().move({ leaseToken, answer, coordinates: now.coordinates.map((one) => ({ channel: one.channel, value: one.positionMm })) }));
  });
  const ask = async () => {
    const yes = await confirm({
      title: 'Move the robot there?',
      facts: [
        ['pose', pose.map((one) => `${splitChannel(one.channel).symbol} ${fixed(one.value, 4)} ${unitSign(splitChannel(one.channel).unit)}`).join(', ')],
        ['motors', target.coordinates.map((one) => `${splitChannel(one.channel).symbol} ${grouped(one.positionMm, 6)} mm`).join(', ')],
        ['uncertainty (U90)', target.coordinates.map((one) => `${splitChannel(one.channel).symbol} ± ${uncertaintyText(one)}`).join(', ')],
        ['limits', 'soft limits are checked before anything moves'],
        ...doubtsOf(target).map(({ words }) => ['although', words] as const),
      ],
      verb: 'Move there',
      keep: 'Stay',
    });
    if (!yes) return;
    const run = progress.peek()?.run;
    const answer = run?.hold ? await askAboutHold(run, cellTimeMs.peek(), 'Move the axes') : { holdId: 0n, overrideReason: '' };
    if (answer) await move.send(target, answer);
  };
  return (
    <>
      <Button small busy={copy.busy} onPress={() => copy.send()}>Copy</Button>
      {target.unreachableChannels.length === 0 && !target.coordinates[0]?.joint && <CommandButton small busy={move.busy} onPress={ask}>Move there…</CommandButton>}
      {move.failure && <Failed asked="Move there" failure={move.failure} />}
      {copy.failure && <span class="note muted">This browser does not let the page copy: mark the numbers by hand.</span>}
    </>
  );
}
