// Which set a point belongs to, and whether it is a return to zero: what its mark shows.
export type PointSet = 'calibration' | 'validation' | 'zero' | 'rejected';

export const setWords: Record<PointSet, string> = {
  calibration: 'calibration',
  validation: 'validation',
  zero: 'return to zero',
  rejected: 'given up',
};
