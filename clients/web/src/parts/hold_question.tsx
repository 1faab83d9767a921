// The question before a run that stands goes on, or the axes are moved meanwhile: who paused it, how long ago, why. It names
// the very pause or stop that it is about; another one that came in the meantime is not ended by it.
import { computed, signal } from '@preact/signals';
import { RunHold_Kind, type Run } from '@/api/gen/driftwise/v1/run_pb';
import { namesAreProved, operatorName } from '@/app/session';
import { dateClock, duration, ms } from '@/format/time';
import { confirm, ReasonField, reasonTaken } from '@/ui/confirm';

export interface HoldAnswer {
  holdId: bigint;
  overrideReason: string;
}

const whatOf: Record<RunHold_Kind, string> = {
  [RunHold_Kind.UNSPECIFIED]: 'Stands since',
  [RunHold_Kind.PAUSE]: 'Paused by',
  [RunHold_Kind.STOP]: 'Stopped by',
  [RunHold_Kind.TROUBLE]: 'Asks for a person',
  [RunHold_Kind.RESTART]: 'Asks for a person',
  [RunHold_Kind.CONFIGURATION]: 'Asks for a person',
  [RunHold_Kind.CONDITION]: 'Waits for the cell',
};

// undefined: not answered. A run that stands for nothing needs no answer.
export async function askAboutHold(run: Run, cellTimeMs: number | undefined, verb: string): Promise<HoldAnswer | undefined> {
  const hold = run.hold;
  if (!hold) return { holdId: 0n, overrideReason: '' };
  const sinceMs = ms(hold.beginTime);
  const ago = cellTimeMs === undefined || sinceMs === undefined ? '' : `, ${duration((cellTimeMs - sinceMs) / 1000)} ago`;
  const byAnother = hold.kind === RunHold_Kind.STOP && hold.who !== operatorName.value;
  const reason = signal('');
  const off = computed(() => (byAnother && reason.value.trim() === '' ? `${hold.who} stopped it: write why the robot may move` : undefined));
  const yes = await confirm({
    title: `${verb}?`,
    words: `The robot moves: look at the machine first. ${namesAreProved() ? 'A log-in' : 'Names are stated, not proved: this'} is no lock-out.`,
    facts: [
      [whatOf[hold.kind], hold.who ? `${hold.who}${ago}` : `since ${dateClock(sinceMs)}`],
      ['Why', hold.reason],
      ...(byAnother ? [['For the record', <ReasonField id={`hold ${hold.id}`} label="Why the robot may move after another person's stop" reason={reason} />] as const] : []),
    ],
    off,
    verb,
    keep: 'Leave it standing',
  });
  if (yes) reasonTaken(`hold ${hold.id}`);
  return yes ? { holdId: hold.id, overrideReason: reason.value.trim() } : undefined;
}
