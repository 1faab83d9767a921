// Tabs of a view are links: each has its address (?tab=plots), the first is the default.
import { place, query } from '@/app/router';

export interface Tab {
  id: string;
  title: string;
}

export const tabOf = (tabs: readonly Tab[], key = 'tab'): string =>
  tabs.find((tab) => tab.id === query(key))?.id ?? tabs[0].id;

export function Tabs({ tabs, label, name = 'tab' }: { tabs: readonly Tab[]; label: string; name?: string }) {
  const chosen = tabOf(tabs, name);
  const to = (id: string) => {
    const next = new URLSearchParams(place.value.query);
    if (id === tabs[0].id) next.delete(name);
    else next.set(name, id);
    const text = next.toString();
    return place.value.path + (text && `?${text}`);
  };
  return (
    <nav class="tabs" aria-label={label}>
      {tabs.map((tab) => (
        <a key={tab.id} href={to(tab.id)} aria-current={tab.id === chosen ? 'page' : undefined}>{tab.title}</a>
      ))}
    </nav>
  );
}
