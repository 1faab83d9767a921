import { describe, expect, it } from 'vitest';
import { aligned, nearest } from '@/plot/aligned';
import { inOrder } from '@/plot/in_order';
import { withTimeMarks } from '@/plot/marks';
import { gapsOf, wholeRange, yRange } from '@/plot/ranges';
import type { PlotSeries, PlotSpec } from '@/plot/spec';
import { svgOf } from '@/plot/svg';
import { csvOf, inWords } from '@/plot/values';

const line = (over: Partial<PlotSeries> = {}): PlotSeries => ({ name: 'q1', unit: 'nm', colour: 'q1', x: [0, 1, 2, 3], y: [1, 2, NaN, 4], ...over });
const plot = (...series: PlotSeries[]): PlotSpec => ({
  title: 'Drift of the zero', what: 'nm against hours since start', x: { label: 'time_h', unit: 'h' }, y: { unit: 'nm' }, series,
});

describe('what uPlot is given', () => {
  it('has a gap where nothing was measured', () => {
    expect(aligned(plot(line()))).toEqual([[0, 1, 2, 3], [1, 2, null, 4]]);
  });
  it('has no gap where only another series has an instant', () => {
    const data = aligned(plot(line({ y: [1, 2, 3, 4] }), line({ x: [0.5, 1], y: [7, 8] })));
    expect(data[0]).toEqual([0, 0.5, 1, 2, 3]);
    expect(data[1]).toEqual([1, undefined, 2, 3, 4]);
    expect(data[2].slice(0, 3)).toEqual([undefined, 7, 8]);
  });
  it('keeps a gap where another series has instants within it', () => {
    const data = aligned(plot(line({ x: [0, 1, 2, 3], y: [1, NaN, NaN, 4] }), line({ x: [0.5, 1.5, 2.5], y: [7, NaN, 9] })));
    expect(data[0]).toEqual([0, 0.5, 1, 1.5, 2, 2.5, 3]);
    expect(data[1]).toEqual([1, null, null, null, null, null, 4]);
    expect(data[2].slice(1, 6)).toEqual([7, null, null, null, 9]);
  });
  it('is in order of x, with the keys of the points', () => {
    const sorted = inOrder(line({ x: [3, 1, 2], y: [30, 10, 20], keys: [103, 101, 102] }));
    expect([sorted.x, sorted.y, sorted.keys]).toEqual([[1, 2, 3], [10, 20, 30], [101, 102, 103]]);
  });
});

describe('ranges', () => {
  it('always show the zero, unless zero means nothing', () => {
    const [low] = yRange(plot(line({ y: [21, 22, 21, 22] })), 'left', { from: 0, to: 3 });
    expect(low).toBe(0);
    const warm = { ...plot(line({ y: [21, 22, 21, 22] })), y: { unit: 'degC', zero: false } };
    expect(yRange(warm, 'left', { from: 0, to: 3 })[0]).toBeGreaterThan(20);
  });
  it('are symmetric for residuals and look at nothing outside the zoom', () => {
    const residuals = { ...plot(line({ y: [-5, 1, 2, 100] })), y: { unit: 'nm', symmetric: true } };
    const [low, high] = yRange(residuals, 'left', { from: 0, to: 2 });
    expect(low).toBe(-high);
    expect(high).toBeLessThan(6);
  });
  it('hold the ends of lines that cross the window', () => {
    const steep = { ...plot(line({ x: [0, 10], y: [0, 100] })), y: { unit: 'nm', zero: false } };
    const [low, high] = yRange(steep, 'left', { from: 4, to: 6 });
    expect(low).toBeLessThanOrEqual(40);
    expect(high).toBeGreaterThanOrEqual(60);
    expect(high).toBeLessThan(70);
  });
  it('span all series', () => expect(wholeRange(plot(line(), line({ x: [-2, 9], y: [0, 0] })))).toEqual({ from: -2, to: 9 }));
  it('find the gap that all lines share', () => {
    expect(gapsOf(plot(line(), line({ y: [1, NaN, NaN, 4] })))).toEqual([{ from: 1, to: 3 }]);
    expect(gapsOf(plot(line(), line({ y: [1, 2, 3, 4] })))).toEqual([]);
  });
});

it('breaks lines of points at a stop, and no line of the record', () => {
  const clocked = { ...plot(line({ y: [1, 2, 3, 4], keys: [11, 12, 13, 14], ofPoints: true }), line({ name: 'air', y: [5, 6, 7, 8] })), x: { label: 'time_h', unit: 'h', startMs: 0 } };
  const [points, record] = withTimeMarks(clocked, [{ atMs: 1.5 * 3600e3, kind: 'stop', label: 'Anna stopped everything' }]).series;
  expect([points.x, points.y, points.keys]).toEqual([[0, 1, 1.5, 2, 3], [1, 2, NaN, 3, 4], [11, 12, NaN, 13, 14]]);
  expect(record.y).toEqual([5, 6, 7, 8]);
});

describe('exports', () => {
  it('write every value of every series as CSV, empty where not measured', () => {
    const csv = csvOf(plot(line(), line({ name: 'air', unit: 'degC', x: [1, 2.5], y: [21.5, 21.25], axis: 'right' })), 'http://here/runs/17');
    expect(csv.split('\n').filter((row) => !row.startsWith('#'))).toEqual([
      'time_h,q1_nm,air_degC', '0,1,', '1,2,21.5', '2,,', '2.5,,21.25', '3,4,', '',
    ]);
    expect(csv).toContain('# source: http://here/runs/17\n');
  });
  it('write an SVG that is well-formed XML and breaks its line at the gap', () => {
    const spec = { ...plot(line(), line({ name: 'a < b & c', draw: 'markers', marker: 'validation' })), limits: [{ at: 3, label: 'limit 3 nm' }] };
    const svg = new DOMParser().parseFromString(svgOf(spec, { from: 0, to: 3 }, 600, 300), 'image/svg+xml');
    expect(svg.querySelector('parsererror')).toBeNull();
    expect(svg.querySelectorAll('use').length).toBe(3);
    const path = [...svg.querySelectorAll('path')].map((one) => one.getAttribute('d')!).find((d) => /L.*M/.test(d));
    expect(path).toBeDefined();
  });
  it('say the same in words', () => {
    expect(inWords(plot(line()), { from: 0, to: 3 })).toBe(
      'Drift of the zero, nm against hours since start. q1: 1.0 to 4.0\u00a0nm, last 4.0, change +3.0.');
  });
});

it('finds the nearest instant', () => {
  expect(nearest([0, 1, 5], 2.9)).toBe(1);
  expect(nearest([0, 1, 5], 3.1)).toBe(2);
  expect(nearest([], 1)).toBe(-1);
});
