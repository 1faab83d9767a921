// What the make-believe daemon says a simulation gets wrong: rows of a campaign with a delay hidden in them, its diagnosis, and
// an improvement loop that is over.
import { create } from '@bufbuild/protobuf';
import { DiagnosisSchema, Diagnosis_State, ImprovementSchema, Improvement_State, Verdict } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { at } from './cell';
import { outputs } from './models';
import { campaign, normal, random } from './rows';

export const rows = campaign();
const noise = random(11);
const lagged = (symbol: string, tauS: number) => {
  const values = rows.variables.find((one) => one.symbol === symbol)!.values;
  let state = values[0];
  return values.map((value) => (state += (19 / tauS) * (value - state)));
};
const slow = lagged('t07', 1830);
const mean = slow.reduce((a, b) => a + b) / slow.length;
export const beforeNm = outputs.map((_, k) => slow.map((value) => (value - mean) * 180 * (1 - 0.3 * k) + 20 * normal(noise)));
export const afterNm = outputs.map(() => slow.map(() => 20 * normal(noise)));

export function diagnosis(id: number, state = Diagnosis_State.DONE) {
  const curve = Array.from({ length: 41 }, (_, i) => 1500 + 16.5 * i);
  return create(DiagnosisSchema, {
    id: BigInt(id), state, createTime: at(480), createdBy: 'anna', runIds: [17n], modelId: 11n, baselineFormula: 'q ~ poly(x, y, z, 3) + F + F^2', extendedFormula: 'q ~ poly(x, y, z, 3) + F + F^2 + lag(t07, 1830 s)',
    verdict: Verdict.EXTENDED,
    outputs: outputs.map((q, k) => ({
      output: q, unit: 'nm', u90: 164 - 30 * k, noiseFloor: 26, u90CalibrationBefore: 158, u90CalibrationAfter: 41, u90ValidationBefore: 160 - 30 * k, u90ValidationAfter: 40,
      a90: 164 - 30 * k, a90CalibrationBefore: 158, a90CalibrationAfter: 41, meanValidationBefore: 22, meanValidationAfter: -9 - k, a90ValidationBefore: 164 - 30 * k, a90ValidationAfter: 43 - k,
      explainedBy: [['t07', 0.62], ['time', 0.5], ['t06', 0.31], ['q2 direction', 0.21], ['x', 0.03], ['force', 0.01]].map(([variable, marginalShare]) => ({ variable: String(variable), marginalShare: Number(marginalShare) })),
    })),
    accuracy: [{ output: 'q1', unit: 'nm', rows: 'validation', figures: { mean: -9, u90: 40, a90: 43, rowCount: 300n }, before: { mean: 22, u90: 160, a90: 164, rowCount: 300n } }],
    findings: [
      { number: 1, cause: 'thermal_lag', appliesTo: 'robot', where: 'robot', subject: 't07', pAdjusted: 4e-7, logLikelihoodRatio: 412, terms: ['lag(t07, 1830 s)'], sentence: 'The robot follows thermometer t07 with a delay of 30 min.',
        parameters: [{ name: 'tau_s', value: 1830, ci90: { low: 1740, high: 1925 }, curveValue: curve, curve2lnl: curve.map((tau) => ((tau - 1830) / 56) ** 2) }],
        outputs: outputs.map((q, k) => ({ output: q, unit: 'nm', amplitude: 84 - 20 * k, u90Before: 160 - 30 * k, u90After: 58, meanBefore: 22, meanAfter: 11, a90Before: 164 - 30 * k, a90After: 61, a90AfterCi90: { low: 55, high: 68 }, shown: k < 2 })) },
      { number: 2, cause: 'backlash', appliesTo: 'robot', where: 'robot', subject: 'q2', pAdjusted: 0.0004, logLikelihoodRatio: 31, terms: ['play(q2, 85 nm)'], indistinguishableFrom: ['creep'], sentence: 'Axis q2 has a play of 85 nm: it matters from which side a point is approached.',
        parameters: [{ name: 'width_nm', value: 85, ci90: { low: 78, high: 91 } }], outputs: [{ output: 'q2', unit: 'nm', amplitude: 38, u90Before: 58, u90After: 40, meanBefore: 11, meanAfter: -9, a90Before: 61, a90After: 43, shown: true }] },
    ],
    notTestable: [{ cause: 'abbe_offset', why: 'no tilt channel' }, { cause: 'refractive_index', why: 'no pressure or humidity was recorded' }],
    separatingExperiment: { why: 'A pause of 20 min after each approach separates play from creep.', predictedPower: 0.97, trajectoryText: 'q1_mm,q2_mm,q3_mm,set\n0,0,0,calibration\n1,1,1,calibration\n', estimatedS: 7300 },
  });
}

export function improvement() {
  return create(ImprovementSchema, {
    id: 2n, state: Improvement_State.DONE, reason: 'nothing beyond noise is left', trajectoryName: 'published.csv', formula: 'q ~ poly(x, y, z, 3)', createTime: at(100), endTime: at(900), createdBy: 'anna',
    turns: [1, 2, 3].map((number) => ({
      number, runIds: [BigInt(16 + number)], modelId: BigInt(10 + number), diagnosisId: BigInt(7 + number), startTime: at(100 * number), endTime: at(100 * number + 90),
      what: ['Measured 240 points, fitted the first model, and found that the robot follows t07 with a delay.', 'Extended the model; axis q2 shows a play of 85 nm.', 'Extended the model; nothing beyond noise remains.'][number - 1],
      gains: outputs.map((output, k) => ({ output, unit: 'nm', before: { a90: [164, 61, 43][number - 1] - 5 * k, u90: 40, mean: 9 }, predicted: { a90: [60, 42, 41][number - 1], u90: 38, mean: 4 },
        measuredBefore: { a90: [166, 62, 44][number - 1] - 5 * k, u90: 40, mean: 12 }, measured: { a90: [61, 43, 42][number - 1] - 4 * k, u90: 39, mean: -6 } })),
    })),
  });
}
