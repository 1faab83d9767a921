// The latest value of every channel. The stream writes as fast as it comes; what a component reads is painted at most four
// times a second, all channels in one animation frame.
import { computed, signal, type ReadonlySignal, type Signal } from '@preact/signals';
import type { ChannelLayout, ChannelLayout_Column, ValuesUpdate } from '@/api/gen/driftwise/v1/watch_service_pb';
import { connection } from './connection';
import { cell } from './state';

export interface Channel {
  name: string; // "t07_degC"
  column: ChannelLayout_Column;
  value: Signal<number>; // NaN: never read, or not measured
  ageS: Signal<number>; // cell time since it was measured; Infinity: never
  stale: ReadonlySignal<boolean>; // older than its limit, or the page is not live
  measuredMs: number; // of the value that is painted, in heard time; -Infinity: never
}

// News of a channel in one update: [value, its cell time]; undefined: the update does not have the channel.
export type Brought = (name: string) => readonly [number, number] | undefined;

export const layout = signal<readonly Channel[]>([]);

const byName = new Map<string, Channel>();
const places = new Map<string, number>(); // in the values of an update
const hearers = new Set<(brought: Brought) => void>();
let revision = -1n;
let waiting: { values: number[]; measuredMs: number[] } | undefined;

// Cell time that was heard to pass. Cell time on the stream is UTC: a clock that is set back lets it run back, and ages must go
// on all the same.
let heardMs = 0;
let cellNowMs: number | undefined; // at the last batch
let heardAt = 0; // performance.now() of it

// How often cell time ran back by more than the jitter of a clock that is held right: what is in order of time begins anew.
export const stepsBack = signal(0);
const jitterMs = 1000;

// Calls what is given for every update, also for those that are painted by nobody; returns what ends it.
export function onValues(hearer: (brought: Brought) => void): () => void {
  hearers.add(hearer);
  return () => void hearers.delete(hearer);
}

// Reading `layout` makes a component follow a new layout.
export function channel(name: string): Channel | undefined {
  void layout.value;
  return byName.get(name);
}

function made(column: ChannelLayout_Column): Channel {
  const old = byName.get(column.channel);
  const value = old?.value ?? signal(NaN);
  const ageS = old?.ageS ?? signal(Infinity);
  const limit = column.staleAfterS > 0 ? column.staleAfterS : Infinity;
  const stale = computed(() => ageS.value > limit || Number.isNaN(value.value) || connection.value.phase !== 'live');
  return { name: column.channel, column, value, ageS, stale, measuredMs: old?.measuredMs ?? -Infinity };
}

export function takeLayout(from: ChannelLayout): void {
  const next = from.columns.map(made);
  byName.clear();
  for (const one of next) byName.set(one.name, one);
  places.clear();
  next.forEach((one, at) => places.set(one.name, at));
  revision = from.revision;
  waiting = undefined;
  layout.value = next;
}

export function takeValues(update: ValuesUpdate, cellTimeMs: number): void {
  if (update.layoutRevision !== revision) return; // its layout comes first; without it nobody knows what these are
  const before = (nowMs: number, age: bigint) => (age < 0n ? -Infinity : nowMs - Number(age));
  waiting = { values: update.values, measuredMs: update.ageMs.map((age) => before(heardMs, age)) };
  const brought: Brought = (name) => {
    const at = places.get(name);
    return at === undefined ? undefined : [update.values[at], before(cellTimeMs, update.ageMs[at])];
  };
  for (const hearer of hearers) hearer(brought);
}

export function takeCellTime(ms: number): void {
  const passedMs = ms - (cellNowMs ?? ms);
  cellNowMs = ms;
  heardAt = performance.now();
  heardMs += Math.max(0, passedMs);
  if (passedMs < -jitterMs) stepsBack.value++;
}

export function resetCellTime(): void {
  cellNowMs = undefined;
}

// Cell time that passed unheard, by this computer's clock: while the page is not live, ages must not stand still.
const unheardMs = (): number => (connection.peek().phase === 'lost' ? (performance.now() - heardAt) * (cell.peek()?.speed || 1) : 0);

// Called by the painter. Ages grow with the daemon's clock even when no value comes.
export function paintChannels(): void {
  const all = layout.peek();
  if (waiting) {
    for (let i = 0; i < all.length; i++) {
      all[i].value.value = waiting.values[i];
      all[i].measuredMs = waiting.measuredMs[i];
    }
    waiting = undefined;
  }
  const nowMs = heardMs + unheardMs();
  for (const one of all) one.ageS.value = Math.max(0, (nowMs - one.measuredMs) / 1000);
}
