// A daemon in memory: answers the calls of the views from hand-built messages. Not shipped.
import { create } from '@bufbuild/protobuf';
import { Code, ConnectError, createRouterTransport, type Transport } from '@connectrpc/connect';
import { timestampOf } from '@/format/time';
import { CellService, GetStatusResponseSchema, ListDevicesResponseSchema } from '@/api/gen/driftwise/v1/cell_service_pb';
import { DiagnosisService, DiagnosisSchema, ImprovementSchema, Diagnosis_State, Improvement_State, Verdict } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { CheckFormulaResponseSchema, ListResidualsResponseSchema, ModelSchema, ModelService, Promotion_Action } from '@/api/gen/driftwise/v1/model_service_pb';
import { CheckTrajectoryResponseSchema, RunService } from '@/api/gen/driftwise/v1/run_service_pb';
import { RunSchema } from '@/api/gen/driftwise/v1/run_pb';
import { BudgetLine_Source, CorrectionPart_Source, MapTargetsResponseSchema, TargetSchema, TargetService } from '@/api/gen/driftwise/v1/target_service_pb';
import { TrajectoryService } from '@/api/gen/driftwise/v1/trajectory_service_pb';
import { WatchResponseSchema, WatchService } from '@/api/gen/driftwise/v1/watch_service_pb';
import { campaign, normal, random } from './rows';

const startMs = Date.UTC(2026, 10, 20, 16, 0, 0);
export const at = (minutes: number) => timestampOf(startMs + minutes * 60_000);
const outputs = ['q1', 'q2', 'q3'];
const rows = campaign();
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

const term = (name: string, k: number, included: boolean) => ({
  term: name, included, coefficient: (k % 2 ? -1 : 1) * 10 ** -(k / 3), standardError: 10 ** -(k / 3) / (60 - 2 * k), standardErrorSerial: 10 ** -(k / 3) / (45 - 2 * k), t: 60 - 2 * k,
  p: included ? 1e-12 * 10 ** k : 0.2 + 0.02 * k, ...(included && name !== '1' ? { contributionRms: 8e5 / 10 ** (k / 2.6), contributionMax: 2e6 / 10 ** (k / 2.6), vif: 1 + k } : {}),
  unit: name === '1' ? 'mm' : 'mm/mm', note: name === 't09' ? 'cannot be told apart from t08' : '',
});
const termNames = ['1', 'x', 'y', 'z', 'x^2', 'x:y', 'y^2', 'z^2', 'x^3', 'F', 'F^2', 't04', 't05', 't07', 't08', 't09', 't10'];

export function model(id: number) {
  return create(ModelSchema, {
    id: BigInt(id), name: id === 12 ? 'geometry, force, heat' : 'q ~ poly(x, y, z, 3)', hash: 'b5d1f0c2', formula: id === 12 ? 'q ~ poly(x, y, z, 3) + F + F^2 + t04..t10' : 'q ~ poly(x, y, z, 3)',
    select: 'stepwise', pEnter: 0.05, pRemove: 0.1, createTime: at(400 + id), createdBy: 'anna', serving: id === 12, ...(id === 12 ? { parentModelId: 11n } : {}),
    fitDuration: { seconds: 0n, nanos: 5_400_000 }, warnings: ['p-values after selection are not error probabilities: trust the held-out figures'],
    lineage: { runIds: [17n], source: 'run 17', datasetHash: '9f31aa', calibrationRowCount: 756n, validationRowCount: 300n },
    domain: [...['x', 'y', 'z'].map((symbol) => ({ channel: `${symbol}_mm`, min: -1.1, max: 1.1 })), { channel: 'force_N', min: 0, max: 2.305 }, { channel: 't07_degC', min: 21.2, max: 22.9 }],
    outputs: outputs.map((q, k) => ({
      channel: `${q}_mm`, unit: 'mm', summaryUnit: 'nm', dof: 740,
      accuracy: { rmse: 21 + k, u90Calibration: 36 + 2 * k, u90Validation: 43 + 3 * k, u90Blocks: 45 + 2 * k, u90BlocksLow: 39, u90BlocksHigh: 54, pureError: 16 },
      terms: termNames.map((name, i) => term(name, i, i < 13)),
      history: [{ step: 0, action: 'start', rmse: 812000, dof: 755 }, ...termNames.slice(1, 13).map((name, i) => ({ step: i + 1, action: i === 9 ? 'remove' : 'enter', term: name, p: 10 ** (i - 14), rmse: 400000 / 2.3 ** i + 21, dof: 754 - i }))],
    })),
  });
}

