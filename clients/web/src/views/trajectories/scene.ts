// A trajectory as a picture: in 3-D where it has two coordinates or more, else position against order.
import type { PlotSeries, PlotSpec } from '@/plot/spec';
import type { Axis, PoseScene } from '@/poses/pose';
import type { SoftLimit } from '@/trajectory/limits';
import { posesOf, rangesOf, type TrajectoryRows } from '@/trajectory/parse';

export function sceneOf(of: TrajectoryRows, limits: readonly SoftLimit[], title: string): PoseScene {
  const ranges = rangesOf(of);
  const limited = ranges.length > 0 && ranges.every((range) => limits.some((limit) => limit.channel === range.channel));
  const axes = [0, 1, 2].map((i): Axis => {
    const range = ranges[i];
    if (!range) return { name: '', unit: 'mm', low: 0, high: 0 };
    const limit = limits.find((one) => one.channel === range.channel);
    return { name: range.symbol, unit: 'mm', low: limited && limit ? limit.min : range.low, high: limited && limit ? limit.max : range.high };
  });
  return {
    title, axes: axes as unknown as PoseScene['axes'], box: limited ? 'soft limits' : 'range of the trajectory', poses: posesOf(of),
    colour: { what: 'order of visit', unit: '', by: 'order' }, path: true,
  };
}

export function lineSpec(of: TrajectoryRows, limits: readonly SoftLimit[], title: string): PlotSpec {
  const range = rangesOf(of)[0];
  const limit = limits.find((one) => one.channel === range?.channel);
  const wanted = (validation: boolean): PlotSeries => {
    const rows = of.rows.map((row, i) => ({ row, i })).filter(({ row }) => row.validation === validation);
    return {
      name: validation ? 'validation' : 'calibration', unit: 'mm', colour: validation ? 'q2' : 'q1', draw: 'markers', marker: validation ? 'validation' : 'calibration',
      x: rows.map(({ i }) => i + 1), y: rows.map(({ row }) => row.at[0]), digits: 3,
    };
  };
  return {
    title, what: `${range?.symbol ?? ''}, mm, against order of visit`, x: { label: 'order', unit: '1' },
    y: { unit: 'mm', ...(limit ? { low: limit.min, high: limit.max } : {}) },
    series: [wanted(false), wanted(true)].filter((one) => one.x.length > 0),
    limits: limit ? [{ at: limit.min, label: 'soft limit' }, { at: limit.max, label: 'soft limit' }] : [],
    file: 'trajectory', ...(of.rows.length === 0 ? { why: 'No row could be read.' } : {}),
  };
}
