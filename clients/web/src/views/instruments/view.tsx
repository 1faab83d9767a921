// The panels of the published system: interferometers with their spread and zero, autocollimators, temperatures, stabilised
// supports with set-point and output.
import { useMemo } from 'preact/hooks';
import './view.css';
import { ms } from '@/format/time';
import { channel, layout } from '@/live/channels';
import { useHistory } from '@/live/history';
import { usePointColumns, useRunPoints } from '@/live/points';
import { RunMarks } from '@/parts/run_marks';
import { cell, progress } from '@/live/state';
import { lengthsOf, zeroDrift } from '@/parts/zero_plot';
import { Awaiting, Failed } from '@/ui/states';
import { ViewTitle } from '@/ui/view_title';
import { Autocollimator } from './autocollimators';
import { Interferometers } from './interferometers';
import { StabiliserPanel, type Stabiliser } from './stabilisers';
import { Temperatures } from './temperatures';
import { windowSeconds, WindowChoice } from './windows';

function stabilisers(): Stabiliser[] {
  return (cell.value?.devices ?? []).flatMap((device) => {
    const mine = layout.value.filter((one) => one.column.deviceId === device.id);
    const set = mine.find((one) => one.name.endsWith('_set_degC'));
    const now = set && channel(set.name.replace('_set_degC', '_degC'));
    return set && now ? [{ device, set, now, output: mine.find((one) => /_(pct|A|W|V)$/.test(one.name)) }] : [];
  });
}

export default function Instruments() {
  const run = progress.value?.run;
  const points = useRunPoints(run?.id);
  const all = points.value?.points;
  const columns = usePointColumns(all, ms(run?.startTime));
  const drift = useMemo(() => zeroDrift(all ?? [], columns.startMs, lengthsOf(columns.channels)), [columns]);
  const devices = cell.value?.devices ?? [];
  const stable = stabilisers();
  const supports = new Set(stable.flatMap((one) => [one.now.name, one.set.name, one.output?.name]));
  const names = layout.value.map((one) => one.name);
  const rooms = names.filter((name) => name.endsWith('_degC') && !supports.has(name) && !name.endsWith('_set_degC'));
  const lengths = devices.filter((device) => device.lengthChannel !== '');
  const angles = devices.filter((device) => device.angleChannels.length > 0);
  const asked = [...lengths.map((one) => one.lengthChannel), ...angles.flatMap((one) => one.angleChannels), ...rooms, ...stable.flatMap((one) => [one.now.name, ...(one.output ? [one.output.name] : [])])];
  const history = useHistory(asked.filter((name) => names.includes(name)), windowSeconds(), 500);
  if (!cell.value) return <><ViewTitle>Instruments</ViewTitle><Awaiting what="the devices of the cell" /></>;
  return (
    <RunMarks run={run} points={points.value}>
      <ViewTitle actions={<WindowChoice />}>Instruments</ViewTitle>
      {history.failure && <Failed asked="Read the record" failure={history.failure} again={history.again} />}
      <Interferometers devices={lengths} history={history} drift={drift} startMs={columns.startMs} last={all?.[all.length - 1]} />
      <div class="columns">{angles.map((device) => <Autocollimator key={device.id} device={device} history={history} />)}</div>
      {rooms.length > 0 && <Temperatures names={rooms} history={history} />}
      <div class="columns columns-three">{stable.map((one) => <StabiliserPanel key={one.device.id} of={one} history={history} />)}</div>
    </RunMarks>
  );
}
