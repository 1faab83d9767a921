// The thermometers as small multiples of one scale, with the change since the start of the window, the slope, and the part each is
// glued to.
import { useMemo } from 'preact/hooks';
import { signed } from '@/format/numbers';
import { duration } from '@/format/time';
import { mkFromKelvin, splitChannel } from '@/format/units';
import { channel, type Channel } from '@/live/channels';
import { changeOf, type History } from '@/live/history';
import type { Track } from '@/live/series';
import { liveSeries, timeOfDay } from '@/parts/history_plot';
import { Plot } from '@/plot/plot';
import { Panel } from '@/ui/panel';
import { useWhileSeen } from '@/ui/use_while_seen';
import { LiveValue } from './live_value';

// mK from the first to the last value, the seconds between them, and mK/h over its last quarter by least squares.
export function trend(track: Track): { change: number; seconds: number; slope: number } {
  const at: number[] = [];
  const value: number[] = [];
  track.mean.forEach((mean, i) => {
    if (Number.isFinite(mean)) (at.push(track.atMs[i] / 3600e3), value.push(mkFromKelvin(mean)));
  });
  const over = changeOf(track);
  if (at.length < 3) return { ...over, change: NaN, slope: NaN };
  const from = Math.max(0, Math.floor(at.length * 0.75) - 1);
  const n = at.length - from;
  let t = 0;
  let v = 0;
  for (let i = from; i < at.length; i++) (t += at[i] / n), (v += value[i] / n);
  let tv = 0;
  let tt = 0;
  for (let i = from; i < at.length; i++) (tv += (at[i] - t) * (value[i] - v)), (tt += (at[i] - t) ** 2);
  return { ...over, change: mkFromKelvin(over.change), slope: tt > 0 ? tv / tt : NaN };
}

function Small({ now, history, low, high }: { now: Channel; history: History; low: number; high: number }) {
  const track = history.of(now.name);
  const { change, seconds, slope } = trend(track);
  const spec = useMemo(() => ({
    title: splitChannel(now.name).symbol.replaceAll('_', ' '),
    what: '°C against time of day',
    x: timeOfDay(history),
    y: { unit: 'degC', zero: false, low, high },
    series: [liveSeries(now.name, history, { colour: 's5' as const })],
    ...(history.waiting && { why: 'Waiting for the record …' }),
  }), [history, low, high]);
  return (
    <div class={`small-multiple${now.stale.value ? ' stale' : ''}`}>
      <div class="row"><strong>{spec.title}</strong> <LiveValue channel={now} /></div>
      <p class="note muted">{signed(change, 0)} mK in {duration(Math.round(seconds / 60) * 60)}, {signed(slope, 0)} mK/h</p>
      <p class="note muted place">{[now.column.place, now.column.part].filter(Boolean).join(' · ') || '\u00a0'}</p>
      <Plot spec={spec} live height={110} bare />
    </div>
  );
}

export function Temperatures({ names, history: latest }: { names: readonly string[]; history: History }) {
  const [history, root] = useWhileSeen(latest);
  const seen = names.flatMap((name) => history.of(name).mean).filter(Number.isFinite);
  const low = seen.reduce((a, b) => Math.min(a, b), Infinity);
  const high = seen.reduce((a, b) => Math.max(a, b), -Infinity);
  const all = names.flatMap((name) => channel(name) ?? []);
  const silent = all.filter((one) => one.stale.value);
  return (
    <Panel title={silent.length > 0 ? `Temperatures: ${all.length - silent.length} of ${all.length}; ${silent.map((one) => splitChannel(one.name).symbol).join(', ')} stale` : `Temperatures, °C, one scale`} root={root}>
      <div class="multiples">
        {all.map((one) => <Small key={one.name} now={one} history={history} low={low} high={high} />)}
      </div>
    </Panel>
  );
}
