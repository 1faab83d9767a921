// Start, progress, cancel and what failed, the same for every study.
import { CommandButton, Button } from '@/ui/button';
import { Failed } from '@/ui/states';
import type { Study } from './use_study';

export function StudyBar<A>({ study, verb, off }: { study: Study<A>; verb: string; off: string | undefined }) {
  const percent = study.progress ? Math.round(100 * study.progress.fraction) : undefined;
  return (
    <>
      <div class="actions models-study">
        <CommandButton kind="main" submit busy={study.busy} off={off}>{verb}</CommandButton>
        {study.busy ? (
          <>
            <progress max={1} value={study.progress?.fraction} aria-label={`Progress: ${verb.toLowerCase()}`} />
            <span class="muted">{study.progress?.step || 'waiting for the worker'}{percent !== undefined && `, ${percent} %`}</span>
            <Button onPress={study.cancel}>Cancel</Button>
          </>
        ) : (
          <span class="note muted">{study.cancelled ? 'Cancelled: nothing was kept.' : off ?? 'Runs beside the cell’s own work; nothing is stored, and leaving this page ends it.'}</span>
        )}
      </div>
      {study.failure && <Failed asked={verb} failure={study.failure} />}
    </>
  );
}
