// Sentences about a stabilised support: how long it has been settled, and the figures of its control loop.
import { create } from '@bufbuild/protobuf';
import { createRouterTransport } from '@connectrpc/connect';
import { signal } from '@preact/signals';
import { cleanup, configure, fireEvent, render, screen, waitFor } from '@testing-library/preact';
import { beforeEach, expect, test, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { CellService, DeviceSchema } from '@/api/gen/driftwise/v1/cell_service_pb';
import { ChannelLayout_ColumnSchema } from '@/api/gen/driftwise/v1/watch_service_pb';
import { setOperatorName } from '@/app/session';
import type { Channel } from '@/live/channels';
import { connection } from '@/live/connection';
import type { History } from '@/live/history';
import { ConfirmDialog } from '@/ui/confirm';
import { StabiliserLoop } from '@/views/instruments/stabiliser_loop';
import { settledFor, StabiliserPanel, type Stabiliser } from '@/views/instruments/stabilisers';

vi.mock('@/plot/plot', () => ({ Plot: () => null }));
vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });

const hour = 3600e3;
const history = (hours: number[], mean: number[], toHour = 6): History => ({
  fromMs: 0, toMs: toHour * hour, bucketS: 60, failure: undefined, waiting: false, again: () => undefined,
  of: (channel) => ({ channel, unit: 'degC', atMs: hours.map((h) => h * hour), mean }),
});
const channel = (name: string, value: number, ageS = 0): Channel => ({
  name, column: create(ChannelLayout_ColumnSchema, { channel: name, unit: 'degC', staleAfterS: 600 }), value: signal(value), ageS: signal(ageS), stale: signal(ageS > 600), measuredMs: 0,
});
const support = (now: number, ageS = 0): Stabiliser => ({
  device: create(DeviceSchema, { id: 'support-x' }), now: channel('support_x_degC', now, ageS), set: channel('support_x_set_degC', 23), output: undefined,
});

beforeEach(() => {
  useTransport(createRouterTransport(({ service }) => service(CellService, {
    getStabiliser: () => ({ settledBandK: 0.01, tuning: { heatBandK: 0.5, coolBandK: 13.889, integralDuration: { seconds: 240n } }, declared: { coolBandK: 14 } }),
  })));
  setOperatorName('Anna');
  connection.value = { phase: 'live' };
});

test('time settled counts readings, and ends at a gap', () => {
  const of = support(23);
  expect(settledFor(history([5.8, 5.9, 6], [23.001, 23.002, 23]), of)?.seconds).toBeCloseTo(0.2 * 3600);
  expect(settledFor(history([5.7, 5.8, 5.9, 6], [23, 23.02, 23, 23]), of)?.seconds).toBeCloseTo(0.1 * 3600);
  expect(settledFor(history([0.1, 0.2, 0.3], [23.001, 23.002, 23]), of)).toBeUndefined();
  expect(settledFor(history([0.1, 0.2, 3, 5.8, 5.9, 6], [23, 23, NaN, 23, 23, 23]), of)?.seconds).toBeCloseTo(0.2 * 3600);
  expect(settledFor(history([5.9, 6], [23, 23.02]), of)).toBeUndefined();
});

test('a loop that swings beyond its band is settled in no window, however wide its buckets', () => {
  const of = support(23);
  for (const bucketS of [1, 7, 43]) {
    const readings = Array.from({ length: 6 * 3600 }, (_, s) => 23 + 0.03 * Math.sin((2 * Math.PI * s) / 20));
    const buckets = Array.from({ length: Math.floor(readings.length / bucketS) }, (_, i) => readings.slice(i * bucketS, (i + 1) * bucketS));
    const track = { channel: 't', unit: 'degC', atMs: buckets.map((_, i) => (i + 0.5) * bucketS * 1000), mean: buckets.map((one) => one.reduce((sum, value) => sum + value, 0) / one.length),
      ...(bucketS > 1 && { min: buckets.map((one) => Math.min(...one)), max: buckets.map((one) => Math.max(...one)) }) };
    expect(settledFor({ ...history([], []), bucketS, of: () => track }, of)?.seconds ?? 0).toBeLessThan(10);
  }
});

test('what was settled at the beginning of the window was so for at least that long', () => {
  const all = Array.from({ length: 61 }, (_, i) => i / 10);
  render(<StabiliserPanel of={support(23)} history={history(all, all.map(() => 23.001))} />);
  expect(screen.getByText('settled for at least 6 h 00 min')).toBeTruthy();
  cleanup();
  render(<StabiliserPanel of={support(23)} history={history(all, all.map((h) => (h < 3 ? 23.02 : 23.001)))} />);
  expect(screen.getByText('settled for 3 h 00 min')).toBeTruthy();
});

test('a support whose thermometer is silent is not called settled', () => {
  render(<StabiliserPanel of={support(23, 2 * 3600)} history={history([0.1, 0.2, 0.3], [23, 23, 23])} />);
  expect(screen.getByText(/not known: last read 2 h.* ago/)).toBeTruthy();
  expect(screen.queryByText(/settled/)).toBeNull();
});

test('bands below one kelvin are shown and asked about as they are', async () => {
  render(<><StabiliserLoop device="support-x" /><ConfirmDialog /></>);
  expect((await screen.findByText('heat band')).nextSibling!.textContent).toBe('0.5 K');
  expect(screen.getByText('cool band').nextSibling!.textContent).toBe('13.89 K, declared 14');
  expect(screen.getByText('integral').nextSibling!.textContent).toBe('240 s');
  fireEvent.click(screen.getByRole('button', { name: /^Loop…/ }));
  fireEvent.input(await screen.findByRole('textbox', { name: 'heat band, K' }), { target: { value: '0.3' } });
  const set = screen.getByRole('button', { name: 'Set…' });
  await waitFor(() => expect(set.getAttribute('aria-disabled')).toBeNull());
  fireEvent.click(set);
  expect(await screen.findByText('0.5 K → 0.3 K')).toBeTruthy();
  fireEvent.click(screen.getByRole('button', { name: 'Keep it as it is' })); // the question belongs to the page: it would outlive the test
});
