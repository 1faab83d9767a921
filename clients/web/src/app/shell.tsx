// Around every view: skip link, bar, what is not live, the dialogs, the live region.
import { useEffect } from 'preact/hooks';
import { ConfirmDialog } from '@/ui/confirm';
import { AlarmWatch } from './alarm_watch';
import { Bar, BottomTabs } from './bar';
import { HelpDialog } from './help';
import { LiveRegion } from './live_region';
import { LogIn } from './log_in';
import { NameDialog } from './name';
import { Outlet } from './outlet';
import { PageBars } from './page_bars';
import { PrintHead } from './print_head';
import { go, query, segments } from './router';
import { session } from './session';
import { views } from './views';

export function Shell() {
  if (session.value.state === 'out') return <main id="main" tabIndex={-1}><LogIn /></main>;
  return <Page />;
}

function Page() {
  const name = segments.value[0];
  const entry = views.find((view) => view.name === name);
  useEffect(() => {
    if (!entry) go('/now', 'replace');
  }, [entry]);
  const wall = entry?.name === 'now' && query('wall') === '1';
  return (
    <>
      {!wall && <a class="skip" href="#main">Skip to the content</a>}
      {!wall && <Bar current={entry} />}
      <PageBars />
      <AlarmWatch />
      <PrintHead />
      <main id="main" tabIndex={-1} class={wall ? 'wall' : undefined}>{entry && <Outlet entry={entry} />}</main>
      {!wall && <BottomTabs current={entry} />}
      <ConfirmDialog />
      <HelpDialog />
      <NameDialog />
      <LiveRegion />
    </>
  );
}
