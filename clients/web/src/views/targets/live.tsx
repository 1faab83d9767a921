// How the correction of this pose moves while temperatures do.
import { useMemo } from 'preact/hooks';
import { splitChannel } from '@/format/units';
import { Plot } from '@/plot/plot';
import type { Colour, PlotSpec } from '@/plot/spec';
import { Panel } from '@/ui/panel';
import type { HistoryRow } from './use_target';

const colours: readonly Colour[] = ['q1', 'q2', 'q3', 's4', 's5', 's6'];

export function liveSpec(history: readonly HistoryRow[], outputs: readonly string[]): PlotSpec {
  const startMs = history[0]?.atMs ?? 0;
  const x = history.map((row) => (row.atMs - startMs) / 60_000);
  const first = history[0]?.correctionNm ?? [];
  const series = outputs.slice(0, 6).map((channel, i) => ({
    name: splitChannel(channel).symbol, unit: 'nm', colour: colours[i], x, y: history.map((row) => row.correctionNm[i] - first[i]), digits: 1,
  }));
  return {
    title: 'Change of the correction', what: 'nm against minutes since this pose was asked for, time of the cell', x: { label: 'time_min', unit: 'min' },
    y: { unit: 'nm', low: -5, high: 5 }, series: series.filter((one) => one.y.some(Number.isFinite)), file: 'target-change',
    ...(history.length < 2 ? { why: 'It begins with the second look at the conditions: a few seconds.' } : {}),
  };
}

export function Live({ history, outputs }: { history: readonly HistoryRow[]; outputs: readonly string[] }) {
  const spec = useMemo(() => liveSpec(history, outputs), [history, outputs.join()]);
  return <Panel><Plot spec={spec} height={300} /></Panel>;
}
