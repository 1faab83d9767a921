// Fetches the view of the address and shows it; the focus goes to its h1.
import type { ComponentChildren, ComponentType } from 'preact';
import { useEffect, useErrorBoundary, useRef, useState } from 'preact/hooks';
import { Button } from '@/ui/button';
import { Awaiting } from '@/ui/states';
import { epoch } from '@/live/epoch';
import { cell } from '@/live/state';
import { NoteMarks } from '@/parts/note_marks';
import { useWhile } from '@/ui/use_while';
import { place, query, type Place } from './router';
import type { ViewEntry } from './views';

// A part that is gone belongs to an older build: the daemon was updated under the page.
function OldPage({ title }: { title: string }) {
  return (
    <div class="failed" role="alert">
      <p>
        <strong>The view {title} could not be fetched.</strong>{' '}
        {cell.value ? 'Driftwise was updated, or the connection is lost; reload, nothing typed is lost.' : 'The daemon does not answer.'}
      </p>
      <Button kind="main" onPress={() => location.reload()}>Reload</Button>
    </div>
  );
}

// Fault of a view: the rest of the page works on. Another address shows its view; across a room, where nobody presses, the same one
// is tried again by itself.
const wallRetry_ms = 10_000;
function Guarded({ title, children }: { title: string; children: ComponentChildren }) {
  const at = useRef<Place | undefined>(undefined); // where the fault was
  const [fault, again] = useErrorBoundary((error) => {
    at.current = place.peek();
    console.error(error);
  });
  const failed = fault !== undefined && at.current === place.value;
  useWhile(failed && query('wall') === '1', { again, waiting: false }, wallRetry_ms);
  if (!failed) return <>{children}</>;
  return (
    <div class="failed" role="alert">
      <p><strong>The view {title} failed in the page:</strong> {String(fault)}. The run and the daemon are not affected; the bar and Stop work.</p>
      <Button kind="main" onPress={again}>Show it again</Button>
    </div>
  );
}

export function Outlet({ entry }: { entry: ViewEntry }) {
  const [loaded, setLoaded] = useState<{ entry: ViewEntry; View: ComponentType }>();
  const [failed, setFailed] = useState(false);
  const opened = useRef(true); // the page has just been opened: the focus stays where the browser puts it
  useEffect(() => {
    let left = false;
    setFailed(false);
    entry.load().then(
      (module) => !left && setLoaded({ entry, View: module.default }),
      () => !left && setFailed(true),
    );
    return () => void (left = true);
  }, [entry]);
  const shown = loaded?.entry === entry ? loaded : undefined;
  useEffect(() => {
    if (!shown) return;
    if (!opened.current) {
      scrollTo(0, 0);
      document.getElementById('view-title')?.focus({ preventScroll: true });
    }
    opened.current = false;
  }, [shown]);
  if (failed) return <OldPage title={entry.title} />;
  if (!shown) return <Awaiting what={`the view ${entry.title}`} />;
  // State of a view: of the record that it was loaded from.
  return <Guarded title={entry.title}><NoteMarks key={epoch.value}><shown.View /></NoteMarks></Guarded>;
}
