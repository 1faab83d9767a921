// The last minutes or hours of some channels, and on from there: history comes from the daemon's record, so that a reload
// starts with the whole picture; what comes live is put behind it until the record is asked again.
import { useEffect, useMemo, useRef, useState } from 'preact/hooks';
import { failureOf, type Failure } from '@/api/errors';
import { channel, onValues, stepsBack, type Brought } from './channels';
import { connection } from './connection';
import { plotTick } from './paint';
import { streamBegun } from './ready';
import { getTracks, type Track, type Tracks } from './series';
import { cell, cellTimeMs } from './state';

const askAgainMs = 15_000;
const mostTail = 4000;

export interface History {
  fromMs: number; // of the window, cell time
  toMs: number;
  of: (channel: string) => Track;
  bucketS: number;
  failure: Failure | undefined;
  waiting: boolean;
  again: () => void;
}

const empty = (name: string): Track => ({ channel: name, unit: '', atMs: [], mean: [] });

// The middle one of the distances between instants in order; 0 for fewer than two.
export function usualStep(at: readonly number[]): number {
  const steps = at.slice(1).map((one, i) => one - at[i]).sort((a, b) => a - b);
  return steps[steps.length >> 1] ?? 0;
}

// Change of a track, and over which time: from its first to its last value. NaN: fewer than two.
export function changeOf(track: Track): { change: number; seconds: number } {
  const first = track.mean.findIndex(Number.isFinite);
  const last = track.mean.findLastIndex(Number.isFinite);
  return { change: last > first ? track.mean[last] - track.mean[first] : NaN, seconds: last > first ? (track.atMs[last] - track.atMs[first]) / 1000 : NaN };
}

export class Tail {
  private readonly of = new Map<string, { atMs: number[]; value: number[] }>();
  private steps = stepsBack.peek();

  take(names: readonly string[], brought: Brought): void {
    if (this.steps !== stepsBack.peek()) this.of.clear(); // it holds times that are still to come
    this.steps = stepsBack.peek();
    for (const name of names) {
      const [value, measuredMs] = brought(name) ?? [NaN, -Infinity];
      if (!Number.isFinite(measuredMs)) continue;
      const tail = this.of.get(name) ?? { atMs: [], value: [] };
      this.of.set(name, tail);
      if (measuredMs <= (tail.atMs[tail.atMs.length - 1] ?? -Infinity)) continue;
      tail.atMs.push(measuredMs);
      tail.value.push(value);
      if (tail.atMs.length > mostTail) this.forget(tail, mostTail >> 2);
    }
  }
  forgetBefore(atMs: number): void {
    for (const tail of this.of.values()) this.forget(tail, tail.atMs.findIndex((at) => at > atMs) >>> 0);
  }
  // track with what came after it, from fromMs on
  behind(track: Track, fromMs: number, gapMs: number): Track {
    const tail = this.of.get(track.channel);
    const first = track.atMs.findIndex((at) => at >= fromMs);
    const start = first < 0 ? track.atMs.length : first;
    const last = track.atMs[track.atMs.length - 1] ?? fromMs;
    const joined: Track = { ...track, atMs: track.atMs.slice(start), mean: track.mean.slice(start), min: track.min?.slice(start), max: track.max?.slice(start) };
    let before = last;
    const gap = Math.max(gapMs, 4 * usualStep(tail?.atMs ?? []));
    tail?.atMs.forEach((at, i) => {
      if (at <= last) return;
      if (at - before > gap && joined.atMs.length > 0) this.put(joined, (at + before) / 2, NaN);
      this.put(joined, at, tail.value[i]);
      before = at;
    });
    return joined;
  }
  private put(track: Track, at: number, value: number): void {
    track.atMs.push(at);
    track.mean.push(value);
    track.min?.push(value);
    track.max?.push(value);
  }
  private forget(tail: { atMs: number[]; value: number[] }, many: number): void {
    tail.atMs.splice(0, many);
    tail.value.splice(0, many);
  }
}

// A name may be given twice: two instruments of one coordinate have one channel, which is asked for once.
export function useHistory(given: readonly string[], windowS: number, buckets: number): History {
  const names = [...new Set(given)];
  const key = names.join();
  const [tracks, setTracks] = useState<Tracks>();
  const [failure, setFailure] = useState<Failure>();
  const [turn, setTurn] = useState(0);
  const tail = useRef(new Tail());
  const live = connection.value.phase === 'live';
  const steps = stepsBack.value;
  useEffect(() => {
    if (names.length === 0) return undefined;
    const abort = new AbortController();
    const speed = cell.peek()?.speed || 1;
    const ask = async () => {
      await streamBegun();
      const toMs = cellTimeMs.peek();
      if (toMs === undefined) return;
      try {
        const got = await getTracks({ channels: names, fromMs: toMs - windowS * 1000, toMs, buckets }, abort.signal);
        if (abort.signal.aborted) return;
        tail.current.forgetBefore(got.toMs - 2 * got.bucketS * 1000);
        setTracks(got);
        setFailure(undefined);
      } catch (error) {
        if (!abort.signal.aborted) setFailure(failureOf(error));
      }
    };
    void ask();
    // A fast simulated cell goes through its window in seconds; what comes live in a fifth of it is as fine as a pixel.
    const timer = setInterval(() => !document.hidden && void ask(), Math.max(1000, Math.min(askAgainMs, (windowS * 1000) / speed / 5)));
    return () => {
      abort.abort();
      clearInterval(timer);
    };
  }, [key, windowS, buckets, turn, live, steps]);

  // Every update, not every painting: those are too far apart for the pictures of a fast cell.
  useEffect(() => onValues((brought) => tail.current.take(names, brought)), [key]);
  void plotTick.value;
  // A window moves on by whole pixels: ten minutes on 400 of them need no picture more often than every 1.5 s.
  const step = Math.floor((cellTimeMs.peek() ?? 0) / ((windowS * 1000) / buckets));
  return useMemo(() => {
    const toMs = cellTimeMs.peek() ?? tracks?.toMs ?? 0;
    const fromMs = toMs - windowS * 1000;
    const joined = new Map<string, Track>(); // several parts of a view ask for the same channel
    return {
      fromMs,
      toMs,
      bucketS: tracks?.bucketS ?? 0,
      failure,
      waiting: tracks === undefined && failure === undefined,
      again: () => setTurn((n) => n + 1),
      of: (name: string) => {
        const known = joined.get(name);
        if (known) return known;
        const limit = channel(name)?.column.staleAfterS || 0;
        const track = tail.current.behind(tracks?.of.get(name) ?? empty(name), fromMs, Math.max(limit * 1000, 3000 * (tracks?.bucketS ?? 1)));
        joined.set(name, track);
        return track;
      },
    };
  }, [tracks, step, failure, windowS]);
}
