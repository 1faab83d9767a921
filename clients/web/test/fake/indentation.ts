// An indentation of the study's shape: three touches, one correction, three touches, the zero, ten indents.
import { IndentConformity } from '@/api/gen/driftwise/v1/indentation_service_pb';
import { at, startMs } from './cell';

const coarse = 'plan 1, mn=5, ma=coarse:2';
const indents = ['x100', 'y100', 'x250', 'x500', 'x750', 'x1000', 'y250', 'y500', 'y750', 'y1000'];

function contact(number: number, stage: string, round: number, indent = '') {
  return {
    x_mm: indent ? 0.1 : 1, y_mm: -1, height_mm: 1.6 + number * 1e-5, u_nm: 72.17, steps: 40 + (number % 3), contact: number,
    stage, round, indent, rx_arcsec: round ? -540.2 : 0, ry_arcsec: round ? 559.7 : 0, by: coarse,
    at: new Date(startMs + number * 600_000).toISOString(), trouble: '',
  };
}

// lostAt: contacts until the client was lost; the last of them did not end.
export function indentationRecord(lostAt?: number) {
  const all = [
    ...[1, 2, 3].map((number) => contact(number, 'align', 0)),
    ...[4, 5, 6].map((number) => contact(number, 'align', 1)),
    contact(7, 'zero', 1),
    ...indents.map((indent, i) => contact(8 + i, 'indents', 1, indent)),
  ];
  const rounds = [
    { round: 0, accepted: false, spread_nm: 8250, rx_arcsec: -540.2, ry_arcsec: 559.7, height_mm: 1.6, by: coarse, at: new Date(startMs + 1_900_000).toISOString() },
    { round: 1, accepted: true, spread_nm: 250, rx_arcsec: -540.2, ry_arcsec: 559.7, height_mm: 1.6, by: coarse, at: new Date(startMs + 3_700_000).toISOString() },
  ];
  return {
    driftwise_indentation: 1, stage: lostAt === undefined ? 'microscope' : 'align', corrections: lostAt === undefined ? 1 : 0,
    log: ['align: contacts agree to 8250 nm; the robot below is tilted', 'align: contacts agree to 250 nm: accepted'],
    contact_list: lostAt === undefined ? all : [...all.slice(0, lostAt - 1), { ...all[lostAt - 1], trouble: 'the client was lost during the contact' }],
    rounds: lostAt === undefined ? rounds : [],
  };
}

export const indentation = (lostAt?: number) => ({
  id: 3n, name: 'case C.2', tool: 'diamond 3', createdBy: 'anna', createTime: at(2), plannedIndentCount: 10,
  ...(lostAt === undefined
    ? { stage: 'microscope', contactCount: 17, indentCount: 10, ended: 'all indents are made', reportTime: at(6), verdict: 'not reached: return to step 0', conformity: IndentConformity.BEYOND }
    : { stage: 'align', contactCount: lostAt, indentCount: 0, inContact: true, reportTime: at(3) }),
});
