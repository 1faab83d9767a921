// When a run of so many seconds of the cell's time would be ready, begun now, by the cell's clock, and on a cell that runs
// faster than the wall how long it takes there. '' until the cell's time is known.
import { fixed } from '@/format/numbers';
import { dayClock, duration } from '@/format/time';
import { cell, cellTimeMs } from '@/live/state';

export const estimatedEnd = (seconds: number): string => {
  const speed = cell.value?.speed || 1;
  return cellTimeMs.value === undefined ? '' : dayClock(cellTimeMs.value + seconds * 1000) + (speed === 1 ? '' : `, ${duration(seconds / speed)} on the wall at ${fixed(speed, speed < 10 ? 1 : 0)} times speed`);
};
