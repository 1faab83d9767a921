// Fetches the view of the address and shows it; the focus goes to its h1.
import type { ComponentType } from 'preact';
import { useEffect, useRef, useState } from 'preact/hooks';
import { Button } from '@/ui/button';
import { Awaiting } from '@/ui/states';
import { cell } from '@/live/state';
import { NoteMarks } from '@/parts/note_marks';
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
  return <NoteMarks><shown.View /></NoteMarks>;
}
