// What a person must know about the page itself: that it is not live, was loaded afresh, or is older than the daemon.
import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { connection, serverTimeMs } from '@/live/connection';
import { loadedAfresh } from '@/live/epoch';
import { cell } from '@/live/state';
import { clock } from '@/format/time';
import { Button } from '@/ui/button';
import { InstantBar } from './instant_bar';
import { logOut, session } from './session';

function NotLive() {
  const now = connection.value;
  if (now.phase !== 'lost') return null;
  return (
    <div class="page-bar not-live" role="alert">
      <span aria-hidden="true">▲</span>
      {now.lastMs === undefined
        ? 'The daemon does not answer, trying again. Is driftwised running?'
        : `Not live since ${clock(now.lastMs)}, trying again. What is shown is old; commands are off.`}
    </div>
  );
}

function Afresh() {
  if (!loadedAfresh.value) return null;
  return (
    <div class="page-bar" role="status">
      <span>The daemon’s record is another one than before. Everything was loaded afresh.</span>
      <Button small onPress={() => (loadedAfresh.value = false)}>Understood</Button>
    </div>
  );
}

// The daemon was updated under the open page.
function Updated() {
  const first = useSignal<string | undefined>(undefined);
  const version = cell.value?.version;
  useEffect(() => {
    first.value ??= version;
  }, [version]);
  if (!first.value || !version || version === first.value) return null;
  return (
    <div class="page-bar" role="status">
      <span>Driftwise was updated to {version}; reload, nothing typed is lost.</span>
      <Button small onPress={() => location.reload()}>Reload</Button>
    </div>
  );
}

const warnMs = 10 * 60e3;

// By the daemon's clock, which ends it.
function SessionEnds() {
  const ends = Date.parse(session.value.ends ?? '');
  if (!((serverTimeMs.value ?? -Infinity) > ends - warnMs)) return null;
  return (
    <div class="page-bar not-live" role="alert">
      <span>The log-in ends at {clock(ends)}, and Stop motion with it: it comes back with the next log-in. Until then use the emergency switch.</span>
      <Button small onPress={() => void logOut()}>Log in again</Button>
    </div>
  );
}

export function PageBars() {
  return <><NotLive /><SessionEnds /><Afresh /><Updated /><InstantBar /></>;
}
