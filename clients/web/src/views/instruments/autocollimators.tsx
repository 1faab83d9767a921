// Tilts in arcsec, live, with where they stand in their range.
import { useMemo } from 'preact/hooks';
import type { Device } from '@/api/gen/driftwise/v1/cell_service_pb';
import { fixed } from '@/format/numbers';
import { splitChannel } from '@/format/units';
import { channel, type Channel } from '@/live/channels';
import type { History } from '@/live/history';
import { liveSeries, timeOfDay } from '@/parts/history_plot';
import { axisColours } from '@/parts/zero_plot';
import { Plot } from '@/plot/plot';
import type { PlotSpec } from '@/plot/spec';
import { Panel } from '@/ui/panel';
import { useWhileSeen } from '@/ui/use_while_seen';
import { angleInstrument } from './kinds';
import { LiveValue } from './live_value';

const usualLimit = 400; // arcsec: the range of the published autocollimators, where the cell file names none

function RangeBar({ now }: { now: Channel }) {
  const low = now.column.min ?? -usualLimit;
  const high = now.column.max ?? usualLimit;
  const share = (now.value.value - low) / (high - low);
  return (
    <div class="note muted">
      <meter class="range-bar" min={0} max={1} low={0.1} high={0.9} optimum={0.5} value={Number.isFinite(share) ? share : 0} aria-label={`${splitChannel(now.name).symbol} within its range`} />
      limit {low === -high ? `±${fixed(high)}` : `${fixed(low)} to ${fixed(high)}`} arcsec
    </div>
  );
}

function tilts(names: readonly string[], declared: readonly string[], history: History): PlotSpec {
  return {
    title: names.length > 0 ? `${names.map((name) => splitChannel(name).symbol).join(', ')}, live` : 'No angle read yet',
    what: 'arcsec against time of day',
    x: timeOfDay(history),
    y: { unit: 'arcsec', zero: false },
    series: names.map((name, i) => liveSeries(name, history, { colour: axisColours[i % 6] })),
    ...(history.waiting && { why: 'Waiting for the record …' }),
    ...(history.failure && { why: history.failure.message }),
    ...(names.length === 0 && { why: `${declared.map((name) => splitChannel(name).symbol).join(', ')}: not read since the daemon started.` }),
  };
}

export function Autocollimator({ device, history }: { device: Device; history: History }) {
  const angles = device.angleChannels.flatMap((name) => channel(name) ?? []);
  const [shown, root] = useWhileSeen(history);
  const spec = useMemo(() => tilts(angles.map((one) => one.name), device.angleChannels, shown), [shown, angles.length]);
  return (
    <Panel title={`${angleInstrument(device.kind)} ${device.id}`} class="instrument instrument-two" root={root}>
      <div class="instrument-side">
        {angles.map((one) => (
          <div key={one.name}>
            <span class="muted">{splitChannel(one.name).symbol}</span> <LiveValue channel={one} big />
            <RangeBar now={one} />
          </div>
        ))}
      </div>
      <Plot spec={spec} live height={150} group="live" />
    </Panel>
  );
}
