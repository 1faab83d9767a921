// Counts how often the page had to load afresh (the stream's cursor was too old). Whoever keeps an answer asks again
// when it changes.
import { signal } from '@preact/signals';

export const epoch = signal(0);
export const loadedAfresh = signal(false); // the page says so until a person has read it
