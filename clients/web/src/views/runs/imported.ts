// Imported run: its points are rows of a file or of joined runs. It has no readings, no attempts, and no instants but that of the
// import: the daemon counts the file's time_s from there.
import type { PlotSpec } from '@/plot/spec';
import type { PointColumns } from '@/live/points';
import { forceMarks } from '@/parts/time_marks';
import type { ZoomedTracks } from './use_tracks';

export const noReadings = 'Imported: no readings on record.';

// The channels as its points have them, in place of the record.
export function tracksOfPoints(columns: PointColumns): ZoomedTracks {
  const atMs = columns.hours.map((hours) => columns.startMs + hours * 3600e3);
  return {
    of: (channel) => ({ channel, unit: '', atMs, mean: columns.of(channel) }),
    bucketS: 0, waiting: false, failure: undefined, again: () => undefined,
  };
}

// Without time of day, and so without what happened in the cell meanwhile: neither belongs to the rows of a file.
export function withoutClock(spec: PlotSpec, columns: PointColumns): PlotSpec {
  const { startMs: _, ...x } = spec.x;
  return { ...spec, x, marks: forceMarks(columns.hours, columns.of('force_N')) };
}
