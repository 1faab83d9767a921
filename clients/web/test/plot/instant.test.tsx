// An instant that is pinned in one plot stands in every other one, until it is let go.
import { fireEvent, render, screen } from '@testing-library/preact';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { InstantBar } from '@/app/instant_bar';
import type { Wishes } from '@/plot/draw';
import { pinned, pinnedX } from '@/plot/instant';
import { Plot } from '@/plot/plot';
import type { PlotSpec } from '@/plot/spec';

const made: Wishes[] = [];
vi.mock('@/plot/draw', async (real) => ({
  ...(await real<object>()),
  makePlot: (_root: unknown, _now: unknown, wishes: Wishes) => {
    made.push(wishes);
    return { destroy: () => undefined, over: document.createElement('div'), posToVal: (x: number) => x / 100, valToPos: (x: number) => x * 100 };
  },
  redraw: () => undefined,
}));
beforeEach(() => made.splice(0));
afterEach(() => pinned.value = undefined);

const startMs = Date.UTC(2026, 10, 21, 2);
const spec = (title: string, startsMs: number, y: number[]): PlotSpec => ({
  title, what: 'nm against time', x: { label: 'time_h', unit: 'h', startMs: startsMs }, y: { unit: 'nm' },
  series: [{ name: title, unit: 'nm', colour: 'q1', x: [0, 1, 2], y }],
});

describe('the pinned instant', () => {
  it('shows its values in plots with another beginning, and moves with the bar', async () => {
    // The second plot begins an hour earlier: its values of 03:00 are those of its second hour.
    const { container } = render(<><InstantBar /><Plot spec={spec('drift', startMs, [1, 2, 3])} /><Plot spec={spec('room', startMs - 3600e3, [10, 20, 30])} /></>);
    const values = () => [...container.querySelectorAll('.legend-value')].map((one) => one.textContent?.trim().replace(/\s/g, ' '));
    expect(values()).toEqual([]);
    made[0].click(100, 0); // 1 h after its start
    await vi.waitFor(() => expect(values()).toEqual(['2.0 nm', '30.0 nm']));
    expect(screen.getByRole('group', { name: 'Pinned instant' }).textContent).toContain('2026-11-21 03:00:00');
    fireEvent.input(screen.getByRole('slider'), { target: { value: '0' } });
    await vi.waitFor(() => expect(values()).toEqual(['1.0 nm', '20.0 nm']));
    fireEvent.click(screen.getByRole('button', { name: 'Let go' }));
    await vi.waitFor(() => expect(values()).toEqual([]));
  });

  it('is let go by a click on its line', async () => {
    render(<Plot spec={spec('drift', startMs, [1, 2, 3])} />);
    made[0].click(100, 0);
    await vi.waitFor(() => expect(pinned.value?.atMs).toBe(startMs + 3600e3));
    made[0].click(103, 0);
    expect(pinned.value).toBeUndefined();
  });

  it('has no place in a plot that is not against time, nor outside what is seen', () => {
    pinned.value = { atMs: startMs + 3600e3, fromMs: startMs, toMs: startMs + 2 * 3600e3 };
    expect(pinnedX(spec('drift', startMs, [1, 2, 3]), { from: 0, to: 2 })).toBe(1);
    expect(pinnedX(spec('drift', startMs, [1, 2, 3]), { from: 1.5, to: 2 })).toBeUndefined();
    const against: PlotSpec = { ...spec('drift', startMs, [1, 2, 3]), x: { label: 't07', unit: 'degC' } };
    expect(pinnedX(against, { from: 0, to: 2 })).toBeUndefined();
  });
});
