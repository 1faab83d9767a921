// Rows as people write them: "12-15, 40", counted from 1 as everywhere.
export interface Rows {
  firstRow: bigint;
  lastRow: bigint;
}

export function rowsTyped(text: string, rowCount: number): Rows[] | string {
  const parts = text.split(/[,;\s]+/).filter(Boolean);
  if (parts.length === 0) return 'Rows like 12-15, 40';
  const ranges: Rows[] = [];
  for (const part of parts) {
    const found = /^(\d+)(?:[-–](\d+))?$/.exec(part);
    if (!found) return `"${part}" is no row and no range like 12-15`;
    const first = Number(found[1]);
    const last = Number(found[2] ?? found[1]);
    if (first < 1 || last > rowCount || first > last) return `${part}: rows go from 1 to ${rowCount}`;
    ranges.push({ firstRow: BigInt(first), lastRow: BigInt(last) });
  }
  return ranges;
}

export const rowsText = (ranges: readonly Rows[]): string =>
  ranges.map(({ firstRow, lastRow }) => (firstRow === lastRow ? `${firstRow}` : `${firstRow}-${lastRow}`)).join(', ');
