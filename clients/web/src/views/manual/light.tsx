// Light level and spots of the optical instruments, live, with the most seen since the page was opened.
import { useEffect, useState } from 'preact/hooks';
import { fixed } from '@/format/numbers';
import { kindOf, splitChannel, unitSign } from '@/format/units';
import { layout } from '@/live/channels';
import { Button } from '@/ui/button';
import { Panel } from '@/ui/panel';
import { Empty } from '@/ui/states';
import { Table } from '@/ui/table';
import { StaleNote } from '@/ui/tile';

const unitOf = (name: string) => unitSign(splitChannel(name).unit);
// is_light_level() of server/core/channel.h.
const isLightLevel = (name: string) => /(^|[._])level_([^.]*_)?pct$/.test(name);
export const isOptical = (name: string) => isLightLevel(name) || name.endsWith('_arcsec') || (name.endsWith('_mm') && kindOf(name) !== 'motor');
const digitsOf = (name: string) => (name.endsWith('_mm') ? 6 : name.endsWith('_pct') ? 1 : 2);
const sizeOf = (name: string, value: number) => (name.endsWith('_pct') ? value : Math.abs(value));

export function Light() {
  const channels = layout.value.filter((one) => isOptical(one.name));
  const [most, setMost] = useState<Record<string, number>>({});
  const now = channels.map((one) => [one.name, one.value.value] as const);
  useEffect(() => {
    const risen = now.filter(([name, value]) => Number.isFinite(value) && sizeOf(name, value) > (most[name] ?? -Infinity));
    if (risen.length > 0) setMost((old) => ({ ...old, ...Object.fromEntries(risen.map(([name, value]) => [name, sizeOf(name, value)])) }));
  });
  return (
    <Panel title="Light, lengths and spots" actions={<Button small onPress={() => setMost({})}>Forget the most seen</Button>}>
      {channels.length === 0 && <Empty>No optical instrument has been read yet.</Empty>}
      {channels.length > 0 && (
        <Table
          caption="Optical instruments now"
          rows={channels}
          keyOf={(one) => one.name}
          columns={[
            { title: 'instrument', of: (one) => one.column.deviceId },
            { title: 'channel', of: (one) => splitChannel(one.name).symbol },
            { title: 'now', number: true, of: (one) => <><span class={one.stale.value ? 'stale muted' : ''}>{fixed(one.value.value, digitsOf(one.name))} {unitOf(one.name)}</span>{one.stale.value && <> <StaleNote channel={one} /></>}</> },
            { title: 'most seen', number: true, of: (one) => `${fixed(most[one.name], digitsOf(one.name))} ${unitOf(one.name)}` },
          ]}
        />
      )}
    </Panel>
  );
}
