// A run's report as the command line writes it, small: for tests.
const packed = (values: readonly number[]): string => {
  const bytes = new Uint8Array(4 * values.length);
  const view = new DataView(bytes.buffer);
  values.forEach((value, i) => view.setFloat32(4 * i, value, true));
  return btoa(String.fromCharCode(...bytes));
};

export function sampleReport(count = 60) {
  const index = Array.from({ length: count }, (_, i) => i);
  const column = (channel: string, base: number, scale: number, of: (i: number) => number) => ({ channel, base, scale, data: packed(index.map(of)) });
  const zero = (i: number) => i % 12 === 0;
  return {
    schema: 'driftwise.run-report.v1', cell: 'micro-nano <lab>', config_hash: 'abc123', version: '0.1.0', made: '2026-11-21T15:00:00Z', later_key: true,
    run: { id: 17, name: 'weekend', state: 'done', reason: '', trajectory: 'published.csv', operator: 'anna', start: '2026-11-20T16:00:00Z', end: '2026-11-21T02:00:00Z', elapsed_s: 36000, rows: count, accepted: count, given_up: 0, attempts: count + 1, restarts: 0 },
    rules: { max_spread_nm: 20 },
    points: {
      count, time_s: packed(index.map((i) => i * 600)), row: packed(index), line: packed(index.map((i) => Math.floor(i / 12) + 1)), set: packed(index.map((i) => (i % 5 === 4 ? 1 : 0))), zero: packed(index.map((i) => (zero(i) ? 1 : 0))), tries: packed(index.map(() => 1)), datum: packed(index.map((i) => (i < 30 ? 3 : 4))),
      columns: [
        ...['q1_mm', 'q2_mm', 'q3_mm'].map((channel, k) => column(channel, 1, 1e-6, (i) => (zero(i) ? -1e6 : 1e6 * Math.sin(i + k)))),
        ...['x_mm', 'y_mm', 'z_mm'].map((channel, k) => column(channel, 0.5, 1e-6, (i) => (zero(i) ? -5e5 + i * (k + 1) : 1e5 * i))),
        column('x_std_nm', 4, 1, (i) => Math.sin(i)), column('t07_degC', 22, 1, (i) => 0.01 * i), column('force_N', 0, 1, (i) => (i < 30 ? 0 : 0.768)),
      ],
    },
    attempts: [{ row: 7, number: 1, verdict: 'reread', reason: 'spread 25 nm of 4 readings, limit 20 nm', spread_nm: 25, time_s: 4100 }],
    events: [{ time: '2026-11-20T16:00:00Z', who: 'anna', what: 'run.started', detail: 'anna started run 17' }],
    axes: ['q1_mm', 'q2_mm', 'q3_mm'].map((channel) => ({ channel, min_mm: -0.2, max_mm: 2.8 })),
  };
}

// Parts of a report that only a run of the queue has.
export function sampleStory() {
  const at = (clock: string) => `2026-11-20T${clock}:00Z`;
  return {
    queue: {
      entry: 2,
      entries: [{
        id: 2, name: 'night', state: 'following', reason: '', by: 'ada', queued: at('15:00'), begun: at('16:00'), ended: at('23:00'), after: null, condition: '', run: 17,
        results: [{ follow_up: 'fit:q ~ x', good: true, text: 'model 3 was fitted', time: at('23:01') }], run_state: 'done', rows: 60, accepted: 58, given_up: 1, restarts: 1,
      }],
    },
    alarms: [{
      id: 1, kind: 'device.lost', subject: 'scanner', priority: 'medium', state: 'normal', message: 'the scanner does not answer', consequences: [], since: at('17:00'), over: at('18:00'), acknowledged: at('17:10'), acknowledged_by: 'bob',
    }],
    events: [
      { time: at('19:00'), who: 'daemon', what: 'hold.begun', detail: 'hold room: t12_degC 20.7 above 20.5' },
      { time: at('20:00'), who: 'daemon', what: 'run.restarted', detail: 'a restarted daemon went on with run 17' },
    ],
    attempts: [{ row: 9, number: 3, verdict: 'given_up', reason: 'spread 40 nm', spread_nm: 40, time_s: 5 * 3600 }],
    models: [{ id: 3, name: 'night', formula: 'q ~ x', accuracy: [], count: 2, time_s: packed([0, 60]), set: packed([0, 1]), residuals: [{ output: 'q1', unit: 'nm', data: packed([1.5, -2]) }], trouble: '' }],
    diagnoses: [],
  };
}
