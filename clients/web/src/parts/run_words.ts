// A run in words: its state as shape and word, what it is at, its limits.
import { Run_State, type Run, type RunProgress } from '@/api/gen/driftwise/v1/run_pb';
import { count } from '@/format/numbers';
import type { VerdictKind } from '@/ui/verdict';

export const stateWords: Record<Run_State, readonly [VerdictKind, string]> = {
  [Run_State.UNSPECIFIED]: ['idle', 'Unknown'],
  [Run_State.QUEUED]: ['idle', 'Queued'],
  [Run_State.RUNNING]: ['good', 'Running'],
  [Run_State.PAUSED]: ['idle', 'Paused'],
  [Run_State.WAITING]: ['warn', 'Waiting'],
  [Run_State.DONE]: ['good', 'Done'],
  [Run_State.ABORTED]: ['bad', 'Aborted'],
  [Run_State.FAILED]: ['bad', 'Failed'],
};

export const isOver = (run: Run): boolean =>
  run.state === Run_State.DONE || run.state === Run_State.ABORTED || run.state === Run_State.FAILED;

// Its points are rows of a file or of joined runs: nothing was measured between its start and its end, which are one instant.
export const isImported = (run: Run): boolean => run.reason === 'imported';

// "uncompensated", "compensated with model 3": as the command line says it.
export const compensationText = (run: Run): string =>
  !run.compensated ? 'uncompensated' : run.compensatePlanId !== undefined ? `compensated by plan ${run.compensatePlanId}` : run.compensateModelId !== undefined ? `compensated with model ${run.compensateModelId}` : 'compensated with the model that served';

export const runName = (run: Run): string => `run ${run.id}${run.name ? ` · ${run.name}` : ''}`;

// "line 23 · point 612 of 1056 · settling"
export function whereItIs(progress: RunProgress): string {
  const run = progress.run!;
  const parts = [`line ${count(progress.line)}`, `point ${count(run.nextRow)} of ${count(run.rowCount)}`];
  if (progress.phase && !isOver(run)) parts.push(progress.phase);
  return parts.join(' · ');
}

// "9 points measured again, 2 given up"
export function troubles(run: Run): string {
  const again = Number(run.attemptCount - run.acceptedCount - run.givenUpCount);
  const parts = [`${again > 0 ? count(again) : 'none'} measured again`, `${run.givenUpCount > 0n ? count(run.givenUpCount) : 'none'} given up`];
  if (run.restartCount > 0) parts.push(`${run.restartCount} ${Number(run.restartCount) === 1 ? 'restart' : 'restarts'} survived`);
  return parts.join(', ');
}

export const doneShare = (run: Run): number => (run.rowCount > 0n ? Number(run.acceptedCount + run.givenUpCount) / Number(run.rowCount) : 0);

// The force that a waiting run wants to be hung, N: the daemon's sentence says "hang 0.768 N (78 g)" or "take every weight off: 0 N".
export function wantedForce(run: Run): number | undefined {
  if (run.state !== Run_State.WAITING) return undefined;
  const found = /(?:hang|off:) ([\d.e+-]+) N/.exec(run.reason);
  return found ? Number(found[1]) : undefined;
}

export function ruleOf(rulesJson: string | undefined, name: string): number | undefined {
  try {
    const value = (JSON.parse(rulesJson || '{}') as Record<string, unknown>)[name];
    return typeof value === 'number' ? value : undefined;
  } catch {
    return undefined;
  }
}
