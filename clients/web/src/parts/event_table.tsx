// Who did what, when, from where.
import type { Event } from '@/api/gen/driftwise/v1/cell_service_pb';
import { dateClock, ms } from '@/format/time';
import { Table } from '@/ui/table';

// "ipv4:127.0.0.1:50812" -> "127.0.0.1"
export const fromWhere = (peer: string): string => /^ipv[46]:(.*):\d+$/.exec(peer)?.[1] ?? peer.replace(/^unix:.*/, 'this computer');

export function EventTable({ caption, events, withRun }: { caption: string; events: readonly Event[]; withRun?: boolean }) {
  return (
    <Table
      caption={caption}
      rows={events}
      keyOf={(event) => String(event.id)}
      columns={[
        { title: 'when', of: (event) => <span class="nowrap">{dateClock(ms(event.eventTime))}</span>, sort: (event) => Number(event.id) },
        { title: 'who', of: (event) => (event.who === 'daemon' ? <span class="muted">daemon</span> : <strong>{event.who}</strong>), sort: (event) => event.who },
        { title: 'what', of: (event) => <code>{event.what}</code>, sort: (event) => event.what },
        { title: 'detail', of: (event) => event.detail },
        ...(withRun ? [{ title: 'run', of: (event: Event) => (event.runId === undefined ? '' : <a href={`/runs/${event.runId}`}>{String(event.runId)}</a>) }] : []),
        { title: 'from', of: (event) => <span class="muted">{fromWhere(event.peer)}</span> },
      ]}
    />
  );
}
