// A daemon in memory behind the real API, for unit tests and for looking at the page without one (page.html). Not shipped; the
// browser tests use the real daemon.
import { create } from '@bufbuild/protobuf';
import { DurationSchema } from '@bufbuild/protobuf/wkt';
import { Code, ConnectError, createRouterTransport, type Transport } from '@connectrpc/connect';
import { CellService, GetStatusResponseSchema, ListDevicesResponseSchema } from '@/api/gen/driftwise/v1/cell_service_pb';
import { ConfigurationService } from '@/api/gen/driftwise/v1/configuration_service_pb';
import { DataService } from '@/api/gen/driftwise/v1/data_service_pb';
import { ErrorDetailSchema } from '@/api/gen/driftwise/v1/error_detail_pb';
import { DiagnosisService } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { CheckFormulaResponseSchema, ListResidualsResponseSchema, ModelService, Promotion_Action } from '@/api/gen/driftwise/v1/model_service_pb';
import { Run_State } from '@/api/gen/driftwise/v1/run_pb';
import { CheckTrajectoryResponseSchema, RunService } from '@/api/gen/driftwise/v1/run_service_pb';
import { IndentationService } from '@/api/gen/driftwise/v1/indentation_service_pb';
import { PlanService, RobotAnswer_By } from '@/api/gen/driftwise/v1/plan_service_pb';
import { QueueEntry_State, QueueService } from '@/api/gen/driftwise/v1/queue_service_pb';
import { MapTargetsResponseSchema, TargetService } from '@/api/gen/driftwise/v1/target_service_pb';
import { ProcedureStep_State, StudyService } from '@/api/gen/driftwise/v1/study_service_pb';
import { TrajectoryService } from '@/api/gen/driftwise/v1/trajectory_service_pb';
import { WatchService, type Alarm } from '@/api/gen/driftwise/v1/watch_service_pb';
import { timestampOf } from '@/format/time';
import { at, fakeAlarm, fakeAttempts, fakeBatch, fakeNowMs, fakePoints, fakeRun, fakeStatus, fakeValue, startMs } from './cell';
import { afterNm, beforeNm, diagnosis, improvement, rows } from './diagnoses';
import { indentation, indentationRecord } from './indentation';
import { geometryModel, model, outputs, target, termNames } from './models';
import { comparison, sensorStudy } from './studies';
import table81 from './table_8_1.json';

const pause = (ms: number) => new Promise((done) => setTimeout(done, ms));
const untilLeft = async (signal: AbortSignal, tell: (ended: boolean) => void) => {
  tell(false);
  while (!signal.aborted) await pause(5);
  tell(true);
};
const text = ['# driftwise-trajectory: 1', 'q1_mm,q2_mm,q3_mm,set,line,zero,force_N',
  ...Array.from({ length: 240 }, (_, i) => (i % 12 === 0 ? `0,0,0,calibration,${Math.floor(i / 12) + 1},1,0` : `${((i % 12) - 1) / 4.4},${(Math.floor(i / 12) % 5) / 2},${Math.floor(i / 60) / 1.5},${i % 7 === 3 ? 'validation' : 'calibration'},${Math.floor(i / 12) + 1},0,${i < 120 ? 0 : 0.768}`))].join('\n') + '\n';
export const trajectory = { id: 3n, name: 'published.csv', text, rowCount: 240n, createdBy: 'anna', createTime: at(2) };

const procedureSteps = [
  { number: 0, name: 'sources of inaccuracy', state: ProcedureStep_State.DONE, found: 'considered: geometry (lengths)', missing: 'not considered: process force', command: 'driftwise devices', sources: [{ name: 'geometry (lengths)', considered: true, measuredBy: 'x_mm, y_mm, z_mm' }, { name: 'process force', considered: false }] },
  { number: 1, name: 'wanted accuracy', state: ProcedureStep_State.DONE, found: 'A90: x 100 nm, every rotation 2 arcsec, stated by run 3', figures: [{ coordinate: 'x', unit: 'nm', wantedA90: 100 }, { unit: 'arcsec', wantedA90: 2 }] },
  { number: 2, name: 'measurements', state: ProcedureStep_State.DONE, found: '1056 points in 1 run' },
  { number: 3, name: 'models', state: ProcedureStep_State.DONE, found: 'model 12: A90 q1 43.0 nm', figures: [{ coordinate: 'q1', unit: 'nm', a90: 43, wantedA90: 100 }] },
  { number: 4, name: 'validation in pose coordinates', state: ProcedureStep_State.DONE, found: 'run 17: A90 x 142.0 nm', figures: [{ coordinate: 'x', unit: 'nm', a90: 142, wantedA90: 100 }] },
  { number: 5, name: 'wanted accuracy reached', state: ProcedureStep_State.NOT_REACHED, found: 'x 142.0 nm, wanted 100', missing: 'back to step 0: other instruments or their places; largest line of the budget: beam offset 44.0 nm', command: 'driftwise design --model 12 --list', figures: [{ coordinate: 'x', unit: 'nm', a90: 142, wantedA90: 100 }], backToStep: 0, largestLine: 'beam offset', largestUNm: 44 },
];

