// What served in which order: promotions and rollbacks as a stack.
export interface Served {
  id?: bigint; // absent: none served after a rollback
  rollback: boolean;
}

// What serves, and what would serve after taking the newest promotion back. Oldest first.
export function servedBefore(history: readonly Served[]): { now?: bigint; before?: bigint } {
  const stack: bigint[] = [];
  for (const one of history) {
    if (one.rollback) stack.pop();
    else if (one.id !== undefined) stack.push(one.id);
  }
  return { now: stack.at(-1), before: stack.at(-2) };
}
