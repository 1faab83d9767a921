// Plots of Look back: a reason why a plot is empty hides what there is.
import { create } from '@bufbuild/protobuf';
import { expect, it } from 'vitest';
import { AnalyseStabilityResponseSchema, ComparedRunSchema, type ComparedRun } from '@/api/gen/driftwise/v1/look_back_service_pb';
import { allanPlot, overlays, spectrumPlot } from '@/views/lookback/specs';

it('draws what was found, and says why where nothing was', () => {
  const found = create(AnalyseStabilityResponseSchema, {
    channel: 't07_degC', unit: 'mK', allan: [{ tauS: 10, deviation: 2, low: 1, high: 3 }], spectrum: [{ frequencyHz: 0.01, density: 4 }],
  });
  expect(allanPlot(found).why).toBeUndefined();
  expect(spectrumPlot(found).why).toBeUndefined();
  const nothing = create(AnalyseStabilityResponseSchema, { channel: 't07_degC', unit: 'mK' });
  expect(allanPlot(nothing).why).toBe('Too few values.');
  expect(spectrumPlot(nothing).why).toBe('Fewer than 16 values.');
  expect(overlays('Zero', [], () => [], 'No return to zero.').map((one) => one.why)).toEqual(['No return to zero.']);
});

const run = (runId: bigint, ...zero: [name: string, unit: string, last: number][]): ComparedRun =>
  create(ComparedRunSchema, { runId, zero: zero.map(([name, unit, last]) => ({ name, unit, hours: [0, 1], values: [0, last] })) });
const zeroOf = (one: ComparedRun) => one.zero;

it('gives each unit an axis of its own: 900 nm and 0.9 um are never read off one scale', () => {
  const specs = overlays('Zero', [run(13n, ['x', 'um', 0.9]), run(14n, ['x', 'nm', 900]), run(15n, ['x', 'nm', 905])], zeroOf, 'none');
  expect(specs.map((spec) => [spec.what, spec.y.unit, spec.series.map((one) => `${one.name}, ${one.unit}`)])).toEqual([
    ["µm against hours since each run's start", 'um', ['run 13 x, um']],
    ["nm against hours since each run's start", 'nm', ['run 14 x, nm', 'run 15 x, nm']],
  ]);
  expect(specs.map((spec) => spec.note)).toEqual(['not on this axis: x of run 14 is in nm, x of run 15 is in nm', 'not on this axis: x of run 13 is in µm']);
});

it('parts lengths from tilts without a word, and keeps colour of the run and dash of the quantity over both plots', () => {
  const specs = overlays('Zero', [run(3n, ['x', 'nm', 5], ['rx', 'arcsec', 1]), run(4n, ['x', 'nm', 6], ['rx', 'arcsec', 2])], zeroOf, 'none');
  expect(specs.map((spec) => [spec.y.unit, spec.series.map((one) => one.name), spec.note])).toEqual([
    ['nm', ['run 3 x', 'run 4 x'], undefined], ['arcsec', ['run 3 rx', 'run 4 rx'], undefined],
  ]);
  const [lengths, tilts] = specs;
  expect(lengths.series[1].colour).toBe(tilts.series[1].colour);
  expect([lengths.series[0].dash, tilts.series[0].dash]).toEqual([undefined, [6, 4]]);
});
