// Counts how often the page had to load afresh (the stream's cursor was too old, or of another record). It is part of every key:
// when it changes, every answer, merged event and open question goes.
import { signal } from '@preact/signals';

export const epoch = signal(0);
export const loadedAfresh = signal(false); // the page says so until a person has read it
