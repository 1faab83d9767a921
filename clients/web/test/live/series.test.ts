import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { GetSeriesResponseSchema } from '@/api/gen/driftwise/v1/watch_service_pb';
import { timestampOf } from '@/format/time';
import { tracksOf, type Track } from '@/live/series';
import { refined } from '@/views/runs/use_tracks';

const answer = (mean: number[], raw = true) =>
  tracksOf(create(GetSeriesResponseSchema, {
    fromTime: timestampOf(10_000), toTime: timestampOf(10_000 + 1000 * mean.length), bucketDuration: { seconds: 1n, nanos: 0 }, raw,
    series: [{ channel: 'x_mm', unit: 'mm', base: 10, mean, min: mean.map((v) => v - 1), max: mean.map((v) => v + 1), count: mean.map((v) => (Number.isNaN(v) ? 0 : 1)) }],
  })).of.get('x_mm')!;

describe('recorded values', () => {
  it('stand in the middle of their buckets, about the base', () => {
    const track = answer([1, 2, 3]);
    expect(track.atMs).toEqual([10_500, 11_500, 12_500]);
    expect(track.mean).toEqual([11, 12, 13]);
    expect(track.min).toBeUndefined();
  });
  it('have no gap where they are simply rarer than pixels', () => {
    const n = NaN;
    expect(answer([1, n, n, 2, n, n, 3]).mean).toEqual([11, 12, 13]);
  });
  it('have a gap where many usual distances are missing', () => {
    const track = answer([1, 2, 3, ...Array.from({ length: 20 }, () => NaN), 4, 5, 6]);
    expect(track.mean).toEqual([11, 12, 13, NaN, 14, 15, 16]);
  });
  it('carry their extremes where a bucket holds more than one', () => {
    expect(answer([1, 2], false).max).toEqual([12, 13]);
  });
});

it('a zoom replaces its own stretch and keeps what is around', () => {
  const wide: Track = { channel: 'x', unit: 'mm', atMs: [0, 10, 20, 30], mean: [0, 1, 2, 3], min: [0, 1, 2, 3], max: [0, 1, 2, 3] };
  const fine: Track = { channel: 'x', unit: 'mm', atMs: [9, 12, 18], mean: [7, 8, 9] };
  expect(refined(wide, fine, 8, 22)).toEqual({ channel: 'x', unit: 'mm', atMs: [0, 9, 12, 18, 30], mean: [0, 7, 8, 9, 3], min: [0, 7, 8, 9, 3], max: [0, 7, 8, 9, 3] });
  expect(refined(wide, undefined, 0, 0)).toBe(wide);
});
