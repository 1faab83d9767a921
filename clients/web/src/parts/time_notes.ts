// Remarks that people pinned to an instant, as marks of the plots over that time.
import type { Run } from '@/api/gen/driftwise/v1/run_pb';
import { ms } from '@/format/time';
import type { TimeMark } from '@/plot/marks';

const most = 200;

async function notesIn(range: { fromTime?: Run['startTime'] & {}; toTime?: Run['endTime'] & {} }, signal: AbortSignal): Promise<TimeMark[]> {
  const { lookBackApi } = await import('@/api/look_back'); // after the first numbers: the page opens without it
  const { notes } = await lookBackApi().listTimeNotes({ ...range, limit: most }, { signal });
  return notes.map((note) => ({ atMs: ms(note.noteTime) ?? NaN, kind: 'note', label: `${note.channel ? `${note.channel}: ` : ''}${note.text} (${note.who})` }));
}

export const notesDuring = (run: Run, signal: AbortSignal): Promise<TimeMark[]> =>
  notesIn({ ...(run.startTime && { fromTime: run.startTime }), ...(run.endTime && { toTime: run.endTime }) }, signal);

export const newestNotes = (signal: AbortSignal): Promise<TimeMark[]> => notesIn({}, signal);
