// When a run of so many seconds of the cell's time would be ready, begun now, by the cell's clock, and on a cell that runs
// faster than the wall how long it takes there. '' until the cell's time is known.
import { fixed } from '@/format/numbers';
import { duration, secondsOf } from '@/format/time';
import { cell, cellTimeMs, dayOrDate } from '@/live/state';
import type { DurationBand } from '@/api/gen/driftwise/v1/run_pb';

export const estimatedEnd = (seconds: number): string => {
  const speed = cell.value?.speed || 1;
  return cellTimeMs.value === undefined ? '' : dayOrDate(cellTimeMs.value + seconds * 1000) + (speed === 1 ? '' : `, ${duration(seconds / speed)} on the wall at ${fixed(speed, speed < 10 ? 1 : 0)} times speed`);
};

// "80 %: 4 h 50 min to 5 h 40 min, from 12 runs of this cell".
export const bandText = (band: DurationBand | undefined): string => {
  if (!band) return '';
  const from = band.runCount === 0n ? '; no run of this cell is on record' : `, from ${band.runCount} ${band.runCount === 1n ? 'run' : 'runs'} of this cell`;
  return `${fixed(band.share * 100, 0)} %: ${duration(secondsOf(band.lowDuration))} to ${duration(secondsOf(band.highDuration))}${from}`;
};
// "80 %: Sun 13:50 UTC to Sun 14:40 UTC".
export const endBandText = (earliestMs: number | undefined, latestMs: number | undefined, share = 0.8): string =>
  earliestMs === undefined || latestMs === undefined ? '' : `${fixed(share * 100, 0)} %: ${dayOrDate(earliestMs)} to ${dayOrDate(latestMs)}`;
