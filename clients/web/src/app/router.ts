// The address is the state: which view, and in its query whatever changes the picture (tab, range, channels, filter).
// Times in addresses are UTC (ISO 8601), so that a link shows a colleague the same.
import { computed, signal } from '@preact/signals';

export interface Place {
  path: string; // "/runs/17"
  query: URLSearchParams;
}

const placeNow = (): Place => ({ path: location.pathname, query: new URLSearchParams(location.search) });

export const place = signal<Place>(placeNow());

// An address that was cut behind a % (in a mail) stays as it is: its view says that there is no such thing.
function decoded(part: string): string {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}

// segments.value[0] names the view, the rest is its own: ["runs", "17"]
export const segments = computed(() => place.value.path.split('/').filter(Boolean).map(decoded));

export function go(to: string, how: 'push' | 'replace' = 'push'): void {
  if (to === location.pathname + location.search) return;
  history[how === 'push' ? 'pushState' : 'replaceState'](null, '', to);
  place.value = placeNow();
}

// Changes some parameters of the query and keeps the rest; undefined or '' takes one out. Does not add to the history
// unless asked: a person who zoomed ten times goes back with one step.
export function setQuery(changes: Record<string, string | undefined>, how: 'push' | 'replace' = 'replace'): void {
  const query = new URLSearchParams(location.search);
  for (const [key, value] of Object.entries(changes)) {
    if (value === undefined || value === '') query.delete(key);
    else query.set(key, value);
  }
  const text = query.toString().replaceAll('%2C', ',').replaceAll('%3A', ':');
  go(location.pathname + (text ? `?${text}` : ''), how);
}

// One parameter of the address. Read it while rendering: the component follows it.
export const query = (key: string): string | undefined => place.value.query.get(key) ?? undefined;

// Links stay real links (open in a new tab, copy address); a plain click stays in the page.
export function followLinks(root: HTMLElement): void {
  addEventListener('popstate', () => (place.value = placeNow()));
  root.addEventListener('click', (event) => {
    if (event.defaultPrevented || event.button !== 0) return;
    if (event.metaKey || event.ctrlKey || event.shiftKey || event.altKey) return;
    const link = (event.target as Element).closest('a');
    if (!link || link.target || link.hasAttribute('download') || link.origin !== location.origin) return;
    if (link.getAttribute('href')?.startsWith('#')) return;
    event.preventDefault();
    go(link.pathname + link.search);
  });
}
