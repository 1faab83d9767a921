// Recorded values by the pixel: GetSeries as arrays a plot can draw. Times in cell time, ms.
import { api } from '@/api/client';
import type { GetSeriesResponse, Series } from '@/api/gen/driftwise/v1/watch_service_pb';
import { ms, timestampOf } from '@/format/time';

export interface Track {
  channel: string;
  unit: string;
  atMs: number[];
  mean: number[]; // NaN: a gap
  min?: number[]; // absent where every bucket holds one reading at most
  max?: number[];
}

export interface Tracks {
  fromMs: number;
  toMs: number;
  bucketS: number;
  raw: boolean;
  of: Map<string, Track>;
}

export interface SeriesQuestion {
  channels: readonly string[];
  fromMs?: number;
  toMs?: number;
  buckets: number;
  runId?: bigint;
}

// Buckets without a reading are left out; a distance of more than five usual ones (and of two buckets) is a gap.
function trackOf(series: Series, fromMs: number, bucketMs: number, raw: boolean): Track {
  const at: number[] = [];
  for (let i = 0; i < series.mean.length; i++) if (series.count[i] > 0 && !Number.isNaN(series.mean[i])) at.push(i);
  const steps = at.slice(1).map((bucket, i) => bucket - at[i]).sort((a, b) => a - b);
  const usual = steps[steps.length >> 1] ?? 1;
  const track: Track = { channel: series.channel, unit: series.unit, atMs: [], mean: [], ...(!raw && { min: [], max: [] }) };
  const put = (atMs: number, mean: number, min: number, max: number) => {
    track.atMs.push(atMs);
    track.mean.push(mean);
    track.min?.push(min);
    track.max?.push(max);
  };
  at.forEach((bucket, i) => {
    const middle = fromMs + (bucket + 0.5) * bucketMs;
    if (i > 0 && bucket - at[i - 1] > Math.max(2, 5 * usual)) put((track.atMs[track.atMs.length - 1] + middle) / 2, NaN, NaN, NaN);
    put(middle, series.base + series.mean[bucket], series.base + series.min[bucket], series.base + series.max[bucket]);
  });
  return track;
}

export function tracksOf(answer: GetSeriesResponse): Tracks {
  const fromMs = ms(answer.fromTime) ?? 0;
  const bucketMs = Number(answer.bucketDuration?.seconds ?? 0n) * 1000 + (answer.bucketDuration?.nanos ?? 0) / 1e6;
  return {
    fromMs,
    toMs: ms(answer.toTime) ?? fromMs,
    bucketS: bucketMs / 1000,
    raw: answer.raw,
    of: new Map(answer.series.map((series) => [series.channel, trackOf(series, fromMs, bucketMs, answer.raw)])),
  };
}

export async function getTracks(asked: SeriesQuestion, signal?: AbortSignal): Promise<Tracks> {
  const answer = await api.watch().getSeries(
    {
      channels: [...asked.channels],
      bucketCount: Math.max(1, Math.min(10_000, Math.round(asked.buckets))),
      ...(asked.fromMs !== undefined && { fromTime: timestampOf(asked.fromMs) }),
      ...(asked.toMs !== undefined && { toTime: timestampOf(asked.toMs) }),
      ...(asked.runId !== undefined && { runId: asked.runId }),
    },
    { signal },
  );
  return tracksOf(answer);
}
