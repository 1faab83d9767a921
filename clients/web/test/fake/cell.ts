// The cell of the make-believe daemon: three axes with a run under way, its channels, points and batches of the stream.
// Nothing here is measured.
import { create, type MessageInitShape } from '@bufbuild/protobuf';
import { Device_Link, GetStatusResponseSchema } from '@/api/gen/driftwise/v1/cell_service_pb';
import { Attempt_Verdict, AttemptSchema, PointSchema, PointSet, Run_State, RunSchema, type Attempt, type Point } from '@/api/gen/driftwise/v1/run_pb';
import { AlarmSchema, Alarm_Level, ChannelLayoutSchema, type WatchEventSchema, type WatchResponseSchema } from '@/api/gen/driftwise/v1/watch_service_pb';
import { timestampOf } from '@/format/time';

const hours = 14;
export const startMs = Date.UTC(2026, 4, 15, 18, 0, 0);
export const at = (minutes: number) => timestampOf(startMs + minutes * 60_000);
const wave = (t: number, period: number, size: number) => size * Math.sin((2 * Math.PI * t) / period);
const noise = (i: number) => (Math.sin(i * 12.9898) * 43758.5453) % 1;

export const fakeChannels: [string, string, string, string][] = [
  ...['q1', 'q2', 'q3'].map((q): [string, string, string, string] => [`${q}_mm`, 'mm', 'robot', 'robot']),
  ...['x', 'y', 'z'].map((x): [string, string, string, string] => [`${x}_mm`, 'mm', `laser-${x}`, 'instrument']),
  ...['x', 'y', 'z'].map((x): [string, string, string, string] => [`level_${x}_pct`, 'pct', `laser-${x}`, 'instrument']),
  ['air_x_degC', 'degC', 'laser-x', 'air'], ['ry_arcsec', 'arcsec', 'collimator-1', 'instrument'], ['rz_arcsec', 'arcsec', 'collimator-1', 'instrument'],
  ...Array.from({ length: 10 }, (_, i): [string, string, string, string] => [`t${String(i + 1).padStart(2, '0')}_degC`, 'degC', 'scanner', i < 3 ? 'instrument' : 'robot']),
  ['support_x_degC', 'degC', 'support-x', ''], ['support_x_set_degC', 'degC', 'support-x', ''], ['support_x_power_pct', 'pct', 'support-x', ''],
  ['force_N', 'N', 'load', ''],
];

export function fakeValue(channel: string, t: number, i = Math.round(t * 1000)): number {
  if (channel.endsWith('_pct')) return 62 + wave(t, 2, 3) + noise(i);
  if (channel === 'support_x_set_degC') return 23;
  if (channel === 'support_x_degC') return 23 + 0.004 * noise(i);
  if (channel.endsWith('_degC')) return 21.3 + wave(t + channel.length, 9, 0.18) + 0.002 * noise(i);
  if (channel === 'force_N') return 0.768;
  if (channel.endsWith('_arcsec')) return -12.4 + wave(t, 5, 0.4) + 0.02 * noise(i);
  return 1e-6 * (wave(t + channel.charCodeAt(0), 8, 35) + 4 * noise(i));
}

const set = (i: number) => (i % 3 === 2 ? PointSet.VALIDATION : PointSet.CALIBRATION);
export const fakePoints: Point[] = Array.from({ length: 612 }, (_, i) => {
  const t = (i / 612) * hours;
  return create(PointSchema, {
    id: BigInt(i + 1), runId: 17n, row: BigInt(i), datumId: 3n, set: set(i), line: BigInt(Math.floor(i / 27)), zero: i % 9 === 0,
    measureTime: timestampOf(startMs + t * 3600e3), dwellDuration: { seconds: 4n, nanos: 0 }, commandedMm: [0, 0.5, 1],
    values: [
      ...fakeChannels.map(([channel]) => ({ channel, value: fakeValue(channel, t, i) + (/^[xyzq]\d?_mm$/.test(channel) && i % 9 ? (i % 7) * 0.25 : 0) })),
      ...['x', 'y', 'z'].map((x, k) => ({ channel: `${x}_std_nm`, value: 3 + 2 * Math.abs(noise(i + k)) })),
    ],
  });
});
export const fakeAttempts: Attempt[] = fakePoints.flatMap((point, i) => {
  const of = (number: number, taken: boolean) => create(AttemptSchema, {
    row: point.row, number, verdict: taken ? Attempt_Verdict.ACCEPTED : Attempt_Verdict.REREAD, spreadNm: taken ? 3 + 2 * Math.abs(noise(i)) : 24.3,
    reason: taken ? '' : 'spread 24.3 nm of 4 readings, limit 20 nm', startTime: point.measureTime, endTime: point.measureTime,
  });
  return i % 68 === 40 ? [of(1, false), of(2, true)] : [of(1, true)];
});

