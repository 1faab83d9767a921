// What happened in this run and around it, oldest first; and each datum, where the zero was taken anew.
import { api } from '@/api/client';
import type { Run } from '@/api/gen/driftwise/v1/run_pb';
import { dateClock, ms } from '@/format/time';
import { useEvents } from '@/live/events';
import { eventsOfRun } from '@/live/events_page';
import { EventTable } from '@/parts/event_table';
import { Panel } from '@/ui/panel';
import { Awaiting, Empty, Failed } from '@/ui/states';
import { Table } from '@/ui/table';
import { useAsked } from '@/ui/use_asked';

export function LogTab({ run }: { run: Run }) {
  const events = useAsked(`events of run ${run.id}`, (signal) => eventsOfRun(run.id, signal));
  const datums = useAsked(`datums of run ${run.id}`, async (signal) => (await api.run().listDatums({ runId: run.id }, { signal })).datums);
  useEvents('record', (event) => {
    if (event.runId === run.id) events.set((old) => (old.some((one) => one.id === event.id) ? old : [...old, event]));
  });
  return (
    <>
      <Panel title="Log">
        {events.failure && <Failed asked="List the log" failure={events.failure} again={events.again} />}
        {!events.value && !events.failure && <Awaiting what="the log" />}
        {events.value?.length === 0 && <Empty>Nothing is in the record of this run.</Empty>}
        {events.value && events.value.length > 0 && <EventTable caption={`Log of run ${run.id}`} events={events.value} />}
      </Panel>
      <Panel title="Datums: where the zero was taken anew">
        {datums.failure && <Failed asked="List the datums" failure={datums.failure} again={datums.again} />}
        {datums.value && (
          <Table
            caption={`Datums of run ${run.id}`}
            rows={datums.value}
            keyOf={(datum) => String(datum.id)}
            columns={[
              { title: 'datum', of: (datum) => String(datum.id) },
              { title: 'opened', of: (datum) => dateClock(ms(datum.openTime)) },
              { title: 'why', of: (datum) => datum.reason },
            ]}
          />
        )}
      </Panel>
    </>
  );
}