export function diagnosis(id: number, state = Diagnosis_State.DONE) {
  const curve = Array.from({ length: 41 }, (_, i) => 1500 + 16.5 * i);
  return create(DiagnosisSchema, {
    id: BigInt(id), state, createTime: at(480), createdBy: 'anna', runIds: [17n], modelId: 11n, baselineFormula: 'q ~ poly(x, y, z, 3) + F + F^2', extendedFormula: 'q ~ poly(x, y, z, 3) + F + F^2 + lag(t07, 1830 s)',
    verdict: Verdict.EXTENDED,
    outputs: outputs.map((q, k) => ({
      output: q, unit: 'nm', u90: 164 - 30 * k, noiseFloor: 26, u90CalibrationBefore: 158, u90CalibrationAfter: 41, u90ValidationBefore: 164 - 30 * k, u90ValidationAfter: 43,
      explainedBy: [['t07', 0.62], ['time', 0.5], ['t06', 0.31], ['q2 direction', 0.21], ['x', 0.03], ['force', 0.01]].map(([variable, marginalShare]) => ({ variable: String(variable), marginalShare: Number(marginalShare) })),
    })),
    findings: [
      { number: 1, cause: 'thermal_lag', appliesTo: 'robot', where: 'robot', subject: 't07', pAdjusted: 4e-7, logLikelihoodRatio: 412, terms: ['lag(t07, 1830 s)'], sentence: 'The robot follows thermometer t07 with a delay of 30 min.',
        parameters: [{ name: 'tau_s', value: 1830, ci90: { low: 1740, high: 1925 }, curveValue: curve, curve2lnl: curve.map((tau) => ((tau - 1830) / 56) ** 2) }],
        outputs: outputs.map((q, k) => ({ output: q, unit: 'nm', amplitude: 84 - 20 * k, u90Before: 164 - 30 * k, u90After: 61, u90AfterCi90: { low: 55, high: 68 }, shown: k < 2 })) },
      { number: 2, cause: 'backlash', appliesTo: 'robot', where: 'robot', subject: 'q2', pAdjusted: 0.0004, logLikelihoodRatio: 31, terms: ['play(q2, 85 nm)'], indistinguishableFrom: ['creep'], sentence: 'Axis q2 has a play of 85 nm: it matters from which side a point is approached.',
        parameters: [{ name: 'width_nm', value: 85, ci90: { low: 78, high: 91 } }], outputs: [{ output: 'q2', unit: 'nm', amplitude: 38, u90Before: 61, u90After: 43, shown: true }] },
    ],
    notTestable: [{ cause: 'abbe_offset', why: 'no tilt channel' }, { cause: 'refractive_index', why: 'no pressure or humidity was recorded' }],
    separatingExperiment: { why: 'A pause of 20 min after each approach separates play from creep.', predictedPower: 0.97, trajectoryText: 'q1_mm,q2_mm,q3_mm,set\n0,0,0,calibration\n1,1,1,calibration\n', estimatedS: 7300 },
  });
}

const status = () => create(GetStatusResponseSchema, { cellName: 'micro-nano', version: '0.1.0', cellTime: at(500), speed: 1, servingModelId: 12n });
const text = ['# driftwise-trajectory: 1', 'q1_mm,q2_mm,q3_mm,set,line,zero,force_N',
  ...Array.from({ length: 240 }, (_, i) => (i % 12 === 0 ? `0,0,0,calibration,${Math.floor(i / 12) + 1},1,0` : `${((i % 12) - 1) / 4.4},${(Math.floor(i / 12) % 5) / 2},${Math.floor(i / 60) / 1.5},${i % 7 === 3 ? 'validation' : 'calibration'},${Math.floor(i / 12) + 1},0,${i < 120 ? 0 : 0.768}`))].join('\n') + '\n';
