// U90 against the number of thermometers, per output and over all; the limit is what fewer may cost.
import type { SensorSet } from '@/api/gen/driftwise/v1/model_service_pb';
import type { Colour, PlotSeries, PlotSpec } from '@/plot/spec';

const colours: readonly Colour[] = ['q1', 'q2', 'q3', 's4', 's5'];

export function sensorsSpec(best: readonly SensorSet[], recommended: number, tolerance: number, unit: string): PlotSpec {
  const sets = [...best].sort((a, b) => a.sensors.length - b.sensors.length);
  const x = sets.map((set) => set.sensors.length);
  const lowest = Math.min(...sets.map((set) => set.u90BlocksRms));
  const outputs = sets[0]?.outputs ?? [];
  const suffices = best[recommended];
  const series: PlotSeries[] = [
    ...outputs.slice(0, colours.length).map((one, at) => ({ name: one.output, unit, colour: colours[at], x, y: sets.map((set) => set.outputs[at]?.u90Blocks ?? NaN), digits: 1 })),
    { name: 'all outputs', unit, colour: 's6', x, y: sets.map((set) => set.u90BlocksRms), digits: 1 },
    ...(suffices ? [{ name: 'suffices', unit, colour: 's6' as const, x: [suffices.sensors.length], y: [suffices.u90BlocksRms], draw: 'markers' as const, marker: 'calibration' as const, digits: 1 }] : []),
  ];
  return {
    title: 'What each fewer costs', what: `U90 on blocks of time, ${unit}, against the number of thermometers`,
    x: { label: 'thermometers', unit: '1' }, y: { unit }, series, file: 'thermometers',
    ...(Number.isFinite(lowest) ? { limits: [{ at: lowest * (1 + tolerance), label: `${Math.round(100 * tolerance)} % above the best` }] } : { why: 'No set could be judged.' }),
  };
}
