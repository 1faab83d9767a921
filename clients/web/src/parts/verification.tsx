// What compensation achieved: target minus measured of a run, per coordinate, and against another run on the same positions.
// The figures come from the daemon; the page and the printed report show them by this one part.
import { count, signed } from '@/format/numbers';
import { unitSign } from '@/format/units';
import { figure, meanFigure } from '@/ui/accuracy';
import { Table } from '@/ui/table';

export interface Figures {
  mean: number;
  u90: number;
  a90: number;
  rowCount: bigint | number;
}
export interface Coordinate {
  coordinate: string;
  unit: string;
  all?: Figures | undefined;
  inside?: Figures | undefined;
  outside?: Figures | undefined;
  byModel?: Figures | undefined;
  largest: number;
  largestRow: bigint | number;
}
export interface Verified {
  rows: bigint | number;
  outsideRows: bigint | number;
  zeroRows: bigint | number;
  outside: readonly string[];
  coordinates: readonly Coordinate[];
}

interface Line {
  of: Coordinate;
  points: string;
  figures: Figures;
}

const linesOf = (one: Coordinate): Line[] => {
  const all: [string, Figures | undefined][] = Number(one.outside?.rowCount ?? 0) > 0
    ? [['all', one.all], ['inside the model’s range', one.inside], ['outside', one.outside]]
    : [['all', one.all]];
  all.push(['all, the axes’ own misses taken out', one.byModel]);
  return all.flatMap(([points, figures]) => (figures && Number(figures.rowCount) > 0 ? [{ of: one, points, figures }] : []));
};

export function VerificationTable({ of, run }: { of: Verified; run: string }) {
  return (
    <>
      <p class="note muted">
        target minus measured at {count(of.rows)} points{Number(of.zeroRows) > 0 && `, ${count(of.zeroRows)} returns to zero left out`}
        {of.outside.length > 0 && `; ${count(of.outsideRows)} outside the model’s range: ${of.outside.join(', ')}`}
      </p>
      <Table
        caption={`Verification of run ${run}`}
        rows={of.coordinates.flatMap(linesOf)}
        keyOf={(line) => `${line.of.coordinate} ${line.points}`}
        columns={[
          { title: 'coordinate', of: (line: Line) => line.of.coordinate },
          { title: 'points', of: (line) => line.points },
          { title: 'count', number: true, of: (line) => count(line.figures.rowCount) },
          { title: 'A90', number: true, of: (line) => <strong>{figure(line.figures.a90)} {unitSign(line.of.unit)}</strong> },
          { title: 'mean', number: true, of: (line) => `${meanFigure(line.figures.mean, line.figures.a90)} ${unitSign(line.of.unit)}` },
          { title: 'S90', number: true, of: (line) => `${figure(line.figures.u90)} ${unitSign(line.of.unit)}` },
          { title: 'largest', number: true, of: (line) => (line.points === 'all' ? `${signed(line.of.largest, 1)} ${unitSign(line.of.unit)} in row ${count(line.of.largestRow)}` : '') },
        ]}
      />
    </>
  );
}

