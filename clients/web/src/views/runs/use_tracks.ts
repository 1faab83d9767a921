// Recorded channels over a run by the pixel: the whole of it first; a zoom shows at once what is there and is refined by the
// daemon a moment later.
import type { Signal } from '@preact/signals';
import { useEffect, useMemo, useState } from 'preact/hooks';
import { failureOf, type Failure } from '@/api/errors';
import type { Point, Run } from '@/api/gen/driftwise/v1/run_pb';
import { ms } from '@/format/time';
import { streamBegun } from '@/live/ready';
import { getTracks, type Track, type Tracks } from '@/live/series';
import type { Range } from '@/plot/plot';

const settleMs = 120; // while a hand still turns the wheel nothing is asked
const followMs = 5000;

export interface ZoomedTracks {
  of: (channel: string) => Track;
  bucketS: number;
  waiting: boolean;
  failure: Failure | undefined;
  again: () => void;
}

// What was asked wide, with the part that was asked finely in its place.
export function refined(wide: Track, fine: Track | undefined, fromMs: number, toMs: number): Track {
  if (!fine) return wide;
  const before = wide.atMs.findIndex((at) => at >= fromMs);
  const cut = before < 0 ? wide.atMs.length : before;
  const found = wide.atMs.findIndex((at) => at > toMs);
  const rest = found < 0 ? wide.atMs.length : found;
  const join = (w: number[] | undefined, wMean: number[], f: number[] | undefined, fMean: number[]) =>
    [...(w ?? wMean).slice(0, cut), ...(f ?? fMean), ...(w ?? wMean).slice(rest)];
  const banded = wide.min !== undefined || fine.min !== undefined;
  return {
    ...wide,
    atMs: [...wide.atMs.slice(0, cut), ...fine.atMs, ...wide.atMs.slice(rest)],
    mean: [...wide.mean.slice(0, cut), ...fine.mean, ...wide.mean.slice(rest)],
    ...(banded && { min: join(wide.min, wide.mean, fine.min, fine.mean), max: join(wide.max, wide.mean, fine.max, fine.mean) }),
  };
}

export interface Span {
  fromMs: number;
  toMs: number;
}

// From the first to the last instant that a run and its points have: the computer's clock may have been set back between two of them.
// Undefined: there is no stretch of time that readings could be from.
export function spanOf(run: Run, points: readonly Point[], nowMs: number | undefined): Span | undefined {
  const start = ms(run.startTime) ?? ms(points[0]?.measureTime);
  if (start === undefined) return undefined;
  let [fromMs, toMs] = [start, start];
  for (const at of [ms(run.endTime) ?? nowMs ?? start + 1000, ...points.map((point) => ms(point.measureTime) ?? start)]) {
    fromMs = Math.min(fromMs, at);
    toMs = Math.max(toMs, at);
  }
  return fromMs < toMs ? { fromMs, toMs } : undefined;
}

// startMs: what the hours of range count from. Nothing is asked without names or without a span.
export function useTracks(names: readonly string[], startMs: number, span: Span | undefined, range: Signal<Range | undefined>, live: boolean): ZoomedTracks {
  const { fromMs, toMs } = span ?? {};
  const asks = names.length > 0 && span !== undefined;
  const key = names.join();
  const [wide, setWide] = useState<Tracks>();
  const [fine, setFine] = useState<Tracks>();
  const [failure, setFailure] = useState<Failure>();
  const [turn, setTurn] = useState(0);
  const buckets = Math.min(1600, Math.max(300, Math.round(innerWidth / 2)));
  useEffect(() => {
    if (!asks) return undefined;
    const abort = new AbortController();
    streamBegun()
      .then(() => getTracks({ channels: names, fromMs, toMs, buckets }, abort.signal))
      .then((tracks) => !abort.signal.aborted && (setWide(tracks), setFailure(undefined)))
      .catch((error) => !abort.signal.aborted && setFailure(failureOf(error)));
    return () => abort.abort();
  }, [key, asks, fromMs, live ? turn : toMs, turn]);
  useEffect(() => {
    if (!live) return undefined;
    const timer = setInterval(() => !document.hidden && setTurn((n) => n + 1), followMs);
    return () => clearInterval(timer);
  }, [live]);

  const zoom = range.value;
  useEffect(() => {
    if (!zoom || !asks) {
      setFine(undefined);
      return undefined;
    }
    const abort = new AbortController();
    const timer = setTimeout(() => {
      const from = startMs + zoom.from * 3600e3;
      const to = startMs + zoom.to * 3600e3;
      getTracks({ channels: names, fromMs: from, toMs: to, buckets }, abort.signal)
        .then((tracks) => !abort.signal.aborted && setFine(tracks))
        .catch((error) => !abort.signal.aborted && setFailure(failureOf(error)));
    }, settleMs);
    return () => {
      clearTimeout(timer);
      abort.abort();
    };
  }, [key, asks, zoom?.from, zoom?.to, startMs]);

  return useMemo(() => {
    const empty = (channel: string): Track => ({ channel, unit: '', atMs: [], mean: [] });
    return {
      of: (channel: string) => refined(wide?.of.get(channel) ?? empty(channel), fine?.of.get(channel), fine?.fromMs ?? 0, fine?.toMs ?? 0),
      bucketS: (fine ?? wide)?.bucketS ?? 0,
      waiting: asks && wide === undefined && failure === undefined,
      failure,
      again: () => setTurn((n) => n + 1),
    };
  }, [wide, fine, failure, asks]);
}
