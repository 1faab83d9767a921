// Plots of Look back: a reason why a plot is empty hides what there is.
import { create } from '@bufbuild/protobuf';
import { expect, it } from 'vitest';
import { AnalyseStabilityResponseSchema } from '@/api/gen/driftwise/v1/look_back_service_pb';
import { allanPlot, overlay, spectrumPlot } from '@/views/lookback/specs';

it('draws what was found, and says why where nothing was', () => {
  const found = create(AnalyseStabilityResponseSchema, {
    channel: 't07_degC', unit: 'mK', allan: [{ tauS: 10, deviation: 2, low: 1, high: 3 }], spectrum: [{ frequencyHz: 0.01, density: 4 }],
  });
  expect(allanPlot(found).why).toBeUndefined();
  expect(spectrumPlot(found).why).toBeUndefined();
  const nothing = create(AnalyseStabilityResponseSchema, { channel: 't07_degC', unit: 'mK' });
  expect(allanPlot(nothing).why).toBe('Too few values.');
  expect(spectrumPlot(nothing).why).toBe('Fewer than 16 values.');
  expect(overlay('Zero', [], () => [], 'No return to zero.').why).toBe('No return to zero.');
});
