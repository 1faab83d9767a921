// Models and targets of the make-believe daemon, fitted to nothing: messages of the right shape with figures of the right size.
import { create } from '@bufbuild/protobuf';
import { ModelSchema } from '@/api/gen/driftwise/v1/model_service_pb';
import { BudgetLine_Source, CorrectionPart_Source, TargetSchema, Target_Flag } from '@/api/gen/driftwise/v1/target_service_pb';
import { timestampOf } from '@/format/time';
import { at, startMs } from './cell';

export const outputs = ['q1', 'q2', 'q3'];

const term = (name: string, k: number, included: boolean) => ({
  term: name, included, coefficient: (k % 2 ? -1 : 1) * 10 ** -(k / 3), standardError: 10 ** -(k / 3) / (60 - 2 * k), standardErrorSerial: 10 ** -(k / 3) / (45 - 2 * k), t: 60 - 2 * k,
  p: included ? 1e-12 * 10 ** k : 0.2 + 0.02 * k, ...(included && name !== '1' ? { contributionRms: 8e5 / 10 ** (k / 2.6), contributionMax: 2e6 / 10 ** (k / 2.6), vif: 1 + k } : {}),
  unit: name === '1' ? 'mm' : 'mm/mm', note: name === 't09' ? 'cannot be told apart from t08' : '',
});
export const termNames = ['1', 'x', 'y', 'z', 'x^2', 'x:y', 'y^2', 'z^2', 'x^3', 'F', 'F^2', 't04', 't05', 't07', 't08', 't09', 't10'];

export function model(id: number) {
  return create(ModelSchema, {
    id: BigInt(id), name: id === 12 ? 'geometry, force, heat' : 'q ~ poly(x, y, z, 3)', hash: 'b5d1f0c2', formula: id === 12 ? 'q ~ poly(x, y, z, 3) + F + F^2 + t04..t10' : 'q ~ poly(x, y, z, 3)',
    select: 'stepwise', pEnter: 0.05, pRemove: 0.1, createTime: at(400 + id), createdBy: 'anna', serving: id === 12, ...(id === 12 ? { parentModelId: 11n } : {}),
    fitDuration: { seconds: 0n, nanos: 5_400_000 }, warnings: ['p-values after selection are not error probabilities: trust the held-out figures'],
    lineage: { runIds: [17n], source: 'run 17', datasetHash: '9f31aa', calibrationRowCount: 756n, validationRowCount: 300n },
    domain: [...['x', 'y', 'z'].map((symbol) => ({ channel: `${symbol}_mm`, min: -1.1, max: 1.1 })), { channel: 'force_N', min: 0, max: 2.305 }, { channel: 't07_degC', min: 21.2, max: 22.9 }],
    accuracy: [{ output: 'q3', unit: 'nm', rows: 'validation', figures: { mean: 14, u90: 49, a90: 53, rowCount: 300n } }],
    outputs: outputs.map((q, k) => ({
      channel: `${q}_mm`, unit: 'mm', summaryUnit: 'nm', dof: 740,
      accuracy: { rmse: 21 + k, u90Calibration: 36 + 2 * k, u90Validation: 43 + 3 * k, u90Blocks: 45 + 2 * k, u90BlocksLow: 39, u90BlocksHigh: 54, pureError: 16,
        a90Calibration: 36 + 2 * k, meanValidation: 12 + k, a90Validation: 47 + 3 * k, meanBlocks: -4, a90Blocks: 45.5 + 2 * k, a90BlocksLow: 39.5, a90BlocksHigh: 54.5 },
      terms: termNames.map((name, i) => term(name, i, i < 13)),
      history: [{ step: 0, action: 'start', rmse: 812000, dof: 755 }, ...termNames.slice(1, 13).map((name, i) => ({ step: i + 1, action: i === 9 ? 'remove' : 'enter', term: name, p: 10 ** (i - 14), rmse: 400000 / 2.3 ** i + 21, dof: 754 - i }))],
    })),
  });
}

// A robot file as it was imported: no data, no figures.
export const geometryModel = (id: number) =>
  create(ModelSchema, {
    id: BigInt(id), name: 'arm, as in the robot file', formula: 'arm, as in the robot file', select: 'all', createTime: at(400 + id), createdBy: 'anna', lineage: { source: 'robot file' },
    kinematics: { kind: 'linear-axis', robotToml: '[kinematics]\nkind = "linear-axis"\n' }, warnings: ['imported: no data judged it'],
  });

export function target(x = 0.2) {
  const beyond = Math.abs(x) > 2; // the make-believe axes travel from -2 to 2 mm
  return create(TargetSchema, {
    flags: beyond ? [Target_Flag.OUTSIDE_LIMITS] : [], unreachableChannels: beyond ? outputs.map((q) => `${q}_mm`) : [],
    modelId: 12n, conditionsTime: timestampOf(startMs + Date.now() % 3_600_000), validUntilTime: at(510),
    coordinates: outputs.map((q, k) => ({
      channel: `${q}_mm`, positionMm: x - 12.69e-6 * (k + 1), uNm: 26, u90Nm: 43, correctionNm: -12.69 * (k + 1) + Math.sin(Date.now() / 9000 + k),
      ...(beyond ? { minMm: -2, maxMm: 2 } : {}),
      parts: [{ source: CorrectionPart_Source.GEOMETRY, nm: -220.4 + 40 * k }, { source: CorrectionPart_Source.FORCE, nm: 160.2 - 20 * k }, { source: CorrectionPart_Source.TEMPERATURES, nm: 47.5 }],
      budget: [[BudgetLine_Source.FIT, 4], [BudgetLine_Source.RESIDUAL, 21], [BudgetLine_Source.TEMPERATURES, 12], [BudgetLine_Source.LASER, 8], [BudgetLine_Source.SCALE, 2.1]].map(([source, uNm]) => ({ source, uNm })),
    })),
  });
}