export interface FakeWishes {
  problem?: (formula: string) => string; // what CheckFormula says of it
  noModel?: boolean;
  noForce?: boolean; // no device of the cell reads a force, and nobody stated one
  alarms?: Alarm[]; // that stand; absent: one
  moved?: (entry: bigint, before: bigint | undefined) => void; // an entry of the queue
  released?: () => void; // the queue was
  lostAt?: number; // contacts after which the client of the indentation was lost
  promoted?: (plan: bigint) => void; // a serving plan was
  planRolledBack?: () => void; // the serving plan was
  endless?: (ended: boolean) => void; // studies never end; called when one begins, and when its client left
}

export function fakeDaemon(wishes: FakeWishes = {}): Transport {
  return createRouterTransport(({ service }) => {
    service(QueueService, {
      listQueue: () => ({
        hold: { who: 'anna', why: 'stopped by anna', beginTime: at(3) },
        entries: [
          { id: 4n, state: QueueEntry_State.WAITING, name: 'night 2', trajectoryName: 'published.csv', rowCount: 240n, createdBy: 'anna', condition: 't12_degC < 20.5 degC for 30 min', waitsFor: 'waits for t12_degC below 20.5 degC for 30 min: 21.3 now', metadata: [{ key: 'sample', value: 'A12' }] },
          { id: 5n, state: QueueEntry_State.WAITING, name: 'check', trajectoryName: 'published.csv', rowCount: 240n, createdBy: 'anna', waitsFor: 'waits for a release of the queue, which is held: stopped by anna' },
          { id: 3n, state: QueueEntry_State.DONE, name: 'night 1', trajectoryName: 'published.csv', rowCount: 240n, createdBy: 'anna', runId: 17n, accepted: true, results: [{ followUp: 'fit:q ~ x', good: true, text: 'model 3 was fitted' }] },
        ],
      }),
      moveQueueEntry: (request) => (wishes.moved?.(request.entryId, request.beforeEntryId), {}),
      releaseQueue: () => (wishes.released?.(), {}),
    });
    service(StudyService, {
      getProcedure: () => ({ steps: procedureSteps }),
    });
    service(IndentationService, {
      listIndentations: () => ({ indentations: [indentation(wishes.lostAt)] }),
      getIndentation: () => ({
        indentation: indentation(wishes.lostAt),
        recordJson: JSON.stringify(indentationRecord(wishes.lostAt)),
        tableJson: wishes.lostAt === undefined ? JSON.stringify(table81) : '',
      }),
    });
    service(PlanService, {
      listPlans: () => ({ plans: [{ id: 1n, name: 'joint', version: 1, createdBy: 'anna', createTime: at(2), serves: true, modelIds: [10n, 11n, 12n] }, { id: 2n, name: 'joint', version: 2, createdBy: 'anna', createTime: at(3), modelIds: [10n, 12n] }] }),
      getPlan: (request) => ({ plan: { id: request.planId, name: 'joint', version: Number(request.planId) }, text: 'name = "joint"\n', steps: ['model 13 predicts parasitic motion of ma; it adds ma.x_mm to mn.x_mm'], promotions: [{ planId: 1n, promoteTime: at(3), promotedBy: 'anna' }] }),
      rollBackPlan: () => (wishes.planRolledBack?.(), {}),
      checkPlan: (request) => (request.planId === 2n
        ? { findings: [{ refuses: true, reason: 'MODELS_DISAGREE', message: 'the two models differ by 57.6 um' }], bands: [{ robot: 'ma', largestDifferenceNm: 57600, largestChannel: 'ma.q2_mm', differenceArcsec: 200, rateShare: 7.5 }] }
        : { findings: [] }),
      promotePlan: (request) => (wishes.promoted?.(request.planId), { plan: { id: request.planId } }),
      computeJointTarget: (request) => ({ target: {
        coordinates: [{ channel: 'mn.q1_mm', positionMm: 1.003, uNm: 50, u90Nm: 82.3 }],
        terms: [{ fromChannel: 'ma.x_mm', toChannel: 'mn.x_mm', value: 3000, u: 400, unit: 'nm', modelId: 13n }],
        robots: [{ robot: 'ma', by: RobotAnswer_By.BLEND, fineWeight: 0.5, modelId: 11n, coarseModelId: 10n, differenceNm: 870 }],
        flags: request.pose.map((one) => `${one.channel}=${one.value}`),
      } }),
    });
    service(WatchService, {
      async *watch(_request, { signal }) {
        for (let n = 0; !signal.aborted; n++) {
          yield fakeBatch(n);
          await pause(100);
        }
      },
      listAlarms: () => ({ alarms: wishes.alarms ?? [fakeAlarm] }),
      acknowledgeAlarm: ({ alarmId }) => ({ alarm: { ...(wishes.alarms?.find((one) => one.id === alarmId) ?? fakeAlarm), acknowledgeTime: timestampOf(fakeNowMs), acknowledgedBy: 'Anna' } }),
      getSeries: ({ channels, fromTime, toTime, bucketCount }) => {
        const twice = channels.find((name, i) => channels.indexOf(name) !== i);
        if (twice) throw new ConnectError(`channels: ${twice} is named twice`, Code.InvalidArgument);
        const from = Number(fromTime?.seconds ?? 0n) * 1000;
        const to = Number(toTime?.seconds ?? 0n) * 1000;
        const at = Array.from({ length: bucketCount }, (_, i) => (from + ((i + 0.5) / bucketCount) * (to - from) - startMs) / 3600e3);
        return {
          fromTime, toTime, raw: true, bucketDuration: { seconds: BigInt(Math.floor((to - from) / 1000 / bucketCount)), nanos: 0 },
          series: channels.map((channel) => {
            const mean = at.map((t, i) => fakeValue(channel, t, i));
            return { channel, unit: channel.split('_').pop()!, base: 0, mean, min: mean, max: mean, count: mean.map(() => 1) };
          }),
        };
      },
    });
    service(RunService, {
      verifyRuns: ({ runIds }) => ({
        runs: runIds.map((id) => ({
          run: { ...fakeRun, id, compensated: id === 17n, ...(id === 17n ? { compensateModelId: 12n } : {}) }, rowCount: 40n, outsideRowCount: 3n, zeroRowCount: 4n, outside: ['t05_degC above 23.1'],
          coordinates: [{ coordinate: 'x', unit: 'nm', all: { mean: 24.3, u90: 12.8, a90: 42, rowCount: 40n }, inside: { mean: 22, u90: 12, a90: 38.2, rowCount: 37n }, outside: { mean: 51, u90: 9, a90: 84.5, rowCount: 3n }, byModel: { mean: 21, u90: 8, a90: 35.6, rowCount: 40n }, largest: 66.2, largestRow: 31n }],
        })),
        changes: runIds.slice(1).map((id) => ({ runId: runIds[0], againstRunId: id, positionCount: 38n, coordinates: [{ output: 'x', unit: 'nm', rows: 'fresh', figures: { mean: 24.3, u90: 12.8, a90: 42, rowCount: 38n }, before: { mean: -400, u90: 900, a90: 1110, rowCount: 38n } }] })),
        accuracy: [{ output: 'x', unit: 'nm', rows: 'fresh', figures: { mean: 24.3, u90: 12.8, a90: 42, rowCount: 40n }, ...(runIds.length > 1 ? { before: { mean: -400, u90: 900, a90: 1110, rowCount: 38n } } : {}) }],
      }),
      getRun: () => ({ run: fakeRun, rulesJson: '{"max_spread_nm": 20}' }),
      listRuns: () => ({ runs: [fakeRun, ...[16, 15, 14].map((id) => ({ ...fakeRun, id: BigInt(id), name: id === 15 ? 'proof-geometry' : 'campaign', state: id === 14 ? Run_State.ABORTED : Run_State.DONE, reason: id === 14 ? 'stopped by Ben' : '', acceptedCount: 1056n, endTime: timestampOf(startMs), elapsedDuration: create(DurationSchema, { seconds: 0n }) }))] }),
      listPoints: () => ({ points: fakePoints }),
      listAttempts: () => ({ attempts: fakeAttempts }),
      listDatums: () => ({ datums: [{ id: 3n, openTime: timestampOf(startMs), reason: 'homed' }] }),
      checkTrajectory: () => create(CheckTrajectoryResponseSchema, {
        rowCount: 240n, calibrationCount: 206n, validationCount: 34n, zeroCount: 20n, lineCount: 20n, coordinates: outputs.map((q) => `${q}_mm`), estimatedDuration: { seconds: 19_400n },
        warnings: ['force rises with time (correlation 0.87 over the calibration rows): a fit could not tell it from a drift'],
      }),
      pauseRun: () => ({ run: fakeRun }), resumeRun: () => ({ run: fakeRun }), abortRun: () => ({ run: fakeRun }),
    });
    service(CellService, {
      getStatus: () => (wishes.noModel ? create(GetStatusResponseSchema, { cellName: fakeStatus.cellName, devices: fakeStatus.devices }) : fakeStatus),
      listDevices: () => create(ListDevicesResponseSchema, { devices: fakeStatus.devices }),
      stopAll: () => ({ confirmed: true, message: 'axis: no motion, in two successive answers' }),
      takeLease: () => ({ lease: { token: 'fake' } }),
      setStabiliser: () => ({}),
      listEvents: () => ({
        events: Array.from({ length: 40 }, (_, i) => ({ id: BigInt(i + 1), eventTime: timestampOf(startMs + i * 60e3), who: i % 3 ? 'daemon' : 'Anna', peer: i % 3 ? '' : 'ipv4:127.0.0.1:50812', what: ['run.started', 'device.lost', 'device.back', 'datum.opened'][i % 4], detail: ['run 17 started', 'laser-x does not answer', 'laser-x answers again', 'datum 3: homed'][i % 4], ...(i % 4 === 0 && { runId: 17n }) })),
      }),
    });
    service(ModelService, {
      listModels: () => ({ models: [model(11), model(12)] }),
      listPromotions: () => ({ promotions: [{ modelId: 11n, promoteTime: at(430), promotedBy: 'anna', action: Promotion_Action.PROMOTE }, { modelId: 12n, promoteTime: at(450), promotedBy: 'anna', action: Promotion_Action.PROMOTE }] }),
      getModel: ({ modelId }) => ({ model: modelId === 30n ? geometryModel(30) : model(Number(modelId)), budgets: [{ place: 'centre', pose: [{ channel: 'x_mm', value: 0 }], coordinates: target(0).coordinates }], declared: [{ deviceId: 'laser-x', channel: 'x_mm', name: 'u_length_nm', value: 4.6 }] }),
      compareModels: ({ modelIds }) => ({
        models: modelIds.map((id) => model(Number(id))),
        rows: termNames.map((name) => ({ channel: 'q1_mm', term: name, cells: modelIds.map(() => ({ offered: true, included: name !== 't09', coefficient: 0.12, standardError: 0.001, contributionRms: 30 })) })),
      }),
      checkFormula: ({ fit }) => create(CheckFormulaResponseSchema, {
        problem: wishes.problem?.(fit?.formula ?? '') ?? '', outputs, terms: termNames.slice(1), calibrationRowCount: 756n, validationRowCount: 300n, rank: 16, columnCount: 17, lookAlikes: ['t08 and t09 cannot be told apart on these rows'],
        channels: [{ symbol: 'q1', unit: 'mm' }, ...rows.variables.map(({ symbol, unit }) => ({ symbol, unit }))],
        effects: [{ name: 'lag', usage: 'lag(t, tau s)', sentence: 'the channel behind a first-order lag', cause: 'thermal_lag' }, { name: 'rate', usage: 'rate(t, tau s)', sentence: 'its smoothed derivative', cause: 'thermal_rate' }],
      }),
      async *compareMethods(request, { signal }) {
        yield { progress: { step: 'classic, 2 of 3', fraction: 0.4 } };
        if (wishes.endless) await untilLeft(signal, wishes.endless);
        yield comparison(request.methods);
      },
      async *studySensors({ tolerance }, { signal }) {
        yield { progress: { step: '512 of 1024 sets', fraction: 0.5 } };
        if (wishes.endless) await untilLeft(signal, wishes.endless);
        yield sensorStudy(tolerance ?? 0.1);
      },
      createFit: () => ({ model: model(12) }),
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
      previewExtension: ({ findingNumbers }) => ({
        findingNumbers, formula: 'q ~ poly(x, y, z, 3) + F + F^2 + lag(t07, 1830 s)', extendsModel: true, earlierRuns: true, laterRuns: true,
        changes: [{ runId: 17n, runName: 'campaign', channel: 'x_mm', fromTime: at(2), rowCount: 1056n, largestNm: 3219.4, rmsNm: 812.3, diagnosed: true }, { runId: 15n, runName: 'proof-geometry', channel: 'x_mm', rowCount: 94n, largestNm: 240.2, rmsNm: 80.1 }],
      }),
      listImprovements: () => ({ improvements: [improvement()] }),
      getImprovement: () => ({ improvement: improvement() }),
    });
    service(ConfigurationService, {
      listConfigurations: () => ({ openQuestion: true, starts: [{ id: 4n, hash: 'bbbb', beforeHash: 'aaaa', version: '0.1.0', startTime: at(1), asks: true, changes: [{ place: 'probe t07_degC', key: 'input', before: '107', after: '108', asks: true, affects: ['t07'] }, { place: 'cell', key: 'listen', before: '127.0.0.1:1', after: '127.0.0.1:2' }] }] }),
      acceptConfiguration: ({ hash }) => ({ start: { id: 4n, hash, asks: true, acceptTime: at(3), acceptedBy: 'anna' } }),
    });
    service(TargetService, {
      computeTarget: ({ pose, showUnreachable }) => {
        if (Math.abs(pose[0]?.value ?? 0) > 2 && !showUnreachable) throw new ConnectError('q1_mm lies beyond its soft limits', Code.OutOfRange);
        if (wishes.noModel) throw new ConnectError('no model serves', Code.FailedPrecondition);
        return { target: target(pose[0]?.value) };
      },
      estimatePose: ({ stated }) => {
        if (wishes.noForce && !stated.some((one) => one.channel === 'force_N')) {
          const message = 'the request lacks force_N, which the model needs: state it, 0 included';
          throw new ConnectError(message, Code.FailedPrecondition, undefined, [{ desc: ErrorDetailSchema, value: { reason: 'MISSING_VALUE', message } }]);
        }
        return {
          modelId: 12n, motor: [{ channel: 'q1_mm', value: 0.2 }],
          coordinates: [
            { channel: 'x_mm', value: 0.2001234, u: 7.1e-6, measured: 0.2001434, discrepancy: 20e-6, agrees: false },
            { channel: 'rz_arcsec', value: 1.25, u: 0.02, agrees: false },
          ],
        };
      },
      listPastTargets: () => ({
        modelId: 12n, times: Array.from({ length: 60 }, (_, i) => at(i - 60)),
        tracks: outputs.map((q, k) => ({ channel: `${q}_mm`, correctionNm: Array.from({ length: 60 }, (_, i) => -12.7 * (k + 1) - 0.3 * (60 - i)) })),
      }),
      mapTargets: ({ horizontal, vertical }) => {
        const place = (axis: typeof horizontal, i: number) => axis!.from! + ((axis!.to! - axis!.from!) * i) / (axis!.count - 1);
        const cells = Array.from({ length: horizontal!.count * vertical!.count }, (_, i) => [place(horizontal, i % horizontal!.count), place(vertical, Math.floor(i / horizontal!.count))]);
        return create(MapTargetsResponseSchema, {
          horizontal, vertical, modelId: 12n, outside: cells.map(([x, y]) => Math.abs(x) > 1.1 || Math.abs(y) > 1.1), unreachable: cells.map(([x]) => Math.abs(x) > 2),
          planes: outputs.map((q, k) => ({ channel: `${q}_mm`, correctionNm: cells.map(([x, y]) => 300 * x * y + 90 * x - 120 * k * y * y), u90Nm: cells.map(([x, y]) => 40 + 15 * (x * x + y * y)), positionMm: [] })),
        });
      },
    });
    service(TrajectoryService, {
      listTrajectories: () => ({ trajectories: [{ ...trajectory, text: '' }] }),
      getTrajectory: () => ({ trajectory }),
    });
    service(DataService, {
      listNotes: () => ({ notes: [] }), listExclusions: () => ({ state: {} }),
      joinRuns: ({ runIds }) => {
        if (runIds.includes(14n)) throw new ConnectError('row 17: q2_mm is 0.5 in run 16 and 0.75 in run 14: join runs of one trajectory only', Code.FailedPrecondition);
        return { reportJson: JSON.stringify({ rows: 240, unmatched_rows: 0, temperature_difference_k: 0.3, temperature_channel: 't05_degC', warnings: [],
          channels: [{ channel: 'ry_arcsec', sources: runIds.map((id) => `run ${id}`), unit: 'arcsec', u_arcsec: 0.021, check: { first: 'run 16', second: 'run 15', rows: 240, median_arcsec: 0, sigma_arcsec: 0.04, largest_arcsec: 0.1, largest_row: 7 } }] }) };
      },
    });
  });
}
