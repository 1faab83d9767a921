// The record: who did what, when, from where. Newest first; what happens now is put on top.
import { useMemo, useState } from 'preact/hooks';
import type { Event } from '@/api/gen/driftwise/v1/cell_service_pb';
import { query, setQuery } from '@/app/router';
import { namesAreProved } from '@/app/session';
import { count } from '@/format/numbers';
import { useEvents } from '@/live/events';
import { eventsBefore, newestEventId } from '@/live/events_page';
import { EventTable } from '@/parts/event_table';
import { Button } from '@/ui/button';
import { Field } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { Awaiting, Empty, Failed } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { ViewTitle } from '@/ui/view_title';
import { Receivers } from './receivers';

const newestFirst = (events: readonly Event[]) => [...events].sort((a, b) => (a.id < b.id ? 1 : -1));

function matches(event: Event, who: string, text: string): boolean {
  if (who !== '' && event.who !== who) return false;
  if (text === '') return true;
  return `${event.who} ${event.what} ${event.detail} ${event.runId ?? ''} ${event.peer}`.toLowerCase().includes(text.toLowerCase());
}

export default function Record() {
  const [older, setOlder] = useState(false);
  const asked = useAsked('events', async (signal) => {
    const newest = await newestEventId(signal);
    return newestFirst(await eventsBefore(newest + 1n, signal));
  });
  useEvents('record', (event) => asked.set((old) => (old.some((one) => one.id === event.id) ? old : newestFirst([event, ...old]))));
  const who = query('who') ?? '';
  const text = query('q') ?? '';
  const all = asked.value;
  const shown = useMemo(() => all?.filter((event) => matches(event, who, text)), [all, who, text]);
  const people = useMemo(() => [...new Set(all?.map((event) => event.who))].sort(), [all]);
  const oldest = all?.[all.length - 1]?.id;

  const loadOlder = async () => {
    setOlder(true);
    try {
      const before = await eventsBefore(oldest!, new AbortController().signal);
      asked.set((old) => newestFirst([...old, ...before]));
    } catch {
      asked.again(); // says what failed
    } finally {
      setOlder(false);
    }
  };
  return (
    <>
      <ViewTitle sub={`Everything that was changed, and what the daemon did by itself. Names are ${namesAreProved() ? 'proved since a log-in is asked for' : 'as typed, not verified'}.`}>Record</ViewTitle>
      <Panel>
        <div class="filters">
          <Field label="Search" type="search" value={text} onInput={(q) => setQuery({ q })} />
          <label class="field">
            <span>Who</span>
            <select value={who} onChange={(event) => setQuery({ who: event.currentTarget.value })} class="input">
              <option value="">everybody</option>
              {[...new Set([...people, ...(who ? [who] : [])])].map((name) => <option key={name} value={name}>{name}</option>)}
            </select>
          </label>
        </div>
        {asked.failure && <Failed asked="List the record" failure={asked.failure} again={asked.again} />}
        {!shown && !asked.failure && <Awaiting what="the record" />}
        {shown?.length === 0 && <Empty next={who || text ? <a href="/record">Show everything</a> : undefined}>{all?.length ? 'Nothing in what is loaded matches.' : 'Nothing has happened yet.'}</Empty>}
        {shown && shown.length > 0 && <EventTable caption="The record, newest first" events={shown} withRun />}
        {oldest !== undefined && oldest > 1n && (
          <p class="more">
            <Button small busy={older} onPress={() => void loadOlder()}>Load older than {count(oldest)}</Button>
          </p>
        )}
      </Panel>
      <Receivers />
    </>
  );
}
