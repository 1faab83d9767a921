// Order in which models or serving plans served, and taking the newest promotion back.
import { Code, ConnectError } from '@connectrpc/connect';
import { confirm, type Question } from '@/ui/confirm';

export interface Served {
  id?: bigint; // what served from then on; absent: none
  rollback: boolean;
}

// The one that serves, and the one after taking the newest promotion back: promotions and rollbacks as a stack, oldest first. A repeated
// promotion is in it once, and a rollback goes back to the one that it names, as the daemon counts them.
export function servedBefore(history: readonly Served[]): { now?: bigint; before?: bigint } {
  const stack: bigint[] = [];
  for (const one of history) {
    if (one.rollback) {
      while (stack.length > 0 && stack.at(-1) !== one.id) stack.pop();
      if (stack.length === 0 && one.id !== undefined) stack.push(one.id);
    } else if (one.id !== undefined && one.id !== stack.at(-1)) stack.push(one.id);
  }
  return { now: stack.at(-1), before: stack.at(-2) };
}

export interface Serving {
  what: 'model' | 'plan';
  affected: string;
  none: string; // what follows where none serves
  history: () => Promise<Served[]>;
  look: (id: bigint) => Promise<{ facts: NonNullable<Question['facts']>; against: readonly string[] }>; // of what would serve again
  rollBack: (from: bigint) => Promise<unknown>; // the daemon refuses where another serves by then
}

export const servedText = (what: string, id: bigint | undefined) => (id === undefined ? `no ${what}` : `${what} ${id}`);

// The answer is to the history that was shown: with a promotion or rollback of somebody else in between nothing is rolled back.
export async function rollBack({ what, affected, none, history, look, rollBack: act }: Serving): Promise<void> {
  const { now, before } = servedBefore(await history());
  if (now === undefined) return;
  const { facts, against } = before === undefined ? { facts: [], against: [] } : await look(before);
  const bad = before === undefined || against.length > 0;
  const yes = await confirm({
    title: `Roll back from ${what} ${now}?`, keep: `Keep ${what} ${now}`, bad,
    verb: `Serve ${servedText(what, before)}${against.length > 0 ? ' all the same' : ''}`,
    ...(before === undefined && { words: `No ${what} served before it: ${none} until one is promoted.` }),
    facts: [['serves now', `${what} ${now}`], ['from then on', servedText(what, before)], ...facts, ['who is affected', affected], ...against.map((words) => ['although', words] as const)],
  });
  if (!yes) return;
  const present = servedBefore(await history());
  if (present.now !== now || present.before !== before)
    throw new ConnectError(`nothing was rolled back: ${servedText(what, present.now)} serves by now, where you were asked about ${what} ${now}; look at the list, then try again`, Code.FailedPrecondition);
  await act(now);
}
