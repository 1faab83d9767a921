// The plot's numbers as a table, for those who would rather read.
import { fixed } from '@/format/numbers';
import { dateClock } from '@/format/time';
import { Table, type Column } from '@/ui/table';
import type { PlotSpec } from './spec';
import { columnsOf, digitsOf } from './values';

export function PlotTable({ spec }: { spec: PlotSpec }) {
  const { names, x, values } = columnsOf(spec);
  const digits = new Map(spec.series.map((one) => [one.unit || '1', digitsOf(one)]));
  const columns: Column<number>[] = [
    { title: spec.x.label, number: true, of: (row) => fixed(x[row], 4) },
    ...(spec.x.startMs === undefined ? [] : [{ title: 'time', of: (row: number) => dateClock(spec.x.startMs! + x[row] * 3600e3) }]),
    ...names.map((name, column): Column<number> => ({
      title: name,
      number: true,
      of: (row) => fixed(values[column][row], digits.get(name.slice(name.lastIndexOf('_') + 1)) ?? 3),
    })),
  ];
  return <Table caption={`${spec.title}: values`} columns={columns} rows={x.map((_, row) => row)} keyOf={(row) => row} page={50} />;
}
