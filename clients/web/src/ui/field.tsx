// A labelled input with its unit, its hint and what is wrong with it.
import { useId } from 'preact/hooks';

export function Field({ label, unit, value, onInput, wrong, hint, type = 'text', mono, autofocus, list }: {
  label: string;
  unit?: string;
  value: string;
  onInput: (text: string) => void;
  wrong?: string | undefined;
  hint?: string;
  type?: 'text' | 'search' | 'number' | 'password';
  mono?: boolean;
  autofocus?: boolean;
  list?: string;
}) {
  const id = useId();
  return (
    <div class="field">
      <label for={id}>{label}{unit ? `, ${unit}` : ''}</label>
      <input
        id={id}
        class={mono ? 'mono' : undefined}
        {...(type === 'password' ? { type } : { type: type === 'number' ? 'text' : type, list })}
        inputMode={type === 'number' ? 'decimal' : undefined}
        value={value}
        autoFocus={autofocus}
        autoComplete="off"
        spellcheck={false}
        aria-invalid={wrong ? 'true' : undefined}
        aria-describedby={wrong || hint ? `${id}-says` : undefined}
        onInput={(event) => onInput(event.currentTarget.value)}
      />
      {(wrong || hint) && <span id={`${id}-says`} class={wrong ? 'wrong' : 'note muted'}>{wrong ?? hint}</span>}
    </div>
  );
}

// What a person types as a number: a comma or a true minus will do; undefined: not one.
export function numberTyped(text: string): number | undefined {
  const plain = text.trim().replace('−', '-').replace(',', '.').replace(/[\u2009\s]/g, '');
  if (plain === '' || !/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain)) return undefined;
  return Number(plain);
}
