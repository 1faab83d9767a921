// Queue: campaigns that wait for their turn, with the reasons; ordered, held and released here.
import './view.css';
import { QueueEntry_State, type ListQueueResponse, type QueueEntry } from '@/api/gen/driftwise/v1/queue_service_pb';
import { countRows } from '@/format/numbers';
import { dateClock, duration, ms, secondsOf } from '@/format/time';
import { ReportButton } from '@/parts/report_button';
import { bandText, endBandText } from '@/trajectory/estimate';
import { serverTimeMs } from '@/live/connection';
import { useEvents } from '@/live/events';
import { dayOrDate, progress } from '@/live/state';
import { CommandButton } from '@/ui/button';
import { confirm } from '@/ui/confirm';
import { Panel } from '@/ui/panel';
import { Awaiting, Empty, Failed, Warned } from '@/ui/states';
import { Table, type Column } from '@/ui/table';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { useWhile } from '@/ui/use_while';
import { Verdict } from '@/ui/verdict';
import { ViewTitle } from '@/ui/view_title';
import { AddEntry } from './add';
import { queueApi } from './api';
import { entryWords, isOverEntry, mayStartAtOnce, metadataText, startWords, termsOf, type Terms } from './words';

const lookEvery_ms = 5000; // why an entry waits changes with the room

const entryColumns: Column<QueueEntry>[] = [
  { title: 'entry', of: (entry) => String(entry.id) },
  { title: 'name', of: (entry) => <>{entry.name}<span class="muted">, {entry.trajectoryName}, {countRows(entry.rowCount)}</span></> },
  { title: 'state', of: (entry) => <Verdict kind={entryWords[entry.state][0]}>{entryWords[entry.state][1]}</Verdict> },
  { title: 'run', of: (entry) => (entry.runId === undefined ? '–' : <a href={`/runs/${entry.runId}`}>{String(entry.runId)}</a>) },
  { title: 'by', of: (entry) => entry.createdBy },
];

function Ends({ entry }: { entry: QueueEntry }) {
  if (entry.latestEndTime)
    return <>{dayOrDate(ms(entry.estimatedEndTime))}<div class="muted">{endBandText(ms(entry.earliestEndTime), ms(entry.latestEndTime), entry.estimatedBand?.share)}</div></>;
  if (!entry.estimatedDuration) return <>–</>;
  return <>takes {duration(secondsOf(entry.estimatedDuration))}<div class="muted">{bandText(entry.estimatedBand)}</div></>;
}

function Why({ entry }: { entry: QueueEntry }) {
  return (
    <div class="queue-why">
      {entry.waitsFor && <div>{entry.waitsFor}</div>}
      {entry.reason && <div class="muted">{entry.reason}</div>}
      {entry.results.map((result) => <div key={result.followUp}><Verdict kind={result.good ? 'good' : 'bad'}>{result.text}</Verdict></div>)}
    </div>
  );
}

export default function QueueView() {
  const asked = useAsked('queue', async (signal) => queueApi().listQueue({}, { signal }));
  useWhile(true, asked, lookEvery_ms);
  useEvents('run', () => asked.again());
  return (
    <>
      <ViewTitle sub="Campaigns that wait for their turn; one runs at a time">Queue</ViewTitle>
      {asked.failure && <Failed asked="List the queue" failure={asked.failure} again={asked.again} />}
      {!asked.value && !asked.failure && <Awaiting what="the queue" />}
      {asked.value && <Shown queue={asked.value} again={asked.again} />}
    </>
  );
}

