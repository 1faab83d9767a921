// Follows the alarms on every view: for the list, for the live region, and for the tab's title. Stands once in the shell.
import { useEffect } from 'preact/hooks';
import { standing, useAlarms } from '@/live/alarms';
import { pageTitle, viewTitle } from './page_title';

export function AlarmWatch() {
  const alarms = useAlarms();
  useEffect(() => {
    standing.value = alarms;
  });
  useEffect(() => () => void (standing.value = undefined), []);
  const title = pageTitle(viewTitle.value, alarms.value ?? []);
  useEffect(() => {
    document.title = title;
  }, [title]);
  return null;
}
