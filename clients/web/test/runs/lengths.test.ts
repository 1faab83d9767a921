// Lengths of a run's points: a file may have them in any unit of length.
import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { PointSchema } from '@/api/gen/driftwise/v1/run_pb';
import { ChannelLayoutSchema } from '@/api/gen/driftwise/v1/watch_service_pb';
import { takeLayout } from '@/live/channels';
import { airOf, lengthsOf, zeroDrift, zeroPlot } from '@/parts/zero_plot';
import { kindOf } from '@/format/units';
import { trajectoryRows } from '@/trajectory/parse';
import { sceneOfPoints } from '@/views/runs/scene';
import { at } from '../fake/cell';

test('lengths in any unit are compared in nm and drawn in mm', () => {
  const of = (unit: string, value: number) => [0, value].map((x, row) => create(PointSchema, { row: BigInt(row), zero: true, measureTime: at(row), values: ['x', 'y'].map((name) => ({ channel: `${name}_${unit}`, value: x })) }));
  for (const [unit, value] of [['m', 9e-7], ['mm', 9e-4], ['um', 0.9], ['nm', 900]] as const) {
    expect(zeroDrift(of(unit, value), 0, [`x_${unit}`]).nm[0][1]).toBeCloseTo(900, 6);
    expect(sceneOfPoints({ points: of(unit, value), passages: [], attempts: [] })!.axes[0].high).toBeCloseTo(9e-4, 12);
  }
});

test('motor coordinates, commands and spreads are no lengths of the pose', () => {
  expect(lengthsOf(['q1_um', 'x_um', 'x_std_nm', 't07_K'])).toEqual(['x_um']);
  expect(lengthsOf(['q1_nm', 'q1_cmd_mm', 'height_nm', 'height_std_nm'])).toEqual(['height_nm']);
});

test('a channel is a motor, a pose or a tilt behind the id of its robot', () => {
  const two = ['mn.q1_mm', 'mn.q2_mm', 'ma.q1_mm', 'ma.x_mm', 'ma.z_mm', 'mn.x_mm', 'mn.y_mm', 'mn.z_mm', 'mn.x_std_nm', 'mn.rx_arcsec', 't04_degC'];
  expect(two.map(kindOf)).toEqual(['motor', 'motor', 'motor', 'pose', 'pose', 'pose', 'pose', 'pose', undefined, 'tilt', undefined]);
  expect(lengthsOf(two)).toEqual(['ma.x_mm', 'ma.z_mm', 'mn.x_mm', 'mn.y_mm', 'mn.z_mm']);
  const points = [0, 1].map((row) => create(PointSchema, { row: BigInt(row), values: two.map((channel) => ({ channel, value: row })) }));
  expect(sceneOfPoints({ points, passages: [], attempts: [] })!.axes.map((axis) => axis.name)).toEqual(['mn.x', 'mn.y', 'mn.z']);
  expect(trajectoryRows('mn.q1_mm,ma.q1_mm,set\n0.5,1.5,calibration\n').rows[0].at).toEqual([0.5, 1.5]);
  expect(trajectoryRows('mn.x_mm,mn.rx_arcsec,set\n0.5,1.5,calibration\n').coordinates).toEqual(['mn.x_mm']);
});

test('points without a length say so in place of an empty drift', () => {
  const returns = [0, 1].map((row) => create(PointSchema, { row: BigInt(row), zero: true, measureTime: at(row), values: [{ channel: 'rx_arcsec', value: row }] }));
  expect(zeroPlot(zeroDrift(returns, 0, lengthsOf(['rx_arcsec'])), 0).why).toBe('No length is among the channels of its points.');
});

test('a thermometer is one of the air by its name or its declared part, and by nothing else', () => {
  takeLayout(create(ChannelLayoutSchema, { revision: 1n, columns: [{ channel: 't04_degC', part: 'robot' }, { channel: 't20_degC', part: 'air' }] }));
  expect(airOf(['t04_degC', 't20_degC'])).toBe('t20_degC');
  expect(airOf(['t04_degC', 't99_degC'])).toBeUndefined();
  expect(airOf(['t20_degC', 'air_x_degC'])).toBe('air_x_degC');
});
