// Gives every plot over time below it the newest remarks that people pinned to an instant.
import type { ComponentChildren } from 'preact';
import { useEvents } from '@/live/events';
import { TimeMarks } from '@/plot/marks';
import { useAsked } from '@/ui/use_asked';
import { newestNotes } from './time_notes';

export function NoteMarks({ children }: { children: ComponentChildren }) {
  const notes = useAsked('pinned remarks', newestNotes);
  useEvents('record', (event) => void (event.what === 'note.pinned' && notes.again()));
  return <TimeMarks.Provider value={notes.value ?? []}>{children}</TimeMarks.Provider>;
}
