// What a sheet must say that the screen's surroundings say otherwise: which cell, which configuration, from where, when, and
// in which zone its times are. Only on paper.
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { dateClock } from '@/format/time';
import { cell, cellTimeMs } from '@/live/state';
import { operatorName } from './session';
import { place } from './router';
import { printing } from './printing';

export type PrintFact = readonly [what: string, value: string];

// Of the record that the view shows: its hashes.
const ofView = signal<readonly PrintFact[]>([]);

export function usePrintFacts(facts: readonly PrintFact[]): void {
  const key = JSON.stringify(facts);
  useEffect(() => {
    ofView.value = facts.filter(([, value]) => value !== '');
    return () => void (ofView.value = []);
  }, [key]);
}

export function PrintHead() {
  if (!printing.value) return null;
  const status = cell.value;
  const atMs = cellTimeMs.peek() ?? Date.now();
  const facts: PrintFact[] = [
    ['cell', `${status?.cellName ?? 'unknown'}, Driftwise ${status?.version ?? 'unknown'}`],
    ['cell file in force', status?.configHash || 'unknown'],
    ...(status?.servingModelId ? [['serving', `model ${status.servingModelId}`] as const] : []),
    ...ofView.value,
    ['address', `${place.value.path}${location.search}`],
    ['times in', 'UTC'],
    ['printed', `${dateClock(atMs)} by the cell's clock${operatorName.value && `, by ${operatorName.value}`}`],
  ];
  return (
    <dl class="print-head facts" aria-label="What was printed">
      {facts.map(([what, value]) => [<dt>{what}</dt>, <dd>{value}</dd>])}
    </dl>
  );
}
