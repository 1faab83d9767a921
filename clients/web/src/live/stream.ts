// The page's one stream of events: from the daemon or from the tab that leads, into signals and listeners.
import { create } from '@bufbuild/protobuf';
import { WatchEventSchema, WatchResponseSchema, type WatchEvent, type WatchResponse } from '@/api/gen/driftwise/v1/watch_service_pb';
import { ms } from '@/format/time';
import { keepStreaming } from './attempts';
import { resetCellTime } from './channels';
import { connection, serverTimeMs } from './connection';
import { epoch, loadedAfresh } from './epoch';
import { askForPaint } from './paint';
import { closeGate, openGate } from './ready';
import { takeBatch } from './take_batch';
import { Tabs } from './tabs';

const silenceMs = 3000;
const kept = ['layout', 'cell', 'progress', 'values'] as const; // states that a new tab must be given, in this order

let cursor = '';
let heardAt = 0; // performance.now() of the last batch
let heardClockMs: number | undefined; // Date.now() of it
let lastBatch: WatchResponse | undefined;
const states = new Map<string, WatchEvent>();

function take(batch: WatchResponse): void {
  cursor = batch.cursor || cursor;
  heardAt = performance.now();
  heardClockMs = Date.now();
  lastBatch = batch;
  for (const event of batch.events) {
    if ((kept as readonly (string | undefined)[]).includes(event.event.case)) states.set(event.event.case!, event);
  }
  const second = Math.floor((ms(batch.serverTime) ?? 0) / 1000) * 1000;
  serverTimeMs.value = second;
  takeBatch(batch);
  if (connection.value.phase !== 'live') connection.value = { phase: 'live' };
  openGate();
  askForPaint();
}

function loadAfresh(): void {
  cursor = '';
  resetCellTime();
  epoch.value++;
  loadedAfresh.value = true;
}

function stateForNewTab(): WatchResponse | undefined {
  if (!lastBatch || !states.has('layout')) return undefined;
  const events = kept.flatMap((kind) => states.get(kind) ?? []).map((event) => create(WatchEventSchema, event));
  return { ...create(WatchResponseSchema), cursor, serverTime: lastBatch.serverTime, cellTime: lastBatch.cellTime, events };
}

function judge(): void {
  if (connection.value.phase !== 'lost' && performance.now() - heardAt > silenceMs) {
    connection.value = { phase: 'lost', lastMs: heardClockMs };
  }
  askForPaint();
}

// Returns what ends it: for tests; a page streams until it is closed.
export function startStream(): () => void {
  closeGate();
  heardAt = performance.now();
  const judging = setInterval(judge, 500);
  const tabs: Tabs = new Tabs({
    lead: (signal) =>
      keepStreaming(
        {
          cursor: () => cursor,
          batch: (batch) => {
            take(batch);
            tabs.say({ kind: 'batch', batch });
          },
          afresh: () => {
            loadAfresh();
            tabs.say({ kind: 'afresh' });
          },
        },
        signal,
      ),
    hear: (message) => {
      if (message.kind === 'afresh') loadAfresh();
      else if (message.kind === 'state') states.has('layout') || take(message.batch);
      else if (message.kind === 'batch') take(message.batch);
    },
    state: stateForNewTab,
  });
  tabs.start();
  return () => {
    clearInterval(judging);
    tabs.stop();
  };
}
