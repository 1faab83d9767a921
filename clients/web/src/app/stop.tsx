// Stop motion: on press, without a question, by its own unary call, whatever else the page is doing. Never off. It stands in the
// bar and in every dialog; what came of a press is the page's, so that it stays when the dialog that it was made in is gone.
import { signal } from '@preact/signals';
import { api } from '@/api/client';
import { failureOf } from '@/api/errors';
import { say } from './live_region';

type Outcome = { words: string; bad: boolean };

const meaning =
  'Halts all axes now. A run under way pauses, and resumed visits the point it was at again. A software stop: it does not replace the emergency switch';

const goodShownMs = 6000;

const last = signal<Outcome | undefined>(undefined);
const asking = signal(false); // a stop is under way
const underWay = new Map<AbortController, number>(); // [stop, when it was pressed]
const deadAfterMs = 1000; // a stop without an answer may hang on a line that died

function end(stop: AbortController, outcome: Outcome): void {
  if (!underWay.delete(stop)) return; // given up for a later press
  asking.value = underWay.size > 0;
  if (outcome.bad && asking.value) return; // another press may yet do it
  last.value = outcome;
  say(outcome.words);
  if (!outcome.bad) setTimeout(() => last.value === outcome && (last.value = undefined), goodShownMs);
}

// Every press sends a stop of its own. Those of just before go on: presses in a row must not end one another.
function stop(): void {
  const now = performance.now();
  for (const [old, pressedMs] of underWay) if (now - pressedMs > deadAfterMs && underWay.delete(old)) old.abort();
  const mine = new AbortController();
  underWay.set(mine, now);
  asking.value = true;
  last.value = undefined;
  api.cell().stopAll({}, { timeoutMs: 5000, signal: mine.signal }).then(
    (answer) => end(mine, answer.confirmed
      ? { words: 'Axes halted', bad: false }
      : { words: `Stop not confirmed: use the emergency switch. ${answer.message}`, bad: true }),
    (error) => end(mine, { words: `Stop failed: ${failureOf(error).message} Use the emergency switch.`, bad: true }),
  );
}

// Space clicks again when it is let go: the press was the stop.
function stopByKey(event: KeyboardEvent): void {
  if (event.key !== 'Enter' && event.key !== ' ') return;
  event.preventDefault();
  if (!event.repeat) stop();
}

export function StopButton() {
  const outcome = last.value;
  return (
    <span class="stop-box">
      <button
        type="button"
        class="stop"
        title={meaning}
        onPointerDown={(event) => event.button === 0 && stop()}
        onKeyDown={stopByKey}
        onKeyUp={(event) => event.key === ' ' && event.preventDefault() /* browsers differ in which of the two clicks */}
        onClick={(event) => event.detail === 0 && stop() /* assistive technology clicks without pressing */}
      >
        {asking.value ? 'Stopping …' : 'Stop motion'}
      </button>
      {outcome && (
        <span class={`stop-says ${outcome.bad ? 'stop-failed' : ''}`} role={outcome.bad ? 'alert' : undefined}>
          {outcome.words}
          {outcome.bad && <button type="button" class="link" onClick={() => (last.value = undefined)}>Close</button>}
        </span>
      )}
    </span>
  );
}
