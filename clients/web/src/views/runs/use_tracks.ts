// Recorded channels over a run by the pixel: the whole of it first; a zoom shows at once what is there and is refined by the
// daemon a moment later.
import type { Signal } from '@preact/signals';
import { useEffect, useMemo, useState } from 'preact/hooks';
import { failureOf, type Failure } from '@/api/errors';
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

export function useTracks(names: readonly string[], fromMs: number, toMs: number, range: Signal<Range | undefined>, live: boolean): ZoomedTracks {
  const key = names.join();
  const [wide, setWide] = useState<Tracks>();
  const [fine, setFine] = useState<Tracks>();
  const [failure, setFailure] = useState<Failure>();
  const [turn, setTurn] = useState(0);
  const buckets = Math.min(1600, Math.max(300, Math.round(innerWidth / 2)));
  useEffect(() => {
    if (names.length === 0) return undefined;
    const abort = new AbortController();
    streamBegun()
      .then(() => getTracks({ channels: names, fromMs, toMs, buckets }, abort.signal))
      .then((tracks) => !abort.signal.aborted && (setWide(tracks), setFailure(undefined)))
      .catch((error) => !abort.signal.aborted && setFailure(failureOf(error)));
    return () => abort.abort();
  }, [key, fromMs, live ? turn : toMs, turn]);
  useEffect(() => {
    if (!live) return undefined;
    const timer = setInterval(() => !document.hidden && setTurn((n) => n + 1), followMs);
    return () => clearInterval(timer);
  }, [live]);

  const zoom = range.value;
  useEffect(() => {
    if (!zoom || names.length === 0) {
      setFine(undefined);
      return undefined;
    }
    const abort = new AbortController();
    const timer = setTimeout(() => {
      const from = fromMs + zoom.from * 3600e3;
      const to = fromMs + zoom.to * 3600e3;
      getTracks({ channels: names, fromMs: from, toMs: to, buckets }, abort.signal)
        .then((tracks) => !abort.signal.aborted && setFine(tracks))
        .catch((error) => !abort.signal.aborted && setFailure(failureOf(error)));
    }, settleMs);
    return () => {
      clearTimeout(timer);
      abort.abort();
    };
  }, [key, zoom?.from, zoom?.to, fromMs]);

  return useMemo(() => {
    const empty = (channel: string): Track => ({ channel, unit: '', atMs: [], mean: [] });
    return {
      of: (channel: string) => refined(wide?.of.get(channel) ?? empty(channel), fine?.of.get(channel), fine?.fromMs ?? 0, fine?.toMs ?? 0),
      bucketS: (fine ?? wide)?.bucketS ?? 0,
      waiting: wide === undefined && failure === undefined,
      failure,
      again: () => setTurn((n) => n + 1),
    };
  }, [wide, fine, failure]);
}
