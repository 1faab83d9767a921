// Bar, navigation and the view of the address.
import type { ComponentType } from 'preact';
import { useEffect, useState } from 'preact/hooks';
import { failureOf } from '@/api/errors';
import { Awaiting, Failed } from '@/ui/states';
import { segments, go } from './router';
import { views, type ViewEntry } from './views';

function Outlet({ entry }: { entry: ViewEntry }) {
  const [loaded, setLoaded] = useState<{ entry: ViewEntry; View: ComponentType }>();
  const [failed, setFailed] = useState<unknown>();
  useEffect(() => {
    let left = false;
    setFailed(undefined);
    entry.load().then(
      (module) => !left && setLoaded({ entry, View: module.default }),
      (error) => !left && setFailed(error),
    );
    return () => void (left = true);
  }, [entry]);
  if (failed) return <Failed asked={`Show ${entry.title}`} failure={failureOf(failed)} again={() => location.reload()} />;
  if (loaded?.entry !== entry) return <Awaiting what={`the view ${entry.title}`} />;
  return <loaded.View />;
}

export function Shell() {
  const name = segments.value[0];
  const entry = views.find((view) => view.name === name);
  useEffect(() => {
    if (!entry) go('/now', 'replace');
  }, [entry]);
  return (
    <>
      <header class="bar">
        <nav aria-label="Views">
          {views.map((view) => (
            <a key={view.name} href={`/${view.name}`} aria-current={view === entry ? 'page' : undefined}>{view.title}</a>
          ))}
        </nav>
      </header>
      <main id="main">{entry && <Outlet entry={entry} />}</main>
    </>
  );
}
