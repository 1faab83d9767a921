// One number that can be read across a room: label, value with its unit, and what it means as shape and word.
import type { ComponentChildren } from 'preact';
import type { ReadonlySignal } from '@preact/signals';
import { useComputed } from '@preact/signals';
import { fixed } from '@/format/numbers';
import { duration } from '@/format/time';
import { liveDigits, unitSign } from '@/format/units';
import type { Channel } from '@/live/channels';
import { Verdict } from './verdict';

export function Tile({ label, value, unit, children, stale }: {
  label: ComponentChildren;
  value: ComponentChildren | ReadonlySignal<string>;
  unit?: string | ReadonlySignal<string>;
  children?: ComponentChildren; // the line below
  stale?: boolean;
}) {
  return (
    <div class={`tile${stale ? ' stale' : ''}`}>
      <div class="label">{label}</div>
      <div class="value"><span>{value}</span>{unit && <span class="unit">{unit}</span>}</div>
      {children && <div class="note">{children}</div>}
    </div>
  );
}

// How old a stale value is, as it grows.
export function StaleNote({ channel }: { channel: Channel }) {
  const age = useComputed(() => (Number.isFinite(channel.ageS.value) ? `stale: ${duration(channel.ageS.value)} old` : 'stale: never read'));
  return <Verdict kind="warn">{age}</Verdict>;
}

// The latest value of a channel, painted four times a second without drawing anything else anew.
export function ChannelTile({ channel, label, children }: { channel: Channel; label: ComponentChildren; children?: ComponentChildren }) {
  const unit = channel.column.unit;
  const text = useComputed(() => fixed(channel.value.value, liveDigits(unit)));
  const stale = channel.stale.value;
  return (
    <Tile label={label} value={text} unit={unitSign(unit)} stale={stale}>
      {stale ? <StaleNote channel={channel} /> : children}
    </Tile>
  );
}
