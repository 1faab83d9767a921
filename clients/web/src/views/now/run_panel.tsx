// The run under way: state in 44 px, how far, when ready.
import { api } from '@/api/client';
import { Run_State, type Run, type RunProgress } from '@/api/gen/driftwise/v1/run_pb';
import { fixed } from '@/format/numbers';
import { dateClock, duration, ms, secondsOf } from '@/format/time';
import { connection } from '@/live/connection';
import { cell, cellTimeMs, dayOrDate } from '@/live/state';
import { bandText, endBandText } from '@/trajectory/estimate';
import { RunButtons } from '@/parts/run_buttons';
import { doneShare, isOver, stateWords, troubles, whereItIs } from '@/parts/run_words';
import { Panel } from '@/ui/panel';
import { Mark } from '@/ui/verdict';
import { useAsked } from '@/ui/use_asked';

const classOf = (): string => `run-panel${connection.value.phase === 'lost' ? ' stale' : ''}`;

const isHeld = (run: Run): boolean => run.state === Run_State.WAITING || run.state === Run_State.PAUSED;

// When the run will be over by the cell's clock, as all times of the page, and how long that is on the wall.
function Ready({ progress }: { progress: RunProgress }) {
  const endMs = ms(progress.estimatedEndTime);
  const nowMs = cellTimeMs.value;
  const speed = cell.value?.speed || 1;
  if (endMs === undefined || nowMs === undefined) return null;
  const leftS = (endMs - nowMs) / 1000 / speed;
  const remainingS = secondsOf(progress.remainingDuration);
  if (isHeld(progress.run!) && remainingS !== undefined) {
    // Its end moves away while it stands still; what is left of it does not.
    return (
      <div class="ready" title="If it went on now: from the time that points have taken so far, computed by the daemon">
        <span class="muted">ready about, if it went on now</span>
        <strong class="result">{dayOrDate(nowMs + remainingS * 1000)}</strong>
        <span class="muted">{duration(remainingS / speed)} of measuring left{speed !== 1 && ' on the wall'}</span>
        {progress.remainingBand && <span class="muted">{bandText(progress.remainingBand)}</span>}
      </div>
    );
  }
  if (leftS < -30) return <div class="ready"><span class="muted">estimated end passed</span><strong class="result">{duration(-leftS)} ago</strong></div>;
  return (
    <div class="ready" title="From what runs of this cell took and the rows of this one so far, computed by the daemon">
      <span class="muted">ready about</span>
      <strong class="result">{dayOrDate(endMs)}</strong>
      <span class="muted">in {duration(leftS < 120 ? leftS : Math.round(leftS / 60) * 60)}{speed !== 1 && ` on the wall, at ${fixed(speed, speed < 10 ? 1 : 0)} times speed`}</span>
      {progress.latestEndTime && <span class="muted">{endBandText(ms(progress.earliestEndTime), ms(progress.latestEndTime), progress.remainingBand?.share)}</span>}
    </div>
  );
}

export function RunPanel({ progress, buttons }: { progress: RunProgress; buttons: boolean }) {
  const run = progress.run!;
  const [kind, word] = stateWords[run.state];
  const share = doneShare(run);
  const held = isHeld(run);
  return (
    <Panel class={classOf()}>
      <div class="run-state">
        <p class="state"><Mark kind={kind} size={32} /> {word}</p>
        <p class="muted"><a class="quiet" href={`/runs/${run.id}`}>Run {String(run.id)}{run.name && ` · ${run.name}`}</a> · {whereItIs(progress)}</p>
        {held && run.reason && <p class="finding">{run.reason}</p>}
      </div>
      <div class="run-progress">
        <progress value={share} max={1} aria-label="Share of the plan that is decided" />
        <p class="muted">{fixed(share * 100, share > 0 && share < 0.1 ? 1 : 0)} % · {troubles(run)}</p>
      </div>
      <Ready progress={progress} />
      {buttons && <div class="run-buttons"><RunButtons run={run} /></div>}
    </Panel>
  );
}

function Last({ run }: { run: Run }) {
  const [, word] = stateWords[run.state];
  return (
    <>
      Last: <a href={`/runs/${run.id}`}>run {String(run.id)}{run.name && ` · ${run.name}`}</a>, {word.toLowerCase()}{' '}
      {run.endTime && dateClock(ms(run.endTime))}, {String(run.acceptedCount)} of {String(run.rowCount)} points
    </>
  );
}

export function IdlePanel() {
  const lately = useAsked('last run', async (signal) => (await api.run().listRuns({ limit: 1 }, { signal })).runs[0] ?? null);
  const devices = cell.value?.devices ?? [];
  return (
    <Panel class={classOf()}>
      <div class="run-state">
        <p class="state"><Mark kind="idle" size={32} /> No run</p>
        <p class="muted">
          {devices.length > 0 && `The environment of ${devices.length} devices is recorded all the same. `}
          {lately.value && <Last run={lately.value} />}
          {lately.value === null && <>No run yet. <a href="/trajectories">Upload or generate a trajectory</a></>}
        </p>
      </div>
    </Panel>
  );
}

export const underWay = (progress: RunProgress | undefined): RunProgress | undefined =>
  progress?.run && !isOver(progress.run) ? progress : undefined;
