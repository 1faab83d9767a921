// The instant that is pinned in every plot against time.
import { dateClock } from '@/format/time';
import { pinned } from '@/plot/instant';
import { Button } from '@/ui/button';

const kSteps = 500;

export function InstantBar() {
  const now = pinned.value;
  if (now === undefined) return null;
  const { atMs, fromMs, toMs } = now;
  return (
    <div class="page-bar instant-bar" role="group" aria-label="Pinned instant">
      <span class="nowrap">At <b>{dateClock(atMs)}</b></span>
      <input
        type="range"
        aria-label="Move the pinned instant"
        aria-valuetext={dateClock(atMs)}
        min={0}
        max={kSteps}
        value={((atMs - fromMs) / (toMs - fromMs)) * kSteps}
        step="any"
        onInput={(event) => (pinned.value = { ...now, atMs: fromMs + (event.currentTarget.valueAsNumber / kSteps) * (toMs - fromMs) })}
      />
      <span class="muted">the line and the values in every plot against time</span>
      <Button small onPress={() => (pinned.value = undefined)}>Let go</Button>
    </div>
  );
}
