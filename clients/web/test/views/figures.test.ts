import { describe, expect, it } from 'vitest';
import { create } from '@bufbuild/protobuf';
import { ModelTermSchema } from '@/api/gen/driftwise/v1/model_service_pb';
import { FindingSchema } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { residualSpecs } from '@/plot/residual_specs';
import { forceText, trajectoryRows } from '@/trajectory/parse';
import { causeText, withCauses } from '@/views/diagnosis/causes';
import { servedBefore } from '@/parts/served';
import { parameterTables } from '@/views/diagnosis/parameters';
import { standing } from '@/views/diagnosis/improvement';
import { headline, isWhole, parameterText, parameterWords, sentenceCase, turnLines } from '@/views/diagnosis/words';
import { contributionError, logScale } from '@/views/models/terms';

const promoted = (id: bigint) => ({ id, rollback: false });
const backTo = (id?: bigint) => ({ id, rollback: true });

describe('which model served before', () => {
  it('counts promotions and rollbacks as a stack', () => {
    expect(servedBefore([promoted(1n), promoted(2n), backTo(1n), promoted(3n)])).toEqual({ now: 3n, before: 1n });
    expect(servedBefore([promoted(1n), backTo()])).toEqual({ now: undefined, before: undefined });
  });

  it('passes over a repeated promotion, and over the rollback from one to the same', () => {
    expect(servedBefore([promoted(1n), promoted(2n), promoted(2n)])).toEqual({ now: 2n, before: 1n });
    expect(servedBefore([promoted(1n), promoted(2n), promoted(2n), backTo(2n)])).toEqual({ now: 2n, before: 1n });
  });
});

describe('terms', () => {
  it('gives a contribution the relative error of its coefficient, the larger one where rows are not independent', () => {
    const term = create(ModelTermSchema, { contributionRms: 200, coefficient: -4, standardError: 0.1, standardErrorSerial: 0.2 });
    expect(contributionError(term)).toBeCloseTo(10);
  });
  it('scales bars by whole decades', () => {
    const scale = logScale([3, 30, 900]);
    expect([scale(1), scale(1000), scale(0)]).toEqual([0, 1, 0]);
  });
});

describe('residuals', () => {
  const rows = {
    timeS: [0, 10, 20, 30], validation: [false, true, false, false], excluded: [false, false, true, false],
    variables: [{ symbol: 'x', unit: 'mm', values: [1, 0, 2, NaN] }, { symbol: 'y', unit: 'mm', values: [5, 5, 5, 5] }, { symbol: 'q1', unit: 'mm', values: [1, 2, 3, 4] }],
    outputs: [{ output: 'q1', values: [-3, 1, 99, 2] }],
  };
  const specs = residualSpecs(rows, 'q1', 'nm', 4, 'model-1');
  it('shows time and every channel that varies, but not the output itself', () => {
    expect(specs.map((spec) => spec.title)).toEqual(['Over time', 'Against x']);
  });
  it('keeps the sets apart, leaves excluded and missing rows out, and has one symmetric scale', () => {
    const [time, x] = specs;
    expect(time.series.map((one) => [one.name, [...(one.y as number[])]])).toEqual([['calibration', [-3, 2]], ['validation', [1]]]);
    expect(x.series[0].x).toEqual([1]);
    expect([time.y.low, time.y.high]).toEqual([-3, 3]);
  });
});

describe('parameters of a finding', () => {
  it('shows no more digits than the interval supports', () => {
    expect(parameterText(1830.4, { low: 1740.2, high: 1925.1 })).toBe('1830');
    expect(parameterText(0.04712, { low: 0.0451, high: 0.0492 })).toBe('0.0471');
    expect(parameterText(85, undefined)).toBe('85.0');
    expect(parameterText(4, undefined, isWhole('degree'))).toBe('4');
  });
  it('takes the unit from the name', () => {
    expect(parameterWords('tau_s')).toEqual({ name: 'tau', unit: 's' });
    expect(parameterWords('nm_per_k_per_h').unit).toBe('nm/(K/h)');
    expect(parameterWords('ppm_per_k_x_q1')).toEqual({ name: 'x, q1', unit: 'ppm/K' });
    expect(parameterWords('arcsec_per_h')).toEqual({ name: 'size', unit: 'arcsec/h' });
    expect(parameterWords('arcsec_per_k_q2')).toEqual({ name: 'size, q2', unit: 'arcsec/K' });
    expect(parameterWords('nm_per_k_q2')).toEqual({ name: 'size, q2', unit: 'nm/K' });
    expect(parameterWords('offset_mm_rx_q1')).toEqual({ name: 'offset rx, q1', unit: 'mm' });
    expect(parameterWords('nm_per_k_ma.q2')).toEqual({ name: 'size, ma.q2', unit: 'nm/K' });
    expect(parameterWords('offset_mm_rx_ma.q1')).toEqual({ name: 'offset rx, ma.q1', unit: 'mm' });
  });
  it('leave the heading, which keeps what it says', () => {
    expect(headline('The beam misses the centre of rotation: the error goes with the tilts, offset rx -13 mm (q1) (90 %: -17.1 to -8.88); q1: 285 nm rms, held-out U90 1.69e+03 -> 80.2 nm.'))
      .toBe('The beam misses the centre of rotation: the error goes with the tilts');
    expect(headline('The beam misses the centre of rotation: the error goes with the tilts, offset rx -13 mm (ma.q1) (90 %: -17.1 to -8.88); ma.q1: 285 nm rms.'))
      .toBe('The beam misses the centre of rotation: the error goes with the tilts');
    expect(headline('Axis q2 has a play of 85 nm: it matters, from which side a point is approached.')).toBe('Axis q2 has a play of 85 nm: it matters, from which side a point is approached');
    expect(turnLines('fitted model 4: q ~ poly(x, y, z, 2). The geometry needs terms in x:y that the simulation lacks, 3 degree; q1: 42 nm rms, held-out U90 77 -> 10.5 nm. q1 has play: it depends on the side it came from, width 23.4 nm (90 %: 17.3 to 29.5); q1: 2.61 nm rms. stopped: no lease'))
      .toEqual(['Fitted model 4: q ~ poly(x, y, z, 2)', 'The geometry needs terms in x:y that the simulation lacks', 'q1 has play: it depends on the side it came from', 'Stopped: no lease']);
    expect(turnLines('fitted model 4: q ~ x. A90 on fresh points, run 5, by the model before and by the new one: q1 192 -> 77 nm (mean +3 -> +43.8)')).toEqual(['Fitted model 4: q ~ x']);
    expect(headline('The robot follows t07 with a delay; q1: 84 nm rms, held-out U90 164 -> 61 nm.')).toBe('The robot follows t07 with a delay');
  });
});

