// A row per instrument of a length (interferometer, touch probe): the value, its spread, its live trace in nm, the zero since the run began, signal and age.
import { useMemo } from 'preact/hooks';
import type { Device } from '@/api/gen/driftwise/v1/cell_service_pb';
import type { Point } from '@/api/gen/driftwise/v1/run_pb';
import { fixed, significant } from '@/format/numbers';
import { nmFromMm, splitChannel } from '@/format/units';
import { channel, layout, type Channel } from '@/live/channels';
import type { History } from '@/live/history';
import { valueOf } from '@/live/points';
import { liveSeries, timeOfDay } from '@/parts/history_plot';
import { axisColours, zeroPlot, type ZeroDrift } from '@/parts/zero_plot';
import { Plot } from '@/plot/plot';
import type { PlotSpec } from '@/plot/spec';
import { Panel } from '@/ui/panel';
import { StaleNote } from '@/ui/tile';
import { useWhileSeen } from '@/ui/use_while_seen';
import { lengthInstrument } from './kinds';
import { LiveValue } from './live_value';

// In nm from the middle of what is seen: a trace about 2.5 mm would be a flat line.
function tracePlot(name: string, at: number, history: History): PlotSpec {
  const seen = history.of(name).mean.filter(Number.isFinite);
  const base = Math.max(...seen) - Math.min(...seen) < 0.1 ? (seen[seen.length - 1] ?? 0) : undefined;
  const nm = base !== undefined && seen.length > 0;
  const about = nm && Math.abs(base) >= 0.1 ? ` about ${fixed(base, 6)} mm` : '';
  const zeroed = nm && Math.abs(base) < 0.1 ? 0 : base;
  return {
    title: `${splitChannel(name).symbol}, live`,
    what: `${nm ? `nm${about}` : 'mm'} against time of day`,
    x: timeOfDay(history),
    y: { unit: nm ? 'nm' : 'mm', zero: nm && zeroed === 0 ? undefined : false },
    series: [liveSeries(name, history, { unit: nm ? 'nm' : 'mm', colour: axisColours[at % 6] }, nm ? (mm) => nmFromMm(mm - zeroed!) : undefined)],
    ...(history.waiting && { why: 'Waiting for the record …' }),
    ...(history.failure && { why: history.failure.message }),
    ...(seen.length === 0 && !history.waiting && { why: `${name} was not read in this time.` }),
  };
}

function Side({ device, now, last }: { device: Device; now: Channel; last: Point | undefined }) {
  const symbol = splitChannel(now.name).symbol;
  const level = layout.value.find((one) => one.column.deviceId === device.id && one.name.startsWith('level'));
  const spread = last ? valueOf(last, `${symbol}_std_nm`) : NaN;
  return (
    <div class="instrument-side">
      <LiveValue channel={now} big />
      <dl class="facts note">
        <dt>spread of the last point</dt><dd>{Number.isFinite(spread) ? `${significant(spread)} nm` : '–'}</dd>
        {level && <><dt>signal</dt><dd><LiveValue channel={level} bare /></dd>{level.stale.value && <dd class="wide"><StaleNote channel={level} /></dd>}</>}
        <dt>device</dt><dd>{device.id}</dd>
      </dl>
    </div>
  );
}

function Row({ device, now, at, history, drift, startMs, last }: {
  device: Device; now: Channel; at: number; history: History; drift: ZeroDrift; startMs: number; last: Point | undefined;
}) {
  const [shown, root] = useWhileSeen(history);
  const trace = useMemo(() => tracePlot(now.name, at, shown), [shown, now.name]);
  const zero = useMemo(() => {
    const index = drift.lengths.indexOf(now.name);
    const spec = zeroPlot({ ...drift, lengths: [now.name], nm: index < 0 ? [[]] : [drift.nm[index]], hours: index < 0 ? [] : drift.hours }, startMs);
    return { ...spec, title: `Zero of ${splitChannel(now.name).symbol} since start`, series: spec.series.map((one) => ({ ...one, colour: axisColours[at % 6] })) };
  }, [drift, now.name]);
  return (
    <Panel title={`${splitChannel(now.name).symbol} ${lengthInstrument(device.kind)}`} class="instrument" root={root}>
      <Side device={device} now={now} last={last} />
      <Plot spec={trace} live height={150} group="live" />
      <Plot spec={zero} live height={150} group="zero" />
    </Panel>
  );
}

export function Interferometers({ devices, history, drift, startMs, last }: {
  devices: readonly Device[]; history: History; drift: ZeroDrift; startMs: number; last: Point | undefined;
}) {
  return (
    <>
      {devices.map((device, at) => {
        const now = channel(device.lengthChannel);
        return now && <Row key={device.id} device={device} now={now} at={at} history={history} drift={drift} startMs={startMs} last={last} />;
      })}
    </>
  );
}