export const trajectory = { id: 3n, name: 'published.csv', text, rowCount: 240n, createdBy: 'anna', createTime: at(2) };

export function target(x = 0.2) {
  return create(TargetSchema, {
    modelId: 12n, conditionsTime: timestampOf(startMs + Date.now() % 3_600_000), validUntilTime: at(510),
    coordinates: outputs.map((q, k) => ({
      channel: `${q}_mm`, positionMm: x - 12.69e-6 * (k + 1), uNm: 26, u90Nm: 43, correctionNm: -12.69 * (k + 1) + Math.sin(Date.now() / 9000 + k),
      parts: [{ source: CorrectionPart_Source.GEOMETRY, nm: -220.4 + 40 * k }, { source: CorrectionPart_Source.FORCE, nm: 160.2 - 20 * k }, { source: CorrectionPart_Source.TEMPERATURES, nm: 47.5 }],
      budget: [[BudgetLine_Source.FIT, 4], [BudgetLine_Source.RESIDUAL, 21], [BudgetLine_Source.TEMPERATURES, 12], [BudgetLine_Source.LASER, 8], [BudgetLine_Source.SCALE, 2.1]].map(([source, uNm]) => ({ source, uNm })),
    })),
  });
}

export interface FakeWishes {
  problem?: (formula: string) => string; // what CheckFormula says of it
  noModel?: boolean;
}

