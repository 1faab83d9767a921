// Stop motion: on press, without a question, by its own unary call, whatever else the page is doing. Never off.
import { useEffect, useState } from 'preact/hooks';
import { api } from '@/api/client';
import { failureOf } from '@/api/errors';
import { say } from './live_region';

type Outcome = { words: string; bad: boolean };

const meaning =
  'Halts all axes now. A run under way pauses, and resumed visits the point it was at again. A software stop: it does not replace the emergency switch';

export function StopButton() {
  const [outcome, setOutcome] = useState<Outcome>();
  const [under, setUnder] = useState(false);
  useEffect(() => {
    if (!outcome || outcome.bad) return undefined;
    const timer = setTimeout(() => setOutcome(undefined), 6000);
    return () => clearTimeout(timer);
  }, [outcome]);

  const stop = () => {
    if (under) return;
    setUnder(true);
    setOutcome(undefined);
    api.cell().stopAll({}, { timeoutMs: 5000 }).then(
      (answer) => setOutcome(answer.confirmed
        ? { words: 'Axes halted', bad: false }
        : { words: `Stop not confirmed: use the emergency switch. ${answer.message}`, bad: true }),
      (error) => setOutcome({ words: `Stop failed: ${failureOf(error).message} Use the emergency switch.`, bad: true }),
    ).finally(() => setUnder(false));
  };
  useEffect(() => {
    if (outcome) say(outcome.words);
  }, [outcome]);

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
        {under ? 'Stopping …' : 'Stop motion'}
      </button>
      {outcome && (
        <span class={`stop-says ${outcome.bad ? 'stop-failed' : ''}`} role={outcome.bad ? 'alert' : undefined}>
          {outcome.words}
          {outcome.bad && <button type="button" class="link" onClick={() => setOutcome(undefined)}>Close</button>}
        </span>
      )}
    </span>
  );
}
