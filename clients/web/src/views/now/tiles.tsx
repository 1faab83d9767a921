// The numbers of Now: the last point, the drift of the zero, the room, the supports, the force.
import type { Device } from '@/api/gen/driftwise/v1/cell_service_pb';
import type { RunProgress } from '@/api/gen/driftwise/v1/run_pb';
import { fixed, signed, significant } from '@/format/numbers';
import { duration } from '@/format/time';
import { splitChannel, unitSign } from '@/format/units';
import { channel, layout, type Channel } from '@/live/channels';
import { connection } from '@/live/connection';
import { cell } from '@/live/state';
import { settledK } from '@/parts/settled';
import { airOf, type ZeroDrift } from '@/parts/zero_plot';
import { ChannelTile, Tile } from '@/ui/tile';
import { Verdict } from '@/ui/verdict';

const isLost = () => connection.value.phase === 'lost';

function SpreadTile({ progress, limitNm }: { progress: RunProgress; limitNm: number | undefined }) {
  const spread = progress.lastSpreadNm;
  return (
    <Tile label="Spread of last point" value={significant(spread, 2)} unit="nm" stale={isLost()}>
      {spread !== undefined && limitNm !== undefined && (
        <Verdict kind={spread <= limitNm ? 'good' : 'warn'}>{spread <= limitNm ? 'below' : 'over'} {fixed(limitNm)} nm</Verdict>
      )}
    </Tile>
  );
}

// The time that a change is over: of a shorter one nothing is said.
const leastS = 60;
const spanText = (seconds: number) => duration(Math.round(seconds / 60) * 60);

function ZeroTile({ drift }: { drift: ZeroDrift }) {
  const last = drift.nm.map((values) => values[values.length - 1] ?? NaN);
  const most = last.reduce((best, value, i) => (Math.abs(value) > Math.abs(last[best]) || Number.isNaN(last[best]) ? i : best), 0);
  const others = drift.lengths.map((name, i) => `${splitChannel(name).symbol} ${signed(last[i])}`).filter((_, i) => i !== most);
  return (
    <Tile label={`Drift of the zero, ${splitChannel(drift.lengths[most]).symbol}`} value={signed(last[most])} unit="nm" stale={isLost()}>
      {others.length > 0 && <span class="muted">{others.join(', ')} nm</span>}
    </Tile>
  );
}

const spoken = (id: string) => id.charAt(0).toUpperCase() + id.slice(1).replaceAll('-', ' ');
const stem = (device: Device) => device.id.replaceAll('-', '_');

export const setPointOf = (device: Device): Channel | undefined => channel(`${stem(device)}_set_degC`);

export function outputOf(device: Device): Channel | undefined {
  return layout.value.find((one) => one.column.deviceId === device.id && /_(pct|A|W|V)$/.test(one.name));
}

function SupportTile({ device, now }: { device: Device; now: Channel }) {
  const set = setPointOf(device);
  const output = outputOf(device);
  const off = now.value.value - (set?.value.value ?? NaN);
  return (
    <ChannelTile channel={now} label={`${spoken(device.id)}${set ? `, ${fixed(set.value.value, 3)}\u00a0°C` : ''}`}>
      {Math.abs(off) <= settledK(device.id)
        ? <Verdict kind="good">{output ? `settled, ${fixed(output.value.value, 1)} ${unitSign(output.column.unit)}` : 'settled'}</Verdict>
        : <Verdict kind="warn">{signed(off * 1000)} mK off{output && `, ${fixed(output.value.value, 1)} ${unitSign(output.column.unit)}`}</Verdict>}
    </ChannelTile>
  );
}

export function Tiles({ progress, drift, limitNm, airChange }: {
  progress: RunProgress | undefined;
  drift: ZeroDrift | undefined;
  limitNm: number | undefined;
  airChange: { change: number; seconds: number } | undefined; // within the last hour
}) {
  const devices = cell.value?.devices ?? [];
  const names = layout.value.map((one) => one.name);
  const air = channel(airOf(names) ?? '');
  const supports = devices.flatMap((device) => {
    const now = channel(`${stem(device)}_degC`);
    return setPointOf(device) && now ? [{ device, now }] : [];
  });
  const force = devices.map((device) => channel(device.forceChannel)).find((one) => one !== undefined);
  const angles = devices.flatMap((device) => device.angleChannels).map((name) => channel(name)).filter((one) => one !== undefined);
  return (
    <div class="tiles">
      {progress && <SpreadTile progress={progress} limitNm={limitNm} />}
      {drift && drift.hours.length > 0 && drift.lengths.length > 0 && <ZeroTile drift={drift} />}
      {air && (
        <ChannelTile channel={air} label={spoken(splitChannel(air.name).symbol.replaceAll('_', '-'))}>
          {airChange && airChange.seconds >= leastS && <span class="muted">{signed(airChange.change, 3)} °C in {spanText(airChange.seconds)}</span>}
        </ChannelTile>
      )}
      {supports.map((one) => <SupportTile key={one.device.id} {...one} />)}
      {angles.filter((one) => one.stale.value).map((one) => <ChannelTile key={one.name} channel={one} label={`Autocollimator, ${splitChannel(one.name).symbol}`} />)}
      {force && <ChannelTile channel={force} label="Force" />}
    </div>
  );
}
