import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { PointSchema } from '@/api/gen/driftwise/v1/run_pb';
import { zeroDrift } from '@/parts/zero_plot';
import { readReport } from '@/report/data';
import { poseScene, spreads, spreadSpec, zeroSpec } from '@/report/specs';
import { storyOf } from '@/report/story';
import { sampleReport, sampleStory } from './sample';

const report = readReport(JSON.stringify(sampleReport()));

describe('the data of a report', () => {
  it('resolves a tenth of a nanometre at 10 mm, as packed', () => {
    const x = report.points.columns.find((one) => one.channel === 'x_mm')!.values;
    expect((x[12] - x[0]) * 1e6).toBeCloseTo(12, 1);
    expect(x[1]).toBeCloseTo(0.6, 9);
  });
  it('says what is wrong with other texts', () => {
    expect(() => readReport('null')).toThrow(/empty template/);
    expect(() => readReport('{"schema": "x"}')).toThrow(/schema "x"/);
    expect(() => readReport('{')).toThrow(/no JSON/);
  });
  it('is the same through the escape that keeps it inside its element', () => {
    const written = JSON.stringify(sampleReport()).replaceAll('<', '\\u003c');
    expect(written).not.toContain('<');
    expect(readReport(written).cell).toBe('micro-nano <lab>');
  });
});

describe('the story of a report', () => {
  const told = () => storyOf(readReport(JSON.stringify({ ...sampleReport(), ...sampleStory() })));
  it('tells alarms with who acknowledged them, holds, the kill, rows given up and what followed, in order of time', () => {
    const sentences = told().map((one) => one.what);
    expect(sentences).toEqual([
      'ada queued queue entry 2 "night"',
      'queue entry 2 "night" begins as run 17',
      'alarm device.lost of scanner: the scanner does not answer',
      'bob acknowledged alarm device.lost of scanner',
      'alarm device.lost of scanner is over',
      'hold room: t12_degC 20.7 above 20.5',
      'a restarted daemon went on with run 17',
      'row 9 given up: spread 40 nm',
      'run 17 of queue entry 2 "night" is done: 58 of 60 rows accepted, 1 given up',
      'queue entry 2 "night": model 3 was fitted',
    ]);
  });
  it('reads the residuals of a model as packed', () => {
    const [model] = readReport(JSON.stringify({ ...sampleReport(), ...sampleStory() })).models;
    expect(model.residuals[0].values).toEqual([1.5, -2]);
    expect(model.validation).toEqual([false, true]);
  });
  it('is told of a run without a queue too', () => {
    expect(storyOf(report).map((one) => one.what)).toEqual(['run 17 begins', 'run 17 is done']);
  });
});

describe('the plots of a report', () => {
  it('keep the sets apart and show what was measured again', () => {
    const spec = spreadSpec(report);
    expect(spec.series.map((one) => one.name)).toEqual(['calibration', 'validation', 'measured again']);
    expect(spec.limits?.[0].at).toBe(20);
    expect(spreads(report)![0]).toBeCloseTo(4);
  });
  it('count the zero from the first return of each datum, as the page does', () => {
    const spec = zeroSpec(report);
    expect(spec.series[1].y[1]).toBeCloseTo(24, 1);
    expect(spec.series[1].y[3]).toBeCloseTo(0, 1); // row 36, the first of datum 4
    expect(spec.series[1].y[4]).toBeCloseTo(24, 1);
    expect(spec.series[0].x).toHaveLength(5);
    const points = [0, 12, 24, 36, 48].map((row) => create(PointSchema, { row: BigInt(row), zero: true, datumId: row < 30 ? 3n : 4n, values: [{ channel: 'y_mm', value: row * 2e-6 }] }));
    zeroDrift(points, 0, ['y_mm']).nm[0].forEach((nm, i) => expect(spec.series[1].y[i]).toBeCloseTo(nm, 1));
  });
  it('count all returns from the first in a report that says no datum', () => {
    const older = sampleReport();
    const { datum: _, ...points } = older.points;
    expect(zeroSpec(readReport(JSON.stringify({ ...older, points }))).series[1].y[4]).toBeCloseTo(96, 1);
  });
  it('draw lengths and motors of several robots as such', () => {
    const two = sampleReport();
    two.points.columns = two.points.columns.map((one) => (/^[qxyz]\d?_mm$/.test(one.channel) ? { ...one, channel: `mn.${one.channel}` } : one));
    two.axes = two.axes.map((one) => ({ ...one, channel: `mn.${one.channel}` }));
    const both = readReport(JSON.stringify(two));
    expect(zeroSpec(both).series.map((one) => one.name)).toEqual(['mn.x', 'mn.y', 'mn.z']);
    expect(poseScene(both)!.axes.map((one) => one.name)).toEqual(['mn.q1', 'mn.q2', 'mn.q3']);
  });
  it('say why there is nothing', () => {
    const bare = sampleReport();
    bare.points.columns = [];
    const empty = readReport(JSON.stringify(bare));
    expect(spreadSpec(empty).why).toBeTruthy();
    expect(poseScene(empty)).toBeUndefined();
  });
});
