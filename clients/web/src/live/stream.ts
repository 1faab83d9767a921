// The page's one stream of events: from the daemon or from the tab that leads, into signals and listeners.
import { create } from '@bufbuild/protobuf';
import { batch as atOnce } from '@preact/signals';
import { heard } from '@/api/client';
import { WatchEventSchema, WatchResponseSchema, type WatchEvent, type WatchResponse } from '@/api/gen/driftwise/v1/watch_service_pb';
import { ms } from '@/format/time';
import { keepStreaming } from './attempts';
import { resetCellTime } from './channels';
import { connection, serverTimeMs } from './connection';
import { epoch, loadedAfresh } from './epoch';
import { askForPaint, paintFirst } from './paint';
import { closeGate, openGate } from './ready';
import { isFast, progress } from './state';
import { takeBatch } from './take_batch';
import { Tabs, type TabMessage } from './tabs';

const silenceMs = 3000;
const kept = ['layout', 'cell', 'progress', 'values'] as const; // states that a new tab must be given, in this order

let cursor = '';
let heardAt = 0; // performance.now() of the last batch
let lastBatch: WatchResponse | undefined;
const states = new Map<string, WatchEvent>();

// Batches that came since the last frame. News that a run's every point brings would each cost a frame of their own, and a frame
// is what a page costs; so they wait for the next one, a quarter of a second at most. A page that gets no frames (hidden), or none
// in time, takes them as they come.
const waiting: WatchResponse[] = [];
const mostWaiting = 40;

function takeWaiting(): void {
  if (waiting.length === 0) return;
  atOnce(() => {
    for (const batch of waiting.splice(0)) takeBatch(batch);
    serverTimeMs.value = Math.floor((ms(lastBatch?.serverTime) ?? 0) / 1000) * 1000;
  });
}

function take(batch: WatchResponse): void {
  cursor = batch.cursor || cursor;
  heardAt = performance.now();
  lastBatch = batch;
  heard(ms(batch.serverTime));
  for (const event of batch.events) {
    if ((kept as readonly (string | undefined)[]).includes(event.event.case)) states.set(event.event.case!, event);
  }
  waiting.push(batch);
  if (connection.value.phase !== 'live' || document.hidden || waiting.length > mostWaiting) takeWaiting();
  if (connection.value.phase !== 'live') connection.value = { phase: 'live' };
  openGate();
  askForPaint();
}

function loadAfresh(): void {
  cursor = '';
  waiting.length = 0;
  states.clear();
  progress.value = undefined; // nothing says that no run is under way
  resetCellTime();
  closeGate();
  epoch.value++;
  loadedAfresh.value = true;
}

// Only what is now: a tab would take an old state for a sign of life.
function stateForNewTab(): WatchResponse | undefined {
  if (!lastBatch || !states.has('layout') || connection.value.phase !== 'live') return undefined;
  const events = kept.flatMap((kind) => states.get(kind) ?? []).map((event) => create(WatchEventSchema, event));
  return { ...create(WatchResponseSchema), cursor, serverTime: lastBatch.serverTime, cellTime: lastBatch.cellTime, events };
}

// Stream of a follower's own, while it lacks batches: a tab that slept, or that the leader took for closed. It goes on from the own
// cursor and ends where the leader's batches follow it again. Taking the lock instead would make the old leader miss them in turn.
let own: AbortController | undefined;

function endOwn(): void {
  own?.abort();
  own = undefined;
}

function follow(after: string, batch: WatchResponse): void {
  if (after === cursor || (cursor === '' && !own)) {
    endOwn();
    take(batch);
  } else if (!own) {
    own = new AbortController();
    void keepStreaming({ cursor: () => cursor, batch: take, afresh: loadAfresh }, own.signal);
  }
}

function hear(message: TabMessage): void {
  if (message.kind === 'batch') follow(message.after, message.batch);
  if (message.kind === 'state') follow(message.batch.cursor, message.batch);
  if (message.kind !== 'afresh') return;
  endOwn();
  loadAfresh();
}

function judge(): void {
  if (connection.value.phase !== 'lost' && performance.now() - heardAt > silenceMs) {
    connection.value = { phase: 'lost', lastMs: ms(isFast() ? lastBatch?.cellTime : lastBatch?.serverTime) };
  }
  askForPaint();
}

// Returns what ends it: for tests; a page streams until it is closed.
export function startStream(): () => void {
  closeGate();
  paintFirst(takeWaiting);
  heardAt = performance.now();
  const judging = setInterval(judge, 500);
  const tabs: Tabs = new Tabs({
    lead: (signal) => {
      endOwn();
      return keepStreaming(
        {
          cursor: () => cursor,
          batch: (batch) => {
            const after = cursor;
            take(batch);
            tabs.say({ kind: 'batch', after, batch });
          },
          afresh: () => {
            loadAfresh();
            tabs.say({ kind: 'afresh' });
          },
        },
        signal,
      );
    },
    hear,
    state: stateForNewTab,
  });
  tabs.start();
  return () => {
    clearInterval(judging);
    tabs.stop();
    endOwn();
  };
}
