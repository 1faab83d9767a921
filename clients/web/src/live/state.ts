// What the cell is in now, as the stream says it: replaced whole with every news.
import { signal } from '@preact/signals';
import type { GetStatusResponse } from '@/api/gen/driftwise/v1/cell_service_pb';
import type { RunProgress } from '@/api/gen/driftwise/v1/run_pb';
import { dayClock } from '@/format/time';

export const cell = signal<GetStatusResponse | undefined>(undefined); // without values: those are channels
export const progress = signal<RunProgress | undefined>(undefined); // of the run under way, or the last one seen
export const cellTimeMs = signal<number | undefined>(undefined); // at the last batch

// A simulated cell whose clock is not the wall's.
export const isFast = (): boolean => Math.abs((cell.value?.speed || 1) - 1) > 0.01;

// Time of day for people, by the cell's clock: with its weekday near now, with its date elsewhere.
export const dayOrDate = (atMs: number | undefined): string => dayClock(atMs, cellTimeMs.peek() ?? NaN);
