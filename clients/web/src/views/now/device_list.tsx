// Every device: whether it answers, how fast, and what it last complained of.
import { Device_Link, type Device } from '@/api/gen/driftwise/v1/cell_service_pb';
import { fixed } from '@/format/numbers';
import { secondsOf } from '@/format/time';
import { connection } from '@/live/connection';
import { cell } from '@/live/state';
import { Panel } from '@/ui/panel';
import { Verdict, type VerdictKind } from '@/ui/verdict';

const links: Record<Device_Link, readonly [VerdictKind, string]> = {
  [Device_Link.UNSPECIFIED]: ['idle', 'unknown'],
  [Device_Link.DISCONNECTED]: ['warn', 'not connected'],
  [Device_Link.CONNECTING]: ['warn', 'connecting'],
  [Device_Link.CONNECTED]: ['good', 'answers'],
  [Device_Link.FAILED]: ['bad', 'does not answer'],
};

function DeviceLine({ device }: { device: Device }) {
  const isKnown = connection.value.phase !== 'lost' || device.link !== Device_Link.CONNECTED;
  const [kind, word] = isKnown ? links[device.link] : (['idle', 'not known'] as const);
  const latency = secondsOf(device.lastLatencyDuration);
  return (
    <li>
      <span class="strong">{device.id}</span>
      <Verdict kind={kind}>{word}{kind === 'good' && latency !== undefined && ` in ${fixed(latency * 1000, latency < 0.01 ? 1 : 0)} ms`}</Verdict>
      {isKnown && kind !== 'good' && device.lastError && <span class="note muted">{device.lastError}</span>}
    </li>
  );
}

export function DeviceList() {
  const devices = cell.value?.devices ?? [];
  if (devices.length === 0) return null;
  const lost = connection.value.phase === 'lost';
  const well = devices.filter((device) => device.link === Device_Link.CONNECTED).length;
  return (
    <Panel class={lost ? 'stale' : ''} title={`Devices: ${lost ? 'not known which' : well} of ${devices.length} answer`}>
      <ul class="devices">{devices.map((device) => <DeviceLine key={device.id} device={device} />)}</ul>
    </Panel>
  );
}
