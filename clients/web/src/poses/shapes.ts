// A scene seen by a camera, as flat shapes sorted from back to front: canvas and SVG draw the same list.
import { mix } from './colours';
import { homeCamera, projector, type Camera } from './camera';
import { colourRange, type Pose, type PoseScene } from './pose';
import { fixed } from '@/format/numbers';
import { niceStep } from '@/plot/ticks';
import type { Palette } from '@/plot/palette';

export type Shape =
  | { kind: 'line'; depth: number; x1: number; y1: number; x2: number; y2: number; colour: string; width: number; dash?: boolean }
  | { kind: 'dot' | 'diamond' | 'plus' | 'ring'; depth: number; x: number; y: number; size: number; colour: string; key: number }
  | { kind: 'text'; depth: number; x: number; y: number; text: string; colour: string; strong: boolean };

export interface Seen {
  width: number; // px
  height: number;
  upTo: number; // this many poses are visited: the rest stands back
  chosen?: number | undefined; // key
}

const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]] as const;

// Half lengths of the box in units: 1 for the longest side, true proportions unless one side would vanish.
export function proportions(scene: PoseScene): [number, number, number] {
  const sides = scene.axes.map((axis) => Math.max(axis.high - axis.low, 0));
  const longest = Math.max(...sides);
  return sides.map((side) => (longest > 0 && side >= longest / 12 ? side / longest : side > 0 ? 0.5 : 0)) as [number, number, number];
}

export function shapesOf(scene: PoseScene, camera: Camera, seen: Seen, colours: Palette): Shape[] {
  const half = proportions(scene);
  // As large as fits at the height it is first looked at from, whatever the turn.
  const across = 2 * Math.hypot(half[0], half[1]);
  const upright = 2 * half[2] * Math.cos(homeCamera.lift) + across * Math.sin(homeCamera.lift);
  const pxPerUnit = Math.min((seen.width - 130) / (across || 2), (seen.height - 60) / (upright || 2));
  const project = projector(camera, pxPerUnit);
  const [mx, my] = [seen.width / 2, seen.height / 2];
  const place = (unit: readonly number[]) => {
    const p = project(unit[0] * half[0], unit[1] * half[1], unit[2] * half[2]);
    return { x: p.x + mx, y: p.y + my, depth: p.depth };
  };
  const unitOf = (at: readonly number[]) =>
    scene.axes.map((axis, i) => (axis.high > axis.low ? (2 * (at[i] - axis.low)) / (axis.high - axis.low) - 1 : 0));
  return [
    ...boxShapes(scene, camera, place, colours),
    ...poseShapes(scene, (pose) => place(unitOf(pose.at)), seen, colours),
  ].sort((a, b) => a.depth - b.depth);
}

type Place = (unit: readonly number[]) => { x: number; y: number; depth: number };

// Twelve edges (those behind lie behind every pose, those in front are not drawn over poses), a grid on the floor, and
// along three edges the names and ends of the axes.
function boxShapes(scene: PoseScene, camera: Camera, place: Place, colours: Palette): Shape[] {
  const shapes: Shape[] = [];
  const back = -1e3;
  const line = (a: readonly number[], b: readonly number[], colour: string, width = 1) => {
    const [p, q] = [place(a), place(b)];
    shapes.push({ kind: 'line', depth: back, x1: p.x, y1: p.y, x2: q.x, y2: q.y, colour, width });
  };
  for (const axis of [0, 1] as const) {
    const { low, high } = scene.axes[axis];
    if (!(high > low)) continue;
    const step = niceStep(high - low, 5);
    for (let at = Math.ceil(low / step) * step; at <= high + step * 1e-9; at += step) {
      const u = (2 * (at - low)) / (high - low) - 1;
      line(axis === 0 ? [u, -1, -1] : [-1, u, -1], axis === 0 ? [u, 1, -1] : [1, u, -1], colours.grid);
    }
  }
  for (let i = 0; i < 4; ++i) {
    const [a, b] = [corners[i], corners[(i + 1) % 4]];
    line([...a, -1], [...b, -1], colours.line, 1.25);
    line([...a, 1], [...b, 1], colours.line);
    line([...a, -1], [...a, 1], colours.line);
  }
  shapes.push(...axisTexts(scene, camera, place, colours));
  return shapes;
}

