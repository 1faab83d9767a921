// Comparisons and stability as plots.
import type { AnalyseStabilityResponse, ComparedRun, ComparedSeries } from '@/api/gen/driftwise/v1/look_back_service_pb';
import type { Series } from '@/api/gen/driftwise/v1/watch_service_pb';
import { unitSign } from '@/format/units';
import type { Colour, PlotSeries, PlotSpec } from '@/plot/spec';

const colours: readonly Colour[] = ['q1', 'q2', 'q3', 's4', 's6', 's5', 'good', 'idle'];
const dashes: readonly (readonly number[] | undefined)[] = [undefined, [6, 4], [2, 3], [10, 3, 2, 3]];

// A plot with a reason why it is empty is not drawn.
const unless = (hasValues: boolean, why: string): { why?: string } => (hasValues ? {} : { why });

// One colour per run, one dash per quantity. One plot per unit, which is that of all its series. A note names the runs that have one
// of its quantities in another unit.
export function overlays(title: string, runs: readonly ComparedRun[], of: (run: ComparedRun) => readonly ComparedSeries[], why: string): PlotSpec[] {
  const all = runs.flatMap((run, place) => of(run).map((one) => ({ run, place, one })));
  const names = [...new Set(all.map(({ one }) => one.name))];
  const units = [...new Set(all.map(({ one }) => one.unit))];
  return (units.length > 0 ? units : ['']).map((unit) => {
    const series = all.filter(({ one }) => one.unit === unit).map(({ run, place, one }): PlotSeries => {
      const dash = dashes[names.indexOf(one.name) % dashes.length];
      return { name: `run ${run.runId} ${one.name}`, unit, colour: colours[place % colours.length], x: one.hours, y: one.values, ...(dash && { dash }) };
    });
    const here = new Set(all.filter(({ one }) => one.unit === unit).map(({ one }) => one.name));
    const apart = all.filter(({ one }) => one.unit !== unit && here.has(one.name)).map(({ run, one }) => `${one.name} of run ${run.runId} is in ${unitSign(one.unit)}`);
    return {
      title, what: `${unitSign(unit)} against hours since each run's start`, x: { label: 'time_h', unit: 'h' }, y: { unit }, series, marks: [],
      ...(apart.length > 0 && { note: `not on this axis: ${apart.join(', ')}` }),
      ...unless(series.some((one) => one.x.length > 0), why),
    };
  });
}

const log10 = (values: readonly number[]) => values.map((value) => (value > 0 ? Math.log10(value) : NaN));

export function allanPlot(found: AnalyseStabilityResponse): PlotSpec {
  return {
    title: `Allan deviation of ${found.channel}`, what: `log10 of ${found.unit} against log10 of seconds averaged`,
    x: { label: 'log10_tau_s', unit: '' }, y: { unit: '', zero: false }, marks: [],
    series: [
      {
        name: 'Allan deviation', unit: '', colour: 'q1', x: log10(found.allan.map((one) => one.tauS)), y: log10(found.allan.map((one) => one.deviation)),
        min: log10(found.allan.map((one) => one.low)), max: log10(found.allan.map((one) => one.high)), digits: 3,
      },
    ],
    ...unless(found.allan.length > 0, 'Too few values.'),
  };
}

export function spectrumPlot(found: AnalyseStabilityResponse): PlotSpec {
  return {
    title: `Spectrum of ${found.channel}`, what: `log10 of ${found.unit}²/Hz against log10 of Hz`,
    x: { label: 'log10_frequency_hz', unit: '' }, y: { unit: '', zero: false }, marks: [],
    series: [{ name: 'density', unit: '', colour: 'q2', x: log10(found.spectrum.map((one) => one.frequencyHz)), y: log10(found.spectrum.map((one) => one.density)), digits: 3 }],
    ...unless(found.spectrum.length > 0, 'Fewer than 16 values.'),
  };
}

// One channel against another, bucket by bucket, where both have a value.
export function againstPlot(x: Series, y: Series): PlotSpec {
  const pairs = Array.from({ length: Math.min(x.mean.length, y.mean.length) }, (_, i) => [x.base + x.mean[i], y.base + y.mean[i]] as const)
    .filter(([a, b]) => Number.isFinite(a) && Number.isFinite(b))
    .sort(([a], [b]) => a - b);
  return {
    title: `${y.channel} against ${x.channel}`, what: `${y.unit} against ${x.unit}`, x: { label: x.channel, unit: x.unit }, y: { unit: y.unit, zero: false }, marks: [],
    series: [{ name: y.channel, unit: y.unit, colour: 'q1', x: pairs.map(([a]) => a), y: pairs.map(([, b]) => b), draw: 'markers' }],
    ...unless(pairs.length > 0, 'The record has no instant at which both have a value.'),
  };
}
