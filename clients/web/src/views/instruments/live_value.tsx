// A channel's latest value with its unit, hatched and with its age when it is old. One that has no limit (lengths are read in runs
// only) says when it was read once that is no longer now.
import { useComputed } from '@preact/signals';
import { fixed } from '@/format/numbers';
import { lengthText } from '@/format/lengths';
import { duration } from '@/format/time';
import { liveDigits, unitSign } from '@/format/units';
import type { Channel } from '@/live/channels';
import { StaleNote } from '@/ui/tile';

const nowS = 30; // cell time

export function LiveValue({ channel, big, bare }: { channel: Channel; big?: boolean; bare?: boolean }) {
  const unit = channel.column.unit;
  const shown = useComputed(() => (unit === 'mm' ? lengthText(channel.value.value) : { text: fixed(channel.value.value, liveDigits(unit)), unit: unitSign(unit) }));
  const text = useComputed(() => shown.value.text);
  const sign = useComputed(() => shown.value.unit);
  const stale = channel.stale.value;
  const old = useComputed(() => channel.ageS.value > nowS && Number.isFinite(channel.ageS.value));
  const read = useComputed(() => `read ${duration(channel.ageS.value)} ago`);
  return (
    <span class={`live-value${big ? ' live-big' : ''}${stale ? ' stale' : ''}`}>
      <span class="live">{text}</span> <span class="unit">{sign}</span>
      {!bare && stale && <span class="live-stale"><StaleNote channel={channel} /></span>}
      {!bare && big && !stale && old.value && <span class="live-stale note muted">{read}</span>}
    </span>
  );
}
