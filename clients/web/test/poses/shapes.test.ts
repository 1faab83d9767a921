import { describe, expect, it } from 'vitest';
import { homeCamera, projector, turned, zoomed } from '@/poses/camera';
import type { PoseScene } from '@/poses/pose';
import { poseAt, shapesOf } from '@/poses/shapes';
import { shapesSvg } from '@/poses/svg';
import { posesCsv } from '@/poses/csv';
import { diverging, mix } from '@/poses/colours';
import { paletteOf } from '@/plot/palette';

const axis = (name: string) => ({ name, unit: 'mm', low: -1, high: 1 });
const scene: PoseScene = {
  title: 'Two poses', box: 'soft limits', axes: [axis('x'), axis('y'), axis('z')],
  poses: [
    { at: [0, -1, 0], key: 7, set: 'calibration', value: 2 },
    { at: [0, 1, 0], key: 8, set: 'validation', value: 4 },
  ],
  colour: { what: 'spread', unit: 'nm', by: 'value' }, path: true,
};
const seen = { width: 600, height: 400, upTo: 2 };
const colours = paletteOf(false);

describe('the camera', () => {
  it('looks from above at the plane of x and y, x to the right and y up', () => {
    const project = projector({ turn: 0, lift: Math.PI / 2, zoom: 1 }, 100);
    const x = project(1, 0, 0);
    const y = project(0, 1, 0);
    expect([x.x, x.y].map(Math.round)).toEqual([100, -0]);
    expect([y.x, y.y].map(Math.round)).toEqual([0, -100]);
    expect(project(0, 0, 1).depth).toBeGreaterThan(project(0, 0, -1).depth);
  });
  it('looks from the side with z up and what is nearer in front', () => {
    const project = projector({ turn: 0, lift: 0, zoom: 1 }, 100);
    expect(project(0, 0, 1).y).toBeCloseTo(-100);
    expect(project(0, -1, 0).depth).toBeGreaterThan(project(0, 1, 0).depth);
  });
  it('keeps lengths: parallel lines stay parallel whatever the turn', () => {
    const project = projector(turned(homeCamera, 1.1, 0.2), 80);
    const d1 = project(1, 1, 1).x - project(0, 1, 1).x;
    const d2 = project(1, 0, 0).x - project(0, 0, 0).x;
    expect(d1).toBeCloseTo(d2);
  });
  it('stays within what can be seen', () => {
    expect(turned(homeCamera, 0, 99).lift).toBeCloseTo(Math.PI / 2);
    expect(zoomed(homeCamera, 1e9).zoom).toBe(20);
  });
});

describe('the picture of poses', () => {
  const shapes = shapesOf(scene, homeCamera, seen, colours);
  it('draws from back to front', () => {
    const depths = shapes.map((shape) => shape.depth);
    expect(depths).toEqual([...depths].sort((a, b) => a - b));
  });
  it('marks the sets by shape, not by colour alone', () => {
    expect(shapes.filter((s) => s.kind === 'dot')).toHaveLength(1);
    expect(shapes.filter((s) => s.kind === 'diamond')).toHaveLength(1);
  });
  it('finds the pose under the pointer', () => {
    const dot = shapes.find((s) => s.kind === 'dot')!;
    if (dot.kind !== 'dot') throw new Error();
    expect(poseAt(shapes, dot.x + 3, dot.y)).toBe(7);
    expect(poseAt(shapes, dot.x + 300, dot.y)).toBeUndefined();
  });
  it('writes the very same shapes as SVG, and the poses as CSV', () => {
    const svg = shapesSvg(shapes, 600, 400, 'a < b', '#ffffff');
    expect(svg).toContain('<title>a &lt; b</title>');
    expect(svg.match(/<circle/g)).toHaveLength(1);
    expect(posesCsv(scene).split('\n')[2]).toBe('1,calibration,0,-1,0,2');
  });
  it('holds up where an axis has no extent', () => {
    const flat = { ...scene, axes: [axis('x'), axis('y'), { ...axis('z'), low: 0, high: 0 }] as PoseScene['axes'] };
    for (const shape of shapesOf(flat, homeCamera, seen, colours))
      for (const value of Object.values(shape)) if (typeof value === 'number') expect(Number.isFinite(value)).toBe(true);
  });
});

describe('colours between two', () => {
  it('is exact at the ends and symmetric about zero', () => {
    expect(mix('#000000', '#ffffff', 0)).toBe('#000000');
    expect(mix('#000000', '#ffffff', 2)).toBe('#ffffff');
    expect(diverging(0, 5, colours)).toBe(colours.panel);
    expect(diverging(-5, 5, colours)).toBe(colours.q1);
    expect(diverging(5, 5, colours)).toBe(colours.q2);
  });
});
