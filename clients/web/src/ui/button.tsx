// A button acts on release. One that is off stays readable and focusable instead of going grey, and says why (`off`): to a
// screen reader, under the pointer, and to everybody once it is pressed.
import type { ComponentChildren } from 'preact';
import { useId, useState } from 'preact/hooks';
import { commandsOff } from '@/live/commands_off';

export function Button({ kind = 'plain', off, busy, onPress, children, label, submit, small }: {
  kind?: 'main' | 'plain' | 'bad';
  off?: string | undefined; // why it cannot be used now
  busy?: boolean; // sent, not yet confirmed
  onPress?: () => void;
  children: ComponentChildren;
  label?: string; // where the text alone would not tell two buttons apart
  submit?: boolean;
  small?: boolean;
}) {
  const id = useId();
  const [pressedOff, setPressedOff] = useState(false);
  const unusable = off !== undefined || busy === true;
  return (
    <span class="button-box">
      <button
        type={submit ? 'submit' : 'button'}
        class={`button button-${kind}${small ? ' button-small' : ''}`}
        aria-disabled={unusable ? 'true' : undefined}
        aria-busy={busy ? 'true' : undefined}
        aria-describedby={off ? id : undefined}
        aria-label={label}
        title={off}
        onClick={(event) => {
          if (unusable) event.preventDefault();
          else onPress?.();
          setPressedOff(off !== undefined);
        }}
      >
        {children}
      </button>
      {off && <span class={pressedOff ? 'button-off note' : 'sr-only'} id={id}>{off}</span>}
    </span>
  );
}

// A button that changes something in the cell: off, with the reason, while the page is not live.
export function CommandButton(props: Parameters<typeof Button>[0]) {
  return <Button {...props} off={props.off ?? commandsOff.value} />;
}