export function fakeDaemon(wishes: FakeWishes = {}): Transport {
  return createRouterTransport(({ service }) => {
    service(CellService, {
      getStatus: () => (wishes.noModel ? create(GetStatusResponseSchema, { cellName: 'micro-nano' }) : status()),
      listDevices: () => create(ListDevicesResponseSchema, { devices: [{ id: 'robot', axes: outputs.map((q) => ({ channel: `${q}_mm`, minMm: -0.2, maxMm: 2.8 })) }] }),
    });
    service(RunService, {
      listRuns: () => ({ runs: [create(RunSchema, { id: 17n, name: 'weekend', state: 5, acceptedCount: 1056n, startTime: at(4) })] }),
      checkTrajectory: () => create(CheckTrajectoryResponseSchema, {
        rowCount: 240n, calibrationCount: 206n, validationCount: 34n, zeroCount: 20n, lineCount: 20n, coordinates: outputs.map((q) => `${q}_mm`), estimatedDuration: { seconds: 19_400n },
        warnings: ['force rises with time (correlation 0.87 over the calibration rows): a fit could not tell it from a drift'],
      }),
    });
    service(ModelService, {
      listModels: () => ({ models: [model(11), model(12)] }),
      listPromotions: () => ({ promotions: [{ modelId: 11n, promoteTime: at(430), promotedBy: 'anna', action: Promotion_Action.PROMOTE }, { modelId: 12n, promoteTime: at(450), promotedBy: 'anna', action: Promotion_Action.PROMOTE }] }),
      getModel: ({ modelId }) => ({ model: model(Number(modelId)), budgets: [{ place: 'centre', pose: [{ channel: 'x_mm', value: 0 }], coordinates: target(0).coordinates }], declared: [{ deviceId: 'laser-x', channel: 'x_mm', name: 'u_length_nm', value: 4.6 }] }),
      compareModels: ({ modelIds }) => ({
        models: modelIds.map((id) => model(Number(id))),
        rows: termNames.map((name) => ({ channel: 'q1_mm', term: name, cells: modelIds.map(() => ({ offered: true, included: name !== 't09', coefficient: 0.12, standardError: 0.001, contributionRms: 30 })) })),
      }),
      checkFormula: ({ fit }) => create(CheckFormulaResponseSchema, {
        problem: wishes.problem?.(fit?.formula ?? '') ?? '', outputs, terms: termNames.slice(1), calibrationRowCount: 756n, validationRowCount: 300n, rank: 16, columnCount: 17, lookAlikes: ['t08 and t09 cannot be told apart on these rows'],
        channels: [{ symbol: 'q1', unit: 'mm' }, ...rows.variables.map(({ symbol, unit }) => ({ symbol, unit }))],
        effects: [{ name: 'lag', usage: 'lag(t, tau s)', sentence: 'the channel behind a first-order lag', cause: 'thermal_lag' }, { name: 'rate', usage: 'rate(t, tau s)', sentence: 'its smoothed derivative', cause: 'thermal_rate' }],
      }),
      listResiduals: () => create(ListResidualsResponseSchema, {
        timeS: rows.timeS, validation: rows.validation, excluded: rows.validation.map(() => false), line: rows.line, variables: rows.variables,
        outputs: outputs.map((output, k) => ({ output, unit: 'nm', values: afterNm[k] })), rowCount: BigInt(rows.timeS.length), rowStep: 1n, sameRows: true,
      }),
    });
    service(DiagnosisService, {
      listDiagnoses: () => ({ diagnoses: [diagnosis(9)] }),
      getDiagnosis: ({ diagnosisId }) => ({
        diagnosis: diagnosis(Number(diagnosisId)),
        rows: { timeS: rows.timeS, validation: rows.validation, line: rows.line, variables: rows.variables, outputs: outputs.map((output, k) => ({ output, unit: 'nm', before: beforeNm[k], after: afterNm[k] })) },
      }),
      listImprovements: () => ({ improvements: [improvement()] }),
      getImprovement: () => ({ improvement: improvement() }),
    });
    service(TargetService, {
      computeTarget: ({ pose }) => {
        if (wishes.noModel) throw new ConnectError('no model serves', Code.FailedPrecondition);
        return { target: target(pose[0]?.value) };
      },
      mapTargets: ({ horizontal, vertical }) => {
        const place = (axis: typeof horizontal, i: number) => axis!.from! + ((axis!.to! - axis!.from!) * i) / (axis!.count - 1);
        const cells = Array.from({ length: horizontal!.count * vertical!.count }, (_, i) => [place(horizontal, i % horizontal!.count), place(vertical, Math.floor(i / horizontal!.count))]);
        return create(MapTargetsResponseSchema, {
          horizontal, vertical, modelId: 12n, outside: cells.map(([x, y]) => Math.abs(x) > 1.1 || Math.abs(y) > 1.1),
          planes: outputs.map((q, k) => ({ channel: `${q}_mm`, correctionNm: cells.map(([x, y]) => 300 * x * y + 90 * x - 120 * k * y * y), u90Nm: cells.map(([x, y]) => 40 + 15 * (x * x + y * y)), positionMm: [] })),
        });
      },
    });
    service(WatchService, {
      async *watch(_, context) {
        for (let n = 0; !context.signal.aborted; ++n) {
          const events = n === 0 ? [{ event: { case: 'layout' as const, value: { revision: 1n, columns: [] } } }, { event: { case: 'cell' as const, value: status() } }] : [];
          yield create(WatchResponseSchema, { cursor: `${n}`, serverTime: timestampOf(Date.now()), cellTime: at(500), events });
          await new Promise((resolve) => setTimeout(resolve, 1000));
        }
      },
      listAlarms: () => ({ alarms: [] }),
    });
    service(TrajectoryService, {
      listTrajectories: () => ({ trajectories: [{ ...trajectory, text: '' }] }),
      getTrajectory: () => ({ trajectory }),
    });
  });
}

function improvement() {
  return create(ImprovementSchema, {
    id: 2n, state: Improvement_State.DONE, reason: 'nothing beyond noise is left', trajectoryName: 'published.csv', formula: 'q ~ poly(x, y, z, 3)', createTime: at(100), endTime: at(900), createdBy: 'anna',
    turns: [1, 2, 3].map((number) => ({
      number, runIds: [BigInt(16 + number)], modelId: BigInt(10 + number), diagnosisId: BigInt(7 + number), startTime: at(100 * number), endTime: at(100 * number + 90),
      what: ['Measured 240 points, fitted the first model, and found that the robot follows t07 with a delay.', 'Extended the model; axis q2 shows a play of 85 nm.', 'Extended the model; nothing beyond noise remains.'][number - 1],
      gains: outputs.map((output, k) => ({ output, unit: 'nm', u90Before: [164, 61, 43][number - 1] - 5 * k, u90Predicted: [60, 42, 41][number - 1], u90Measured: [61, 43, 42][number - 1] - 4 * k })),
    })),
  });
}
