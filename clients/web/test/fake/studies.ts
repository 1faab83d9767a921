// Studies of the make-believe daemon: a comparison of methods and a choice of thermometers, of the size the Micro-Nano gives.
import { outputs } from './models';

const methods: readonly [string, number, number, number][] = [['nominal', 3, 5060, 32], ['kinematic', 48, 750, 206], ['classic', 63, 176, 118], ['stepwise', 62, 175, 1.3]];

const parameters = [
  { name: 'arm_mm', nominal: 40, value: 40.01234, free: true, standard_error: 0.0021 },
  { name: 'plate_mm', nominal: 20, value: null, free: false, note: 'cannot be told apart from arm_mm' },
];

export function comparison(wanted: readonly string[]) {
  const chosen = methods.filter(([name]) => wanted.length === 0 || wanted.includes(name));
  const unit = 'nm';
  return {
    methods: chosen.map(([method, parameterCount, a90, milliseconds]) => ({
      method, parameterCount, fitDuration: { seconds: 0n, nanos: milliseconds * 1e6 }, warnings: method === 'kinematic' ? ['force^3 is not determined by these rows: left out'] : [],
      outputs: outputs.map((q, k) => ({ channel: `${q}_mm`, unit, parameterCount, rms: a90 / 1.645, a90Calibration: a90 / 2, a90Validation: a90 * (1 + 0.1 * k), a90Blocks: a90 * 0.6 })),
    })),
    json: JSON.stringify({
      schema: 'driftwise.comparison.v1',
      methods: chosen.map(([method, , a90]) => ({ method, outputs: Object.fromEntries(outputs.map((q) => [q, { a90_blocks_ci90_nm: [a90 * 0.5, a90 * 0.7] }])), ...(method === 'kinematic' && { kinematics: { kind: 'delta', parameters } }) })),
    }),
    table: '',
  };
}

// Thermometers t04..t10: the last three of them are worth next to nothing.
export function sensorStudy(tolerance: number) {
  const order = ['t07', 't04', 't09', 't05', 't06', 't08', 't10'];
  const a90 = [240, 131, 104, 98, 96.5, 96.2, 96, 96.4];
  const best = Array.from({ length: order.length + 1 }, (_, i) => order.length - i).map((n) => ({
    sensors: order.slice(0, n).sort(), a90BlocksRms: a90[n], a90ValidationRms: a90[n] * 1.8,
    outputs: outputs.map((output, k) => ({ output, a90Blocks: a90[n] * (0.9 + 0.1 * k), a90Validation: a90[n] * 1.8 })),
  }));
  return { best, recommended: best.findLastIndex((set) => set.a90BlocksRms <= (1 + tolerance) * 96), triedSetCount: 128n, tolerance, unit: 'nm' };
}
