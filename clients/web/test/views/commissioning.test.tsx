// Manual, Commissioning and Look back before a daemon in memory.
import { create } from '@bufbuild/protobuf';
import { Code, ConnectError, createRouterTransport } from '@connectrpc/connect';
import { act, fireEvent, render, screen, within } from '@testing-library/preact';
import { beforeEach, describe, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { CellService, GetStatusResponseSchema } from '@/api/gen/driftwise/v1/cell_service_pb';
import { CheckVerdict, CommissioningService } from '@/api/gen/driftwise/v1/commissioning_service_pb';
import { LookBackService } from '@/api/gen/driftwise/v1/look_back_service_pb';
import { ChannelLayoutSchema, ValuesUpdateSchema, WatchService } from '@/api/gen/driftwise/v1/watch_service_pb';
import { go } from '@/app/router';
import { operatorName } from '@/app/session';
import { paintChannels, takeLayout, takeValues } from '@/live/channels';
import { connection } from '@/live/connection';
import { cell, progress } from '@/live/state';
import { runsTyped } from '@/views/lookback/compare';
import { overlays } from '@/views/lookback/specs';
import Commissioning from '@/views/commissioning/view';
import { isOptical } from '@/views/manual/light';
import Manual from '@/views/manual/view';
import { settledK } from '@/parts/settled';
import { Receivers } from '@/views/record/receivers';

const begun = vi.fn();
const signs = vi.fn();
const ended = vi.fn();
let lose = false; // the answers to signs of life
let silent: string[] = []; // calls that get no answer at all
let restsAfter_ms = 0; // the axis, once its end is asked for
const jog = (over: boolean) => ({ id: 7n, over, released: over, endReason: over ? 'let go' : '', positions: [{ channel: 'q1_mm', positionMm: 1.25 }], stepCount: 3n });

const answer = <T,>(call: string, value: T): T | Promise<T> => (silent.includes(call) ? new Promise<T>(() => undefined) : value);

const daemon = () => createRouterTransport(({ service }) => {
  service(CellService, { takeLease: () => answer('takeLease', { lease: { token: 'mine' } }), giveUpLease: () => ({}), getStabiliser: () => ({ settledBandK: 0.02 }) });
  service(CommissioningService, {
    beginJog: (request) => (begun(request.channel, request.stepMm, request.held), answer('beginJog', { jog: jog(false) })),
    holdJog: () => {
      signs();
      if (lose) throw new ConnectError('reset', Code.Unavailable);
      return answer('holdJog', { jog: jog(false) });
    },
    endJog: async () => {
      ended();
      if (restsAfter_ms > 0) await new Promise((done) => setTimeout(done, restsAfter_ms));
      return answer('endJog', { jog: jog(true) });
    },
    checkCell: () => ({
      verdict: CheckVerdict.BAD,
      items: [{ deviceId: 'laser-x', asked: 'light level', found: '12 %', expected: 'at least 30 %', verdict: CheckVerdict.WARNING, advice: 'align beam and mirror' }],
    }),
    getRest: () => ({ rest: { sentence: 'warm since 03:10', beginTime: { seconds: 1n, nanos: 0 }, warmTime: { seconds: 2n, nanos: 0 }, channels: [{ channel: 'x_mm', unit: 'nm/h', rate: 4.2, uRate: 1, limit: 20, change: 30, changeUnit: 'nm' }] } }),
    listCertificates: () => ({ certificates: [{ deviceId: 'laser-x', number: '4711', laboratory: 'PTB', date: '2024-01-01', dueDate: '2026-01-01', daysLeft: -40n }], without: ['scanner'] }),
  });
  service(LookBackService, {});
  service(WatchService, {
    listReceivers: () => ({
      receivers: [{ name: 'duty', way: 'webhook https://hooks.example.org', failingTime: { seconds: 1n, nanos: 0 }, answer: 'HTTP 503', waitingCount: 2n }],
      tellings: [{ alarmId: 4n, receiver: 'duty', error: 'HTTP 503', failedCount: 3n }],
    }),
  });
});

beforeEach(() => {
  vi.clearAllMocks();
  lose = false;
  silent = [];
  operatorName.value = 'Anna';
  useTransport(daemon());
  connection.value = { phase: 'live' };
  progress.value = undefined;
  cell.value = create(GetStatusResponseSchema, { speed: 1, devices: [{ id: 'axis', axes: [{ channel: 'q1_mm', minMm: -4, maxMm: 4 }] }] });
  go('/manual');
});

// jsdom's pointer events have no button.
const pointer = (on: HTMLElement, what: string) => fireEvent(on, new MouseEvent(what, { button: 0, bubbles: true }));
const button = () => screen.findByRole('button', { name: /^Hold to move q1_mm up/ });

describe('positions', () => {
  const valuesOf = (value: number) => {
    takeLayout(create(ChannelLayoutSchema, { revision: 1n, columns: [{ channel: 'q1_mm', unit: 'mm', staleAfterS: 10 }] }));
    takeValues(create(ValuesUpdateSchema, { layoutRevision: 1n, values: [value], ageMs: [0n] }), 1000);
    act(paintChannels);
  };
  it('are those of the channel again after an answer of a movement was lost', async () => {
    valuesOf(1);
    render(<Manual />);
    lose = true;
    pointer(await button(), 'pointerdown');
    expect(await screen.findByText(/The daemon did not answer/)).toBeTruthy();
    pointer(await button(), 'pointerup');
    valuesOf(-2);
    expect(await screen.findByText('−2.000000 mm')).toBeTruthy();
    expect(screen.queryByText('1.250000 mm')).toBeNull();
  });
  it('of a movement are hatched when no answer has followed for a second', async () => {
    render(<Manual />);
    const hold = await button();
    silent = ['holdJog'];
    vi.useFakeTimers({ toFake: ['setTimeout', 'clearTimeout'] });
    try {
      const pass = (ms: number) => act(async () => void (await vi.advanceTimersByTimeAsync(ms)));
      pointer(hold, 'pointerdown');
      await vi.waitUntil(async () => (await pass(5), screen.queryByText('1.250000 mm')));
      await pass(900);
      expect(screen.getByText('1.250000 mm').classList.contains('stale')).toBe(false);
      await pass(110); // the sign is given up 100 ms after that
      expect(screen.getByText('1.250000 mm').classList.contains('stale')).toBe(true);
      await pass(1000);
      expect(screen.getByText(/The daemon did not answer within 1 s/)).toBeTruthy();
      pointer(hold, 'pointerup');
    } finally {
      vi.useRealTimers();
    }
  });
  it('are hatched when they are stale', async () => {
    valuesOf(1);
    render(<Manual />);
    expect((await screen.findByText('1.000000 mm')).classList.contains('stale')).toBe(false);
    act(() => void (connection.value = { phase: 'lost', lastMs: 0 }));
    expect(screen.getByText('1.000000 mm').classList.contains('stale')).toBe(true);
  });
});

it('takes no motor coordinate for an optical channel, whichever robot it is of', () => {
  expect(['q1_mm', 'mn.q1_mm', 'x_mm', 'mn.x_mm', 'mn.rx_arcsec', 'level_pct', 'level_y_pct', 'support_power_pct', 'mn.t01_degC'].filter(isOptical)).toEqual(['x_mm', 'mn.x_mm', 'mn.rx_arcsec', 'level_pct', 'level_y_pct']);
});

describe('a held button', () => {
  it('begins a movement, signs while it is down, and ends it when it is let go', async () => {
    render(<Manual />);
    pointer(await button(), 'pointerdown');
    await vi.waitFor(() => expect(begun).toHaveBeenCalledWith('q1_mm', 0.001, true));
    await vi.waitFor(() => expect(signs.mock.calls.length).toBeGreaterThan(1));
    expect(ended).not.toHaveBeenCalled();
    pointer(await button(), 'pointerup');
    await vi.waitFor(() => expect(ended).toHaveBeenCalled());
    const then = signs.mock.calls.length;
    await new Promise((done) => setTimeout(done, 250));
    expect(signs.mock.calls.length).toBeLessThanOrEqual(then + 1);
    expect(await screen.findByText('3 steps: let go')).toBeTruthy();
  });
  it('ends when the window loses the focus, and when the page goes away', async () => {
    const { unmount } = render(<Manual />);
    pointer(await button(), 'pointerdown');
    await vi.waitFor(() => expect(begun).toHaveBeenCalledTimes(1));
    fireEvent.blur(window);
    await vi.waitFor(() => expect(ended).toHaveBeenCalled());
    await screen.findByText('3 steps: let go');
    fireEvent.keyDown(await button(), { key: ' ' });
    await vi.waitFor(() => expect(begun).toHaveBeenCalledTimes(2));
    const before = ended.mock.calls.length;
    unmount();
    await vi.waitFor(() => expect(ended.mock.calls.length).toBeGreaterThan(before));
  });
  it.each(['takeLease', 'beginJog', 'holdJog'])('is given up when %s is not answered within a second, and moves again after that', async (call) => {
    silent = [call];
    render(<Manual />);
    pointer(await button(), 'pointerdown');
    expect(await screen.findByText(/The daemon did not answer within 1 s/, {}, { timeout: 4000 })).toBeTruthy();
    pointer(await button(), 'pointerup');
    silent = [];
    const before = signs.mock.calls.length;
    pointer(await button(), 'pointerdown');
    await vi.waitFor(() => expect(signs.mock.calls.length).toBeGreaterThan(before));
    expect(screen.queryByText(/The daemon did not answer/)).toBeNull();
    pointer(await button(), 'pointerup');
    expect(await screen.findByText('3 steps: let go')).toBeTruthy();
  });
  it.each([[3_000, '3 steps: let go'], [30_000, /The daemon did not answer within 10 s/]])('waits at most 10 s for an axis that rests after %i ms', async (ms, words) => {
    restsAfter_ms = ms;
    render(<Manual />);
    const hold = await button();
    vi.useFakeTimers({ toFake: ['setTimeout', 'clearTimeout'] });
    try {
      const pass = (ms: number) => act(async () => void (await vi.advanceTimersByTimeAsync(ms)));
      pointer(hold, 'pointerdown');
      await vi.waitUntil(async () => (await pass(5), signs.mock.calls.length > 0));
      pointer(hold, 'pointerup');
      for (let second = 0; second < 11; second++) await pass(1000);
      expect(screen.getByText(words)).toBeTruthy();
    } finally {
      vi.useRealTimers();
      restsAfter_ms = 0;
    }
  });
  it('says so when it is pressed again before the last movement was answered', async () => {
    silent = ['holdJog'];
    render(<Manual />);
    pointer(await button(), 'pointerdown');
    await vi.waitFor(() => expect(signs).toHaveBeenCalled());
    pointer(await button(), 'pointerup');
    pointer(await button(), 'pointerdown');
    expect(await screen.findByText('The last movement has not been answered yet.')).toBeTruthy();
    expect(begun).toHaveBeenCalledTimes(1);
    await screen.findByText(/The daemon did not answer within 1 s/, {}, { timeout: 4000 });
    expect(screen.queryByText(/has not been answered yet/)).toBeNull();
  });
  it('does nothing while the page is not live', async () => {
    connection.value = { phase: 'lost', sinceMs: 0 } as never;
    render(<Manual />);
    pointer(await button(), 'pointerdown');
    await new Promise((done) => setTimeout(done, 50));
    expect(begun).not.toHaveBeenCalled();
  });
});

describe('commissioning', () => {
  it('shows what was asked, found and expected, and what to do', async () => {
    render(<Commissioning />);
    fireEvent.click(await screen.findByRole('button', { name: 'Check the cell' }));
    const table = within(await screen.findByRole('table', { name: 'What was asked of each device' }));
    expect(table.getByText('12 %')).toBeTruthy();
    expect(table.getByText('at least 30 %')).toBeTruthy();
    expect(table.getByText('align beam and mirror')).toBeTruthy();
    expect(await screen.findByText('warm since 03:10')).toBeTruthy();
    expect(await screen.findByText('40 days overdue')).toBeTruthy();
    expect(screen.getByText('None declared for scanner.')).toBeTruthy();
  });
});

describe('looking back', () => {
  it('reads runs as a person types them', () => {
    expect(runsTyped('3, 4 4')).toEqual([3n, 4n]);
    expect(runsTyped('')).toEqual([]);
    expect(runsTyped('3, x')).toBeUndefined();
  });
  it('lays runs over each other, one colour per run', () => {
    const run = (runId: bigint) => ({ runId, zero: [{ name: 'x', unit: 'nm', hours: [0, 1], values: [0, 5] }, { name: 'y', unit: 'nm', hours: [0, 1], values: [0, 6] }] });
    const [spec, ...others] = overlays('Drift of the zero', [run(3n), run(4n)] as never, (one) => one.zero, 'none');
    expect(others).toEqual([]);
    expect(spec.series.map((one) => one.name)).toEqual(['run 3 x', 'run 3 y', 'run 4 x', 'run 4 y']);
    expect(new Set(spec.series.map((one) => one.colour)).size).toBe(2);
    expect(spec.series[1].dash).toBeDefined();
  });
});

describe('receivers of alarms', () => {
  it('says which one gets nothing, and what it said', async () => {
    render(<Receivers />);
    expect(await screen.findByText(/nothing arrives since .*HTTP 503/)).toBeTruthy();
    expect(screen.getByText('HTTP 503 (3 tries)')).toBeTruthy();
    expect(screen.getByRole('button', { name: 'Send a test message to duty' })).toBeTruthy();
  });
});

describe('the band of a stabiliser', () => {
  it('is the setting of the cell, as the daemon has it', async () => {
    expect(settledK('support')).toBe(0.01);
    await vi.waitFor(() => expect(settledK('support')).toBe(0.02));
  });
});
