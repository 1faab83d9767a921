// Whether the page is live: what the bar, the tiles and the buttons go by.
import { signal } from '@preact/signals';

export type Connection =
  | { phase: 'connecting' } // nothing seen yet
  | { phase: 'live' }
  | { phase: 'lost'; lastMs: number | undefined }; // lastMs: the clock that the bar shows, at the last heartbeat

export const connection = signal<Connection>({ phase: 'connecting' });
export const serverTimeMs = signal<number | undefined>(undefined); // the daemon's wall clock, once a second
