// Now: is it running, are the data good, what needs a person. ?wall=1 shows it across a room, without controls.
import { useMemo } from 'preact/hooks';
import './view.css';
import { api } from '@/api/client';
import { query } from '@/app/router';
import { layout } from '@/live/channels';
import { connection } from '@/live/connection';
import { changeOf, useHistory } from '@/live/history';
import { usePointColumns, useRunPoints } from '@/live/points';
import { RunMarks } from '@/parts/run_marks';
import { cell, progress as progressNow } from '@/live/state';
import { ms } from '@/format/time';
import { ruleOf } from '@/parts/run_words';
import { ConfigurationQuestion } from '@/parts/configuration';
import { airOf, lengthsOf, zeroDrift } from '@/parts/zero_plot';
import { Awaiting, Failed } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { ViewTitle } from '@/ui/view_title';
import { late } from '@/ui/late';
import { AlarmList, WallAlarms } from './alarm_list';
import { DeviceList } from './device_list';
import { IdlePanel, RunPanel, underWay } from './run_panel';
import { Tiles } from './tiles';

const kPlotHeight = 300;
const RunPlots = late(() => import('./plots').then((plots) => plots.RunPlots), kPlotHeight);
const EnvironmentPlot = late(() => import('./plots').then((plots) => plots.EnvironmentPlot), kPlotHeight);

export default function Now() {
  const wall = query('wall') === '1';
  const progress = underWay(progressNow.value);
  const run = progress?.run;
  const rules = useAsked(run && `rules ${run.id}`, async (signal) => (await api.run().getRun({ runId: run!.id }, { signal })).rulesJson);
  const limitNm = ruleOf(rules.value, 'max_spread_nm');
  const points = useRunPoints(run?.id);
  const columns = usePointColumns(points.value?.points, ms(run?.startTime));
  const lengths = useMemo(() => lengthsOf(columns.channels), [columns]);
  const drift = useMemo(() => zeroDrift(points.value?.points ?? [], columns.startMs, lengths), [columns, lengths]);
  const rooms = layout.value.map((one) => one.name).filter((name) => /^(air|t\d).*_degC$/.test(name));
  const history = useHistory(rooms, 3600, 600);
  const air = airOf(rooms);
  if (connection.value.phase === 'connecting' && !cell.value) return <><ViewTitle hidden>Now</ViewTitle><Awaiting what="the state of the cell" /></>;
  return (
    <RunMarks run={run} points={points.value}>
      <ViewTitle hidden>Now</ViewTitle>
      {wall && <WallAlarms />}
      {progress ? <RunPanel progress={progress} buttons={!wall} /> : <IdlePanel />}
      {!wall && <ConfigurationQuestion />}
      {!wall && <AlarmList />}
      <Tiles
        progress={progress}
        drift={run && drift}
        limitNm={limitNm}
        airChange={air ? changeOf(history.of(air)) : undefined}
      />
      {points.failure && <Failed asked="List the points" failure={points.failure} again={points.again} />}
      {progress && points.value
        ? <RunPlots progress={progress} columns={columns} drift={drift} points={points.value} limitNm={limitNm} />
        : <EnvironmentPlot history={history} />}
      {!wall && <DeviceList />}
    </RunMarks>
  );
}
