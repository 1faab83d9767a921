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

function end(outcome: Outcome): void {
  last.value = outcome;
  say(outcome.words);
  if (!outcome.bad) setTimeout(() => last.value === outcome && (last.value = undefined), goodShownMs);
}

function stop(): void {
  if (asking.value) return;
  asking.value = true;
  last.value = undefined;
  api.cell().stopAll({}, { timeoutMs: 5000 }).then(
    (answer) => end(answer.confirmed
      ? { words: 'Axes halted', bad: false }
      : { words: `Stop not confirmed: use the emergency switch. ${answer.message}`, bad: true }),
    (error) => end({ words: `Stop failed: ${failureOf(error).message} Use the emergency switch.`, bad: true }),
  ).finally(() => (asking.value = false));
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
        onKeyDown={(event) => (event.key === 'Enter' || event.key === ' ') && !event.repeat && stop()}
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
