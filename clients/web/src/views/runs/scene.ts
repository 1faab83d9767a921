// The measured poses of a run as a 3-D picture, coloured by spread; undefined where there are fewer than two lengths.
import { PointSet } from '@/api/gen/driftwise/v1/run_pb';
import { mmFrom, ofOneRobot, splitChannel } from '@/format/units';
import { valueOf, type RunPoints } from '@/live/points';
import { lengthsOf } from '@/parts/zero_plot';
import type { Axis, PoseScene } from '@/poses/pose';

export function sceneOfPoints({ points, attempts }: RunPoints): PoseScene | undefined {
  const lengths = ofOneRobot(lengthsOf(points[0]?.values.map((one) => one.channel) ?? [])).slice(0, 3);
  if (lengths.length < 2 || points.length === 0) return undefined;
  const spread = new Map(attempts.filter((one) => one.spreadNm !== undefined).map((one) => [Number(one.row), one.spreadNm!]));
  const at = lengths.map((channel) => points.map((point) => mmFrom(valueOf(point, channel), splitChannel(channel).unit)));
  const axes = [0, 1, 2].map((i): Axis => {
    const values = (at[i] ?? [0]).filter(Number.isFinite);
    return { name: lengths[i] ? splitChannel(lengths[i]).symbol : '', unit: 'mm', low: Math.min(...values), high: Math.max(...values) };
  });
  return {
    title: 'Measured poses',
    axes: axes as unknown as PoseScene['axes'],
    box: 'range of the poses',
    poses: points.map((point, i) => ({
      at: [at[0][i], at[1][i], at[2]?.[i] ?? 0],
      key: Number(point.row),
      set: point.zero ? 'zero' : point.set === PointSet.VALIDATION ? 'validation' : 'calibration',
      value: spread.get(Number(point.row)),
    })),
    colour: { what: 'spread', unit: 'nm', by: 'value' },
  };
}
