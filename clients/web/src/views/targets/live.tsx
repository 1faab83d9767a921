// How the correction of this pose moved in the last hour, and moves, while temperatures do.
import { useMemo } from 'preact/hooks';
import { lastMidnight } from '@/format/time';
import { splitChannel } from '@/format/units';
import { Plot } from '@/plot/plot';
import type { Colour, PlotSpec } from '@/plot/spec';
import { Panel } from '@/ui/panel';
import type { HistoryRow } from './use_target';

const colours: readonly Colour[] = ['q1', 'q2', 'q3', 's4', 's5', 's6'];

export function liveSpec(history: readonly HistoryRow[], outputs: readonly string[]): PlotSpec {
  const startMs = lastMidnight(history[0]?.atMs ?? 0);
  const x = history.map((row) => (row.atMs - startMs) / 3_600_000);
  const last = history.findLast((row) => row.correctionNm.some(Number.isFinite))?.correctionNm ?? [];
  const series = outputs.slice(0, 6).map((channel, i) => ({
    name: splitChannel(channel).symbol, unit: 'nm', colour: colours[i], x, y: history.map((row) => row.correctionNm[i] - last[i]), digits: 1,
  }));
  return {
    title: 'The correction in the last hour', what: 'nm, against what it is now; against time of day', x: { label: 'time_h', unit: 'h', startMs, clock: true },
    y: { unit: 'nm', low: -5, high: 5 }, series: series.filter((one) => one.y.some(Number.isFinite)), file: 'target-change',
    ...(history.length < 2 ? { why: 'Waiting for the record …' } : {}),
  };
}

export function Live({ history, outputs }: { history: readonly HistoryRow[]; outputs: readonly string[] }) {
  const spec = useMemo(() => liveSpec(history, outputs), [history, outputs.join()]);
  return <Panel><Plot spec={spec} height={200} /></Panel>;
}