describe('parameters of a finding in tables', () => {
  const finding = create(FindingSchema, {
    outputs: ['q1', 'q2'].map((output) => ({ output, unit: 'nm', amplitude: 20, shown: true })),
    parameters: ['ppm_per_k_x_q1', 'ppm_per_k_x_q2', 'ppm_per_k_y_q1', 'tau_s'].map((name, value) => ({ name, value })),
  });
  it('give each output a column, and what holds for all a row of its own', () => {
    const { single, shared, outputs } = parameterTables(finding);
    expect(single.map((one) => one.name)).toEqual(['tau_s']);
    expect(outputs).toEqual(['q1', 'q2']);
    expect(shared.map((row) => [row.name, row.unit, row.of.get('q1')?.value, row.of.get('q2')?.value])).toEqual([['x', 'ppm/K', 0, 1], ['y', 'ppm/K', 2, undefined]]);
  });
});

describe('an improvement', () => {
  it('counts what stands: not the turn that was undone in the end', () => {
    const turns = [{ number: 1, diagnosisId: 2n }, { number: 2, diagnosisId: 3n }] as never;
    expect(standing({ turns, reason: 'fresh points do not show the gain of diagnosis 3: it was undone' }).map((turn) => turn.number)).toEqual([1]);
    expect(standing({ turns, reason: 'nothing beyond noise is left' })).toHaveLength(2);
  });
});

describe('causes and turns in words', () => {
  it('say a cause with its subject, and leave an unknown one as it is', () => {
    expect(causeText('thermal_expansion t03')).toBe('expansion with t03');
    expect(causeText('sensor_fault', 't07')).toBe('a faulty sensor, t07');
    expect(causeText('sensor_fault')).toBe('a faulty sensor');
    expect(causeText('moon_phase', 'x')).toBe('moon_phase x');
  });
  it('begin with a capital, but for a channel', () => {
    expect(['nothing is left', 'q1: too few rows', 'x grows'].map(sentenceCase)).toEqual(['Nothing is left', 'q1: too few rows', 'x grows']);
  });
  it('put the ids of a remark into words, where they have a subject', () => {
    expect(withCauses('thermal_expansion t04 was named first; with the rest known, thermal_expansion t06 explains more')).toBe('expansion with t04 was named first; with the rest known, expansion with t06 explains more');
    expect(withCauses('geometry_order x:y and backlash q1')).toBe('missing terms of the geometry in x:y and play of q1');
    expect(withCauses('no creep in these data')).toBe('no creep in these data');
  });
  it('put sentences that differ in a term only into one, and ids into words', () => {
    const needs = (of: string) => `The geometry needs terms in ${of} that the simulation lacks, 3 degree; q1: 42 nm rms, held-out U90 77 -> 10.5 nm.`;
    expect(turnLines(`fitted model 4: q ~ poly(x, y, z, 2). geometry_order y cannot be told apart from cyclic_error y: measured what separates them. ${needs('x:y')} ${needs('x')} ${needs('z')}`))
      .toEqual(['Fitted model 4: q ~ poly(x, y, z, 2)', 'Missing terms of the geometry in y cannot be told apart from a periodic error along y: measured what separates them', 'The geometry needs terms in x:y, x and z that the simulation lacks']);
  });
});

describe('a trajectory as rows', () => {
  it('reads what the daemon accepts: byte order mark, blanks, comments, empty fields', () => {
    const of = trajectoryRows('\ufeff# made by: hand\r\nq1_mm, q2_mm,set,zero,force_N\r\n0,0,calibration,1,\r\n1.5, -2,validation,0,0.768\r\n\r\n');
    expect(of.coordinates).toEqual(['q1_mm', 'q2_mm']);
    expect(of.rows).toHaveLength(2);
    expect(of.rows[1]).toEqual({ at: [1.5, -2], validation: true, zero: false, line: 1, forceN: 0.768 });
    expect(forceText(of)).toBe('0.768 N');
  });
  it('reads nothing from what is no trajectory', () => {
    expect(trajectoryRows('hello\nworld').rows).toEqual([]);
    expect(trajectoryRows('').coordinates).toEqual([]);
  });
});