function axisTexts(scene: PoseScene, camera: Camera, place: Place, colours: Palette): Shape[] {
  const texts: Shape[] = [];
  const away = (along: 0 | 1) => {
    // Of the two floor edges along this axis, the one nearer to the onlooker.
    const other = along === 0 ? 1 : 0;
    const at = (side: number) => place(other === 1 ? [0, side, -1] : [side, 0, -1]).depth;
    return at(1) > at(-1) ? 1 : -1;
  };
  const put = (unit: readonly number[], out: readonly number[], text: string, strong: boolean) => {
    const [p, centre] = [place(unit), place(out)];
    const [dx, dy] = [p.x - centre.x, p.y - centre.y];
    const length = Math.hypot(dx, dy) || 1;
    const far = strong ? 30 : 16;
    texts.push({ kind: 'text', depth: 1e3, x: p.x + (dx / length) * far, y: p.y + (dy / length) * far, text, colour: strong ? colours.text : colours.muted, strong });
  };
  for (const along of [0, 1] as const) {
    const axis = scene.axes[along];
    if (!(axis.high > axis.low)) continue;
    const side = away(along);
    const spot = (u: number) => (along === 0 ? [u, side, -1] : [side, u, -1]);
    const inside = (u: number) => (along === 0 ? [u, 0, -1] : [0, u, -1]);
    put(spot(0), inside(0), `${axis.name}, ${axis.unit}`, true);
    put(spot(-0.92), inside(-0.92), endText(axis.low), false);
    put(spot(0.92), inside(0.92), endText(axis.high), false);
  }
  const up = scene.axes[2];
  if (up.high > up.low && camera.lift < 1.3) {
    const leftmost = [...corners].sort((a, b) => place([...a, 0]).x - place([...b, 0]).x)[0];
    put([...leftmost, 0], [0, 0, 0], `${up.name}, ${up.unit}`, true);
    put([...leftmost, -0.95], [0, 0, -0.95], endText(up.low), false);
    put([...leftmost, 0.95], [0, 0, 0.95], endText(up.high), false);
  }
  return texts;
}

const endText = (value: number) => fixed(value, Math.abs(value) >= 100 ? 0 : Number.isInteger(value) ? 0 : 2).replace(/(\.\d)0$/, '$1');

function poseShapes(scene: PoseScene, place: (pose: Pose) => { x: number; y: number; depth: number }, seen: Seen, colours: Palette): Shape[] {
  const shapes: Shape[] = [];
  const [low, high] = colourRange(scene);
  const size = scene.poses.length > 3000 ? 2 : scene.poses.length > 400 ? 3 : 4;
  let before: { x: number; y: number; depth: number } | undefined;
  scene.poses.forEach((pose, i) => {
    const at = place(pose);
    const visited = i < seen.upTo;
    const chosen = pose.key === seen.chosen;
    if (scene.path && visited && before) {
      const newest = i === seen.upTo - 1 && seen.upTo < scene.poses.length;
      shapes.push({ kind: 'line', depth: Math.min(before.depth, at.depth) - 1e-6, x1: before.x, y1: before.y, x2: at.x, y2: at.y,
        colour: newest ? colours.text : mix(colours.panel, colours.muted, 0.35), width: newest ? 1.5 : 0.75 });
    }
    before = at;
    const value = scene.colour.by === 'order' ? i + 1 : pose.value;
    const share = value === undefined ? undefined : high > low ? (value - low) / (high - low) : 1;
    const colour = pose.set === 'rejected' ? colours.bad
      : !visited ? colours.line
      : share === undefined ? colours.idle
      : mix(mix(colours.panel, colours.q1, 0.3), colours.q1, Math.min(1, Math.max(0, share)));
    const kind = pose.set === 'validation' ? 'diamond' : pose.set === 'zero' ? 'plus' : pose.set === 'rejected' ? 'ring' : 'dot';
    shapes.push({ kind, ...at, size: kind === 'dot' ? size : size + 1, colour, key: pose.key });
    if (chosen) shapes.push({ kind: 'ring', ...at, depth: 1e4, size: size + 5, colour: colours.text, key: pose.key });
  });
  return shapes;
}

// The pose under a point of the picture, the nearest to the onlooker; within 10 px.
export function poseAt(shapes: readonly Shape[], x: number, y: number): number | undefined {
  let best: number | undefined;
  let nearest = 10;
  for (const shape of shapes) {
    if (shape.kind === 'line' || shape.kind === 'text') continue;
    const distance = Math.hypot(shape.x - x, shape.y - y);
    if (distance <= nearest) [best, nearest] = [shape.key, distance];
  }
  return best;
}
