import type { PoseScene } from './pose';

export function posesCsv(scene: PoseScene): string {
  const named = scene.colour.by === 'value' ? [`${scene.colour.what.replaceAll(' ', '_')}_${scene.colour.unit}`] : [];
  const head = ['order', 'set', ...scene.axes.map((axis) => `${axis.name}_${axis.unit}`), ...named];
  const rows = scene.poses.map((pose, i) => [i + 1, pose.set, ...pose.at, ...(named.length ? [pose.value ?? ''] : [])].join(','));
  return [`# ${scene.title}`, head.join(','), ...rows].join('\n') + '\n';
}
