// Puts one batch of the stream where it belongs: states into signals, records to whoever listens.
import { batch as atOnce } from '@preact/signals';
import type { Run } from '@/api/gen/driftwise/v1/run_pb';
import type { WatchEvent, WatchResponse } from '@/api/gen/driftwise/v1/watch_service_pb';
import { ms } from '@/format/time';
import { takeCellTime, takeLayout, takeValues } from './channels';
import { announce } from './events';
import { cell, cellTimeMs, progress } from './state';

// A run that ended while the daemon was away has no progress any more, only its record.
function takeRun(run: Run): void {
  const now = progress.peek();
  if (now?.run?.id === run.id) progress.value = { ...now, run };
}

function takeState(event: WatchEvent, cellMs: number): void {
  switch (event.event.case) {
    case 'layout': return takeLayout(event.event.value);
    case 'values': return takeValues(event.event.value, cellMs);
    case 'cell': return void (cell.value = event.event.value);
    case 'run': return takeRun(event.event.value);
    case 'progress': return void (progress.value = event.event.value);
  }
}

export function takeBatch(batch: WatchResponse): void {
  atOnce(() => {
    const cellMs = ms(batch.cellTime) ?? cellTimeMs.peek() ?? 0;
    cellTimeMs.value = cellMs;
    takeCellTime(cellMs);
    for (const event of batch.events) {
      takeState(event, cellMs);
      announce(event);
    }
  });
}
