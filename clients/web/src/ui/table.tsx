// A real table; on a phone each row becomes a card with the column's name beside its value. Rows are drawn a page at a
// time, so that ten thousand open as fast as ten; on paper all of them, a wide table in parts that repeat its first column.
import type { ComponentChildren } from 'preact';
import { useState } from 'preact/hooks';
import { printing } from '@/app/printing';
import { Button } from './button';
import { count } from '@/format/numbers';

export interface Column<R> {
  title: string;
  of: (row: R) => ComponentChildren;
  number?: boolean; // right, not wrapped
  sort?: (row: R) => number | string; // can be sorted by
}

// Columns side by side on a sheet.
const mostOnPaper = 13;

export function sheets<R>(columns: readonly Column<R>[]): (readonly Column<R>[])[] {
  if (columns.length <= mostOnPaper) return [columns];
  const [first, ...rest] = columns;
  const parts = Math.ceil(rest.length / (mostOnPaper - 1));
  const each = Math.ceil(rest.length / parts);
  return Array.from({ length: parts }, (_, i) => [first, ...rest.slice(i * each, (i + 1) * each)]);
}

// A row is a card of half a screen there.
const mostCards = 12;
const phone = () => typeof matchMedia === 'function' && matchMedia('(max-width: 720px)').matches;

export function Table<R>({ caption, columns, rows, keyOf, page = 200, rowClass, onRow, sorted }: {
  caption: string; // for screen readers
  columns: readonly Column<R>[];
  rows: readonly R[];
  keyOf: (row: R) => string | number;
  page?: number;
  rowClass?: (row: R) => string | undefined;
  onRow?: (row: R) => void; // a click on the row, beside the links within it
  sorted?: { by: string; down: boolean }; // at first
}) {
  const [shown, setShown] = useState(() => (phone() ? Math.min(page, mostCards) : page));
  const [order, setOrder] = useState(sorted);
  const by = order && columns.find((column) => column.title === order.by)?.sort;
  const all = by
    ? rows
        .map((row) => ({ row, key: by(row) }))
        .sort((a, b) => (a.key < b.key ? -1 : a.key > b.key ? 1 : 0) * (order.down ? -1 : 1))
        .map(({ row }) => row)
    : rows;
  const press = (title: string) => setOrder((old) => ({ by: title, down: old?.by === title ? !old.down : false }));
  const paper = printing.value;
  const parts = paper ? sheets(columns) : [columns];
  const rowsShown = paper ? all : all.slice(0, shown);
  return (
    <div class="table-scroll" tabIndex={0} role="region" aria-label={caption}>
      {parts.map((part, at) => (
        <table class="cards" key={at}>
          <caption class="sr-only">{caption}{parts.length > 1 && `, part ${at + 1} of ${parts.length}`}</caption>
          <thead>
            <tr>
              {part.map((column) => (
                <th
                  key={column.title}
                  scope="col"
                  class={column.number ? 'number' : undefined}
                  aria-sort={order?.by === column.title ? (order.down ? 'descending' : 'ascending') : undefined}
                >
                  {column.sort ? <button type="button" class="sort" onClick={() => press(column.title)}>{column.title}</button> : column.title}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {rowsShown.map((row) => (
              <tr key={keyOf(row)} class={rowClass?.(row)} onClick={onRow && (() => onRow(row))} data-row>
                {part.map((column) => (
                  <td key={column.title} class={column.number ? 'number' : undefined} data-title={column.title}>{column.of(row)}</td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      ))}
      {!paper && all.length > shown && (
        <p class="more">
          <span class="muted">{count(shown)} of {count(all.length)} rows </span>
          <Button small onPress={() => setShown(shown + 5 * page)}>Show more</Button>
        </p>
      )}
    </div>
  );
}
