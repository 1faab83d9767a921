// Plots of many channels, and the marks in every plot over time.
import { fireEvent, render, screen } from '@testing-library/preact';
import { describe, expect, it, vi } from 'vitest';
import { forceMarks, forceSteps } from '@/parts/time_marks';
import { deviationFromStart, lookOf } from '@/plot/many';
import { TimeMarks, withTimeMarks, type TimeMark } from '@/plot/marks';
import { Plot } from '@/plot/plot';
import { residualSpecs } from '@/plot/residual_specs';
import type { PlotSpec } from '@/plot/spec';
import { svgOf } from '@/plot/svg';
import { csvOf } from '@/plot/values';
import { readReport } from '@/report/data';
import { ReportPage } from '@/report/page';
import { temperatureSpec } from '@/report/specs';
import { sampleReport } from '../report/sample';

vi.mock('@/plot/draw', async (real) => ({ ...(await real<object>()), makePlot: () => ({ destroy: () => undefined, over: document.createElement('div') }), redraw: () => undefined }));
vi.mock('@/poses/poses', () => ({ Poses: () => null })); // no canvas in jsdom
vi.setConfig({ testTimeout: 30_000 }); // a busy machine

const startMs = Date.UTC(2026, 4, 15);
const many: PlotSpec = {
  title: 'Temperatures', what: '°C against hours since start', x: { label: 'time_h', unit: 'h', startMs }, y: { unit: 'degC', zero: false }, deviation: true,
  series: Array.from({ length: 10 }, (_, i) => ({ name: `t${i}`, unit: 'degC', ...lookOf(i), quiet: true, x: [0, 1, 2], y: [NaN, 20 + i, 20 + i + 0.1 * i] })),
};
const marks: TimeMark[] = [
  { atMs: startMs + 0.5 * 3600e3, kind: 'force', label: 'force 0 to 0.768 N' },
  { atMs: startMs + 1.0 * 3600e3, kind: 'stop', label: 'Anna stopped everything' },
  { atMs: startMs + 1.5 * 3600e3, kind: 'restart', label: 'a restarted daemon went on' },
  { atMs: startMs + 9.0 * 3600e3, kind: 'stop', label: 'long after' },
];

describe('plots of many channels', () => {
  it('give 24 channels a look of their own, in the key and in print', () => {
    const looks = Array.from({ length: 24 }, (_, i) => JSON.stringify(lookOf(i)));
    expect(new Set(looks).size).toBe(24);
    const svg = new DOMParser().parseFromString(svgOf(many, { from: 0, to: 2 }, 400, 300), 'image/svg+xml');
    expect(svg.querySelector('parsererror')).toBeNull();
    const texts = [...svg.querySelectorAll('text')].map((one) => one.textContent);
    for (const one of many.series) expect(texts).toContain(one.name);
    const lines = [...svg.querySelectorAll('path[stroke-linejoin]')].map((one) => `${one.getAttribute('stroke')} ${one.getAttribute('stroke-dasharray')}`);
    expect(new Set(lines).size).toBe(10);
  });
  it('are deviations from the start, and values when asked', () => {
    const spec = deviationFromStart(many);
    expect(spec.series[7].y[1]).toBe(0);
    expect(spec.series[7].y[2]).toBeCloseTo(0.7);
    expect(spec.series[7].unit).toBe('K');
    render(<Plot spec={many} />);
    expect(screen.getByText(/deviation from the start, K; against hours/)).toBeTruthy();
    expect(document.querySelectorAll('.legend-entry svg')).toHaveLength(10);
    fireEvent.click(screen.getByRole('button', { name: 'Deviation from the start' }));
    expect(screen.getByText('°C against hours since start')).toBeTruthy();
  });
  it('have one start, the first instant that all of them reach', () => {
    const late = { ...many, series: [{ ...many.series[0], x: [0, 1, 2, 3], y: [20, 21, 22, 23] }, { ...many.series[1], x: [2, 3], y: [30, 30.5] }] };
    const spec = deviationFromStart(late);
    expect(spec.series[0].y).toEqual([-2, -1, 0, 1]);
    expect(spec.series[1].y).toEqual([0, 0.5]);
    expect(spec.what).toContain('deviation from 2.000');
  });
  it('are so in a report', () => {
    const written = sampleReport();
    const t07 = written.points.columns.find((one) => one.channel === 't07_degC')!;
    written.points.columns.push(...Array.from({ length: 8 }, (_, i) => ({ ...t07, channel: `t1${i}_degC` })));
    const spec = temperatureSpec(readReport(JSON.stringify(written)));
    expect(spec.deviation).toBe(true);
    expect(new Set(spec.series.map((one) => JSON.stringify([one.colour, one.dash]))).size).toBe(9);
  });
});

describe('marks over time', () => {
  it('stand in every plot over time, in its key, its picture and its CSV', () => {
    render(<TimeMarks.Provider value={marks}><Plot spec={many} /><Plot spec={{ ...many, x: { label: 'x_mm', unit: 'mm' } }} /></TimeMarks.Provider>);
    for (const words of ['1 change of force', '1 stop or pause', '1 restart']) expect(screen.getAllByText(words)).toHaveLength(1); // not in the one against x
    const spec = withTimeMarks(many, marks);
    const svg = new DOMParser().parseFromString(svgOf(spec, { from: 0, to: 2 }, 600, 300), 'image/svg+xml');
    expect(svg.querySelector('path.mark-stop title')!.textContent).toBe('Anna stopped everything');
    expect(svg.querySelectorAll('path.mark-force, path.mark-restart')).toHaveLength(2);
    expect(csvOf(spec, 'here')).toContain('# mark: 1 h, stop: Anna stopped everything\n');
  });
  it('find changes of force, not the noise of the load cell', () => {
    expect(forceSteps([0, 0.002, 0.001, 0.768, 0.77, NaN, 0.769, 0])).toEqual([{ index: 3, label: 'force 0.001 to 0.768 N' }, { index: 7, label: 'force 0.769 to 0 N' }]);
    expect(forceSteps([0.001, 0.003, 0, 0.002])).toEqual([]);
    expect(forceMarks([0, 1], [0, 5])).toEqual([{ at: 1, kind: 'force', label: 'force 0 to 5 N' }]);
  });
  it('are in the plots of a report, from its points and its record', () => {
    const written = sampleReport();
    written.events.push({ time: '2026-11-20T18:00:00Z', who: 'anna', what: 'run.pause', detail: 'anna paused run 17' }, { time: '2026-11-20T18:10:00Z', who: 'anna', what: 'run.resume', detail: 'anna resumed run 17' });
    render(<ReportPage report={readReport(JSON.stringify(written))} />);
    const plots = document.querySelectorAll('figure.plot').length;
    expect(plots).toBe(4);
    for (const words of ['1 change of force', '1 stop or pause', '1 resume']) expect(screen.getAllByText(words)).toHaveLength(plots);
  });
  it('are in residuals over time, where the rows hold a force', () => {
    const specs = residualSpecs({
      timeS: [0, 3600, 7200], validation: [false, false, true], excluded: [false, false, false],
      variables: [{ symbol: 'force', unit: 'N', values: [0, 0, 0.768] }], outputs: [{ output: 'q1', values: [1, 2, 3] }],
    }, 'q1', 'nm', 5, 'model-1');
    expect(specs[0].marks).toEqual([{ at: 2, kind: 'force', label: 'force 0 to 0.768 N' }]);
    expect(specs[1].marks).toBeUndefined();
  });
});
