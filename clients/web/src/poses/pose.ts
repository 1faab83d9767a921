// What a picture of poses shows. Lengths in mm; a robot of two axes has z 0 everywhere.
import type { PointSet } from './set';

export interface Pose {
  at: readonly [number, number, number]; // mm
  key: number; // row of the trajectory or of the run: what choosing it hands on
  set: PointSet;
  value?: number; // what the colour shows (spread, nm); absent: not measured
}

export interface Axis {
  name: string; // "x"
  unit: string; // "mm"
  low: number; // of the box: soft limits, or the range of the poses
  high: number;
}

export interface PoseScene {
  title: string;
  axes: readonly [Axis, Axis, Axis];
  box: string; // what the box is: "soft limits", "range of the poses"
  poses: readonly Pose[]; // in order of visit
  colour: { what: string; unit: string; by: 'order' | 'value' };
  path?: boolean; // a line joins them in order of visit
}

// Range of what the colour shows.
export function colourRange(scene: PoseScene): [number, number] {
  if (scene.colour.by === 'order') return [1, Math.max(1, scene.poses.length)];
  let low = Infinity;
  let high = -Infinity;
  for (const pose of scene.poses) {
    if (pose.value === undefined || !Number.isFinite(pose.value)) continue;
    low = Math.min(low, pose.value);
    high = Math.max(high, pose.value);
  }
  return low <= high ? [low, high] : [0, 1];
}
