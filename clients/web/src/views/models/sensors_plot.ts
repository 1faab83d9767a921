// A90 against the number of thermometers, per output and over all; the limit is what fewer may cost.
import type { SensorSet } from '@/api/gen/driftwise/v1/model_service_pb';
import type { Colour, PlotSeries, PlotSpec } from '@/plot/spec';

const farthest = 4; // times the least error: beyond, a set is in the table only
const colours: readonly Colour[] = ['q1', 'q2', 'q3', 's4', 's5'];

export function sensorsSpec(best: readonly SensorSet[], recommended: number, tolerance: number, unit: string): PlotSpec {
  const sized = [...best].sort((a, b) => a.sensors.length - b.sensors.length);
  const least = Math.min(...sized.map((set) => set.a90BlocksRms));
  // Without any thermometer the error may be thirty times as large: drawn, it would hide what the others differ by.
  const sets = sized.filter((set) => set.a90BlocksRms <= farthest * least);
  const beyond = sized.filter((set) => !sets.includes(set)).map((set) => set.sensors.length);
  const x = sets.map((set) => set.sensors.length);
  const outputs = sets[0]?.outputs ?? [];
  const suffices = best[recommended];
  const series: PlotSeries[] = [
    ...outputs.slice(0, colours.length).map((one, at) => ({ name: one.output, unit, colour: colours[at], x, y: sets.map((set) => set.outputs[at]?.a90Blocks ?? NaN), digits: 1 })),
    { name: 'all outputs', unit, colour: 's6', x, y: sets.map((set) => set.a90BlocksRms), digits: 1 },
    { name: 'best set of a size', unit, colour: 's6', x, y: sets.map((set) => set.a90BlocksRms), draw: 'markers', marker: 'dot', digits: 1 },
    ...(suffices ? [{ name: 'suffices', unit, colour: 's6' as const, x: [suffices.sensors.length], y: [suffices.a90BlocksRms], draw: 'markers' as const, marker: 'calibration' as const, digits: 1 }] : []),
  ];
  return {
    title: 'What each fewer costs', what: `A90 on blocks of time, ${unit}, against the number of thermometers`,
    x: { label: 'thermometers', unit: '1', whole: true }, y: { unit },
    ...(beyond.length > 0 ? { note: `beyond the picture: ${beyond.join(' and ')} ${beyond.length === 1 && beyond[0] === 1 ? 'thermometer' : 'thermometers'}` } : {}), series, file: 'thermometers',
    ...(Number.isFinite(least) ? { limits: [{ at: least * (1 + tolerance), label: `${Math.round(100 * tolerance)} % above the best` }] } : { why: 'No set could be judged.' }),
  };
}
