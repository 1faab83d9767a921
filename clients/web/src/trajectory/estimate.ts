// When a run of so many seconds of the cell's time would be ready, begun now: a clock time, or on a cell that runs faster
// than the wall the time it takes there. '' until the cell's time is known.
import { dayClock, duration } from '@/format/time';
import { cell, cellTimeMs } from '@/live/state';

export const estimatedEnd = (seconds: number): string => {
  const speed = cell.value?.speed || 1;
  return cellTimeMs.value === undefined ? '' : speed === 1 ? dayClock(cellTimeMs.value + seconds * 1000) : `${duration(seconds / speed)} on the wall, the cell runs at speed ${speed}`;
};
