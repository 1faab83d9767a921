// A channel's latest value with its unit, hatched and with its age when it is old.
import { useComputed } from '@preact/signals';
import { fixed } from '@/format/numbers';
import { lengthText } from '@/format/lengths';
import { liveDigits, unitSign } from '@/format/units';
import type { Channel } from '@/live/channels';
import { StaleNote } from '@/ui/tile';

export function LiveValue({ channel, big, bare }: { channel: Channel; big?: boolean; bare?: boolean }) {
  const unit = channel.column.unit;
  const shown = useComputed(() => (unit === 'mm' ? lengthText(channel.value.value) : { text: fixed(channel.value.value, liveDigits(unit)), unit: unitSign(unit) }));
  const text = useComputed(() => shown.value.text);
  const sign = useComputed(() => shown.value.unit);
  const stale = channel.stale.value;
  return (
    <span class={`live-value${big ? ' live-big' : ''}${stale ? ' stale' : ''}`}>
      <span class="live">{text}</span> <span class="unit">{sign}</span>
      {!bare && stale && <span class="live-stale"><StaleNote channel={channel} /></span>}
    </span>
  );
}