function Shown({ queue, again }: { queue: ListQueueResponse; again: () => void }) {
  const open = queue.entries.filter((entry) => !isOverEntry(entry));
  const over = queue.entries.filter(isOverEntry);
  const waiting = open.filter((entry) => entry.state === QueueEntry_State.WAITING);
  const move = useCommand(async (entryId: bigint, beforeEntryId: bigint | undefined) => {
    await queueApi().moveQueueEntry({ entryId, ...(beforeEntryId === undefined ? {} : { beforeEntryId }) });
    again();
  });
  const startsAtOnce = (terms: Terms) => mayStartAtOnce(terms, queue, progress.peek()?.run, serverTimeMs.peek() ?? Date.now());
  const putBack = useCommand(async (entry: QueueEntry) => {
    const terms = { notBeforeMs: ms(entry.notBeforeTime), afterEntryId: entry.afterEntryId };
    const yes = !startsAtOnce(terms) || (await confirm({
      title: `Put entry ${entry.id} "${entry.name}" back?`, verb: 'Put it back', keep: 'Leave it aside',
      facts: [['trajectory', `${entry.trajectoryName}, ${countRows(entry.rowCount)}`], ['starts', startWords(entry.condition)]],
    }));
    if (!yes) return;
    await queueApi().moveQueueEntry({ entryId: entry.id });
    again();
  });
  const remove = useCommand(async (entry: QueueEntry) => {
    const yes = await confirm({ title: `Remove entry ${entry.id} "${entry.name}"?`, verb: 'Remove it', keep: 'Keep it', bad: true });
    if (!yes) return;
    await queueApi().removeQueueEntry({ entryId: entry.id });
    again();
  });
  const buttons = (entry: QueueEntry) => {
    const at = waiting.indexOf(entry);
    const what = `entry ${entry.id}`;
    return (
      <div class="actions">
        {at > 0 && <CommandButton small busy={move.busy} label={`Move ${what} up`} onPress={() => void move.send(entry.id, waiting[at - 1].id)}>Up</CommandButton>}
        {at >= 0 && at + 1 < waiting.length && (
          <CommandButton small busy={move.busy} label={`Move ${what} down`} onPress={() => void move.send(entry.id, waiting[at + 2]?.id)}>Down</CommandButton>
        )}
        {entry.state === QueueEntry_State.SET_ASIDE && <CommandButton small busy={putBack.busy} label={`Put ${what} back`} onPress={() => void putBack.send(entry)}>Put back…</CommandButton>}
        {(at >= 0 || entry.state === QueueEntry_State.SET_ASIDE) && <CommandButton small busy={remove.busy} label={`Remove ${what}`} onPress={() => void remove.send(entry)}>Remove…</CommandButton>}
      </div>
    );
  };
  return (
    <div class="stack">
      <Panel title="What runs and what waits" actions={<HoldButton queue={queue} again={again} />}>
        {queue.hold && <Warned>The queue is held since {dateClock(ms(queue.hold.beginTime))}: {queue.hold.why}. No entry starts until it is released.</Warned>}
        {move.failure && <Failed asked="Move the entry" failure={move.failure} />}
        {putBack.failure && <Failed asked="Put the entry back" failure={putBack.failure} />}
        {remove.failure && <Failed asked="Remove the entry" failure={remove.failure} />}
        {open.length === 0 && <Empty>No campaign waits.</Empty>}
        {open.length > 0 && (
          <Table
            caption="Campaigns in their order"
            rows={open}
            keyOf={(entry) => String(entry.id)}
            columns={[
              ...entryColumns,
              { title: 'priority', number: true, of: (entry) => String(entry.priority) },
              { title: 'terms', of: (entry) => termsOf(entry).map((term) => <div key={term}>{term}</div>) },
              { title: 'metadata', of: (entry) => metadataText(entry.metadata) || '–' },
              { title: 'ends', of: (entry) => <Ends entry={entry} /> },
              { title: 'why it waits', of: (entry) => <Why entry={entry} /> },
              { title: 'do', of: buttons },
            ]}
          />
        )}
        <AddEntry onAdded={again} startsAtOnce={startsAtOnce} />
      </Panel>
      {over.length > 0 && (
        <Panel title="Over">
          <Table
            caption="Campaigns that are over, newest first"
            rows={over}
            page={50}
            keyOf={(entry) => String(entry.id)}
            columns={[...entryColumns, { title: 'ended', of: (entry) => <span class="nowrap">{dateClock(ms(entry.endTime))}</span> }, { title: 'what came of it', of: (entry) => <Why entry={entry} /> }, { title: 'report', of: (entry) => (entry.runId === undefined ? '–' : <ReportButton runId={entry.runId} />) }]}
          />
        </Panel>
      )}
    </div>
  );
}

function HoldButton({ queue, again }: { queue: ListQueueResponse; again: () => void }) {
  const hold = useCommand(async () => {
    await queueApi().holdQueue({});
    again();
  });
  const release = useCommand(async () => {
    const next = queue.entries.find((entry) => entry.state === QueueEntry_State.WAITING);
    const yes = await confirm({
      title: 'Release the queue?', verb: 'Release it', keep: 'Keep it held',
      facts: [['held', queue.hold!.why], ['next', next ? `entry ${next.id} "${next.name}": the robot may move` : 'no campaign waits']],
    });
    if (!yes) return;
    await queueApi().releaseQueue({});
    again();
  });
  return (
    <div class="queue-held">
      {queue.hold
        ? <CommandButton kind="main" busy={release.busy} onPress={() => void release.send()}>Release…</CommandButton>
        : <CommandButton busy={hold.busy} onPress={() => void hold.send()}>Hold</CommandButton>}
      {hold.failure && <Failed asked="Hold the queue" failure={hold.failure} />}
      {release.failure && <Failed asked="Release the queue" failure={release.failure} />}
    </div>
  );
}