export const fakeRun = create(RunSchema, {
  id: 17n, name: 'cal-val-force', state: Run_State.RUNNING, trajectoryName: 'published.csv', operatorName: 'Anna', rowCount: 1056n, nextRow: 612n,
  acceptedCount: 610n, givenUpCount: 2n, attemptCount: 621n, createTime: timestampOf(startMs), startTime: timestampOf(startMs),
});
export const fakeNowMs = startMs + hours * 3600e3;

export const fakeAlarm = create(AlarmSchema, {
  id: 5n, level: Alarm_Level.WARNING, kind: 'device.late', subject: 'collimator-1',
  message: 'Autocollimator 1 answered late 3 times in 10 min (limit 2 in 10 min). Points are being measured again.', sinceTime: timestampOf(fakeNowMs - 600e3),
});

const device = (id: string, more: object = {}) => ({ id, kind: id, link: Device_Link.CONNECTED, lastLatencyDuration: { seconds: 0n, nanos: 34_000_000 }, exchangeCount: 1200n, ...more });
export const fakeStatus = create(GetStatusResponseSchema, {
  cellName: 'micro-nano', version: '0.1.0', configHash: '91ab23cd45ef', speed: 1, cellTime: timestampOf(fakeNowMs), servingModelId: 12n,
  devices: [
    device('robot', { axes: ['q1_mm', 'q2_mm', 'q3_mm'].map((channel) => ({ channel, minMm: -0.2, maxMm: 2.8 })) }),
    ...['x', 'y', 'z'].map((x) => device(`laser-${x}`, { lengthChannel: `${x}_mm` })),
    device('collimator-1', { angleChannels: ['ry_arcsec', 'rz_arcsec'] }),
    device('scanner', { probes: Array.from({ length: 10 }, (_, i) => ({ channel: `t${String(i + 1).padStart(2, '0')}_degC`, place: `column ${i}`, part: i < 3 ? 'instrument' : 'robot' })) }),
    device('support-x'), device('load', { forceChannel: 'force_N' }),
  ],
});

type Event = MessageInitShape<typeof WatchEventSchema>;
const layoutEvent: Event = {
  event: {
    case: 'layout',
    value: create(ChannelLayoutSchema, {
      revision: 1n,
      columns: fakeChannels.map(([channel, unit, deviceId, part]) => ({ channel, unit, deviceId, intervalS: 1, staleAfterS: channel === 'ry_arcsec' ? 2 : 30, part, place: part })),
    }),
  },
};

export function fakeBatch(n: number): MessageInitShape<typeof WatchResponseSchema> {
  const nowMs = fakeNowMs + n * 100;
  const t = (nowMs - startMs) / 3600e3;
  const values: Event = {
    event: { case: 'values', value: { $typeName: 'driftwise.v1.ValuesUpdate', layoutRevision: 1n, values: fakeChannels.map(([channel]) => fakeValue(channel, t, n)), ageMs: fakeChannels.map(([channel]) => (channel === 'ry_arcsec' ? 48_000n : 200n)) } },
  };
  const progress: Event = { event: { case: 'progress', value: { $typeName: 'driftwise.v1.RunProgress', run: fakeRun, phase: 'settling', row: 612n, line: 23n, lastSpreadNm: 3.8, sequence: BigInt(n), estimatedEndTime: timestampOf(fakeNowMs + 6.08 * 3600e3) } } };
  return { cursor: `c${n}`, serverTime: timestampOf(nowMs), cellTime: timestampOf(nowMs), events: n === 0 ? [layoutEvent, { event: { case: 'cell', value: fakeStatus } }, progress, values] : [values] };
}
