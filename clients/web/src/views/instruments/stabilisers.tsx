// Each stabilised support: temperature, set-point and its change, output as the device gives it, how long it has been settled.
import { useMemo, useState } from 'preact/hooks';
import { api } from '@/api/client';
import type { Device } from '@/api/gen/driftwise/v1/cell_service_pb';
import { withLease } from '@/app/lease';
import { fixed, signed } from '@/format/numbers';
import { duration } from '@/format/time';
import { splitChannel, unitSign } from '@/format/units';
import type { Channel } from '@/live/channels';
import type { History } from '@/live/history';
import { liveSeries, timeOfDay } from '@/parts/history_plot';
import { settledK } from '@/parts/settled';
import { Plot } from '@/plot/plot';
import type { PlotSpec } from '@/plot/spec';
import { Button, CommandButton } from '@/ui/button';
import { confirm } from '@/ui/confirm';
import { Field, numberTyped } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';
import { useTyped } from '@/ui/use_typed';
import { useWhileSeen } from '@/ui/use_while_seen';
import { Verdict } from '@/ui/verdict';
import { LiveValue } from './live_value';
import { StabiliserLoop } from './stabiliser_loop';

export interface Stabiliser {
  device: Device;
  now: Channel;
  set: Channel;
  output: Channel | undefined;
}

const spoken = (id: string) => id.charAt(0).toUpperCase() + id.slice(1).replaceAll('-', ' ');

// Since when every reading is within the band about its set-point, the smallest and the largest of each bucket too: a gap between two
// readings ends it as well. atLeast: as far as the window shows. undefined: the last reading is outside, or there is none of late.
export function settledFor(history: History, { device, now, set }: Stabiliser): { seconds: number; atLeast: boolean } | undefined {
  const track = history.of(now.name);
  const gapMs = Math.max(now.column.staleAfterS * 1000, 3000 * history.bucketS);
  const inBand = (value: number | undefined) => value === undefined || !Number.isFinite(value) || Math.abs(value - set.value.value) <= settledK(device.id);
  let sinceMs = history.toMs;
  let atLeast = true;
  for (let i = track.mean.length - 1; i >= 0; i--) {
    if (!Number.isFinite(track.mean[i])) continue;
    if (sinceMs - track.atMs[i] > gapMs || ![track.mean[i], track.min?.[i], track.max?.[i]].every(inBand)) {
      atLeast = false;
      break;
    }
    sinceMs = track.atMs[i];
  }
  if (sinceMs === history.toMs) return undefined;
  return { seconds: (history.toMs - sinceMs) / 1000, atLeast: atLeast && sinceMs - history.fromMs <= gapMs };
}

function Settled({ of: { device, now, set }, since }: { of: Stabiliser; since: ReturnType<typeof settledFor> }) {
  const off = now.value.value - set.value.value;
  if (now.stale.value) return <Verdict kind="warn">not known: last read {Number.isFinite(now.ageS.value) ? `${duration(now.ageS.value)} ago` : 'never'}</Verdict>;
  if (!(Math.abs(off) <= settledK(device.id))) return <Verdict kind="warn">{signed(off * 1000, 0)} mK off</Verdict>;
  return <Verdict kind="good">settled{since && ` for ${since.atLeast ? 'at least ' : ''}${duration(since.seconds)}`}</Verdict>;
}

function ChangeSetPoint({ of, done }: { of: Stabiliser; done: () => void }) {
  const { device, set, now } = of;
  const [text, setText, taken] = useTyped(`set-point.${device.id}`);
  const wanted = numberTyped(text);
  const change = useCommand((degc: number) => withLease((leaseToken) => api.cell().setStabiliser({ leaseToken, deviceId: device.id, setPointDegc: degc })));
  const wrong = text !== '' && (wanted === undefined ? 'A number in °C, like 23.000' : wanted < 5 || wanted > 60 ? 'From 5 to 60 °C' : undefined) || undefined;
  const ask = async () => {
    const yes = await confirm({
      title: `Change the set-point of ${device.id}?`,
      facts: [
        ['Set-point', `${fixed(set.value.peek(), 3)} °C → ${fixed(wanted, 3)} °C`],
        ['Now', `${fixed(now.value.peek(), 3)} °C`],
        ['Affects', 'the instruments on this support: their zero drifts until it has settled'],
      ],
      verb: `Set ${fixed(wanted, 3)} °C`,
      keep: 'Keep it as it is',
    });
    if (!yes || !(await change.send(wanted!))) return;
    taken();
    done();
  };
  return (
    <form class="stack" onSubmit={(event) => { event.preventDefault(); if (!wrong && wanted !== undefined) void ask(); }}>
      <Field label="New set-point" unit="°C" type="number" value={text} onInput={setText} wrong={wrong} autofocus />
      <div class="actions">
        <CommandButton kind="main" submit busy={change.busy} off={wrong ?? (wanted === undefined ? 'Type a set-point first' : undefined)}>Change…</CommandButton>
        <Button onPress={done}>Cancel</Button>
      </div>
      {change.failure && <Failed asked={`Set ${device.id}`} failure={change.failure} />}
    </form>
  );
}

function controlPlot({ now, set, output }: Stabiliser, history: History): PlotSpec {
  const unit = output ? unitSign(output.column.unit) : '';
  return {
    title: 'Temperature and output',
    what: output ? `°C against time of day; output in ${unit} on the right` : '°C against time of day',
    x: timeOfDay(history),
    y: { unit: 'degC', zero: false },
    ...(output && { right: { unit: output.column.unit, low: 0, high: output.column.max ?? (output.column.unit === 'pct' ? 100 : undefined) } }),
    series: [
      liveSeries(now.name, history, { name: 'temperature', colour: 'q1' }),
      ...(output ? [liveSeries(output.name, history, { name: 'output', colour: 's5', draw: 'dashed', axis: 'right' })] : []),
    ],
    limits: Number.isFinite(set.value.value) ? [{ at: set.value.value, label: `set-point ${fixed(set.value.value, 3)} °C` }] : [],
    ...(history.waiting && { why: 'Waiting for the record …' }),
  };
}

export function StabiliserPanel({ of, history: latest }: { of: Stabiliser; history: History }) {
  const [history, root] = useWhileSeen(latest);
  const [changing, setChanging] = useState(false);
  const [looking, setLooking] = useState(false);
  const { device, now, set, output } = of;
  const setPoint = set.value.value;
  const spec = useMemo(() => controlPlot(of, history), [history, setPoint]);
  return (
    <Panel title={spoken(device.id)} class="instrument instrument-two" root={root}>
      <div class="instrument-side">
        <LiveValue channel={now} big />
        <dl class="facts note">
          <dt>set-point</dt><dd>{fixed(setPoint, 3)} °C</dd>
          {output && <><dt>{splitChannel(output.name).symbol.split('_').pop()}</dt><dd><LiveValue channel={output} />{output.column.max !== undefined && ` of ${fixed(output.column.max)} ${unitSign(output.column.unit)}`}</dd></>}
        </dl>
        <Settled of={of} since={settledFor(history, of)} />
        {changing ? <ChangeSetPoint of={of} done={() => setChanging(false)} /> : <CommandButton label={`Set-point… of ${device.id}: change it`} onPress={() => setChanging(true)}>Set-point…</CommandButton>}
        <details onToggle={(event) => setLooking(event.currentTarget.open)}><summary>Control loop</summary>{looking && <StabiliserLoop device={device.id} />}</details>
      </div>
      <Plot spec={spec} live height={150} group="live" />
    </Panel>
  );
}
