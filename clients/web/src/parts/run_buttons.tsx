// Pause, Resume, Abort, and the word that the weights hang: only what is possible now. What was asked for shows when the
// stream confirms it, not before.
import { useEffect, useState } from 'preact/hooks';
import { api } from '@/api/client';
import { Run_State, type Run } from '@/api/gen/driftwise/v1/run_pb';
import { say } from '@/app/live_region';
import { count, fixed } from '@/format/numbers';
import { cellTimeMs } from '@/live/state';
import { CommandButton } from '@/ui/button';
import { confirm } from '@/ui/confirm';
import { Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';
import { askAboutHold } from './hold_question';
import { isOver, stateWords, wantedForce } from './run_words';

export function RunButtons({ run }: { run: Run }) {
  const runId = run.id;
  const [sent, setSent] = useState<{ what: string; from: Run_State }>();
  const confirmed = sent !== undefined && sent.from !== run.state;
  useEffect(() => {
    if (!confirmed) return;
    say(`Run ${runId}: ${stateWords[run.state][1]}`);
    setSent(undefined);
  }, [confirmed]);
  useEffect(() => {
    if (!sent) return undefined;
    const timer = setTimeout(() => setSent(undefined), 30_000); // a point may take that long to end
    return () => clearTimeout(timer);
  }, [sent]);

  const pause = useCommand(() => api.run().pauseRun({ runId }));
  const resume = useCommand((holdId: bigint, overrideReason: string) => api.run().resumeRun({ runId, answer: { holdId, overrideReason } }));
  const abort = useCommand(() => api.run().abortRun({ runId, reason: 'from the web page' }));
  const force = useCommand((forceN: number) => api.run().confirmForce({ runId, forceN }));
  if (isOver(run)) return null;

  const ask = async (what: string, command: { send: () => Promise<boolean> }) => {
    if (await command.send()) setSent({ what, from: run.state });
  };
  // The question names the pause or stop that it ends: another one in the meantime, and the daemon refuses.
  const askResume = async () => {
    const answer = await askAboutHold(run, cellTimeMs.peek(), `Resume run ${runId}`);
    if (answer && (await resume.send(answer.holdId, answer.overrideReason))) setSent({ what: 'Resume', from: run.state });
  };
  const askAbort = async () => {
    const yes = await confirm({
      title: `Abort run ${runId}?`,
      facts: [
        ['Run', run.name || `run ${runId}`],
        ['Stays', `${count(run.acceptedCount)} accepted points of ${count(run.rowCount)}`],
        ['Is lost', 'the rest of the plan: an aborted run cannot be resumed'],
        ['Started by', run.operatorName || 'unknown'],
      ],
      verb: `Abort run ${runId}`,
      keep: 'Keep running',
      bad: true,
    });
    if (yes) await ask('Abort', abort);
  };
  const hung = wantedForce(run);
  const held = run.hold !== undefined || run.state === Run_State.PAUSED;
  const failed = [pause, resume, abort, force].find((one) => one.failure)?.failure;
  return (
    <div class="stack">
      <div class="actions">
        {hung !== undefined && (
          <CommandButton kind="main" busy={force.busy} onPress={() => void force.send(hung)}>{fixed(hung, 3)} N hang now</CommandButton>
        )}
        {held
          ? <CommandButton kind="main" busy={resume.busy || sent?.what === 'Resume'} onPress={() => void askResume()}>{sent?.what === 'Resume' ? 'Resuming …' : 'Resume…'}</CommandButton>
          : <CommandButton busy={pause.busy || sent?.what === 'Pause'} onPress={() => void ask('Pause', pause)}>{sent?.what === 'Pause' ? 'Pausing after this point …' : 'Pause'}</CommandButton>}
        <CommandButton busy={abort.busy || sent?.what === 'Abort'} onPress={() => void askAbort()}>Abort…</CommandButton>
      </div>
      {failed && <Failed asked={`Run ${runId}`} failure={failed} />}
    </div>
  );
}
