// The bar of every view: whose cell, where to, whether it is live, and Stop, apart from everything else. On a phone the
// views are at the bottom, so that Stop and they are at opposite ends.
import { useEffect, useState } from 'preact/hooks';
import { cell } from '@/live/state';
import { Dialog } from '@/ui/dialog';
import { helpOpen } from './keys';
import { LiveDot } from './live_dot';
import { askName } from './name';
import { place } from './router';
import { operatorName, session } from './session';
import { StopButton } from './stop';
import { dark, setTheme } from './theme';
import { views, type ViewEntry } from './views';

function ViewLink({ view, current }: { view: ViewEntry; current: boolean }) {
  return (
    <a href={`/${view.name}`} aria-current={current ? 'page' : undefined} data-title={view.title}>{view.title}</a>
  );
}

export function Bar({ current }: { current: ViewEntry | undefined }) {
  return (
    <header class="bar">
      <a class="bar-cell" href="/now">{cell.value?.cellName ?? 'Driftwise'}</a>
      <nav aria-label="Views">
        <ul>{views.map((view) => <li key={view.name}><ViewLink view={view} current={view === current} /></li>)}</ul>
      </nav>
      <div class="bar-tools">
        <button type="button" class="icon-button name" onClick={() => void askName()} title={session.value.state === 'in' ? 'Who is logged in here' : 'Your name, as it stands in the record'}>
          {operatorName.value || 'Your name?'}
          {session.value.state === 'in' && <span class="muted"> {session.value.role}</span>}
        </button>
        <button type="button" class="icon-button" aria-label={dark.value ? 'Light colours' : 'Dark colours'} title={dark.value ? 'Light colours' : 'Dark colours'} onClick={() => setTheme(dark.value ? 'light' : 'dark')}>
          <svg width="16" height="16" viewBox="0 0 16 16" aria-hidden="true"><circle cx="8" cy="8" r="6.5" fill="none" stroke="currentColor" stroke-width="1.5" /><path d="M8 1.5a6.5 6.5 0 0 1 0 13Z" fill="currentColor" /></svg>
        </button>
        <button type="button" class="icon-button" aria-label="Settings and keys" title="Settings and keys (?)" onClick={() => (helpOpen.value = true)}>?</button>
      </div>
      <LiveDot />
      <StopButton />
    </header>
  );
}

const first = ['now', 'runs', 'instruments'];

export function BottomTabs({ current }: { current: ViewEntry | undefined }) {
  const [open, setOpen] = useState(false);
  const at = place.value;
  useEffect(() => setOpen(false), [at]);
  const inMore = current !== undefined && !first.includes(current.name);
  return (
    <nav class="tabs-bottom" aria-label="Views, phone">
      <ul>
        {first.map((name) => {
          const view = views.find((one) => one.name === name)!;
          return <li key={name}><ViewLink view={view} current={view === current} /></li>;
        })}
        <li><button type="button" aria-haspopup="dialog" aria-current={inMore ? 'page' : undefined} onClick={() => setOpen(true)}>More</button></li>
      </ul>
      <Dialog subject={open} class="more-views" label="More views" lightly onEnd={() => setOpen(false)}>
        <ul>
          {views.filter((view) => !first.includes(view.name)).map((view) => <li key={view.name}><ViewLink view={view} current={view === current} /></li>)}
          <li><button type="button" onClick={() => { setOpen(false); helpOpen.value = true; }}>Settings, name, colours</button></li>
          <li><button type="button" onClick={() => setOpen(false)}>Close</button></li>
        </ul>
      </Dialog>
    </nav>
  );
}
