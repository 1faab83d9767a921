// Drift of the zero and spread of the points of the run under way; without a run, the room's last hour.
import { useMemo } from 'preact/hooks';
import type { RunProgress } from '@/api/gen/driftwise/v1/run_pb';
import { layout } from '@/live/channels';
import type { History } from '@/live/history';
import type { RunPoints } from '@/live/points';
import { environmentPlot } from '@/parts/history_plot';
import { spreadPlot } from '@/parts/spread_plot';
import { airOf, zeroPlot, type ZeroDrift } from '@/parts/zero_plot';
import type { PointColumns } from '@/live/points';
import { Plot } from '@/plot/plot';
import { Panel } from '@/ui/panel';

export function RunPlots({ progress, columns, drift, points, limitNm }: {
  progress: RunProgress;
  columns: PointColumns;
  drift: ZeroDrift;
  points: RunPoints;
  limitNm: number | undefined;
}) {
  const zero = useMemo(() => {
    const air = airOf(columns.channels);
    return { ...zeroPlot(drift, columns.startMs, air ? { name: air, x: columns.hours, y: columns.of(air) } : undefined), file: `run-${progress.run!.id}-zero` };
  }, [drift, columns]);
  const spread = useMemo(() => ({ ...spreadPlot(points.attempts, columns.startMs, limitNm), file: `run-${progress.run!.id}-spread` }), [points.attempts, columns.startMs, limitNm]);
  return (
    <div class="columns">
      <Panel><Plot spec={zero} live group="now" height={230} /></Panel>
      <Panel><Plot spec={spread} live group="now" height={230} /></Panel>
    </div>
  );
}

export function EnvironmentPlot({ history }: { history: History }) {
  const names = layout.value.map((one) => one.name).filter((name) => /^(air|t\d).*_degC$/.test(name));
  const spec = useMemo(() => environmentPlot('Temperatures, last hour', names, history), [history, names.join()]);
  return <Panel><Plot spec={spec} live height={230} /></Panel>;
}
