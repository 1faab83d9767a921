// A field for a formula: the ARIA combobox, below it what the daemon says of the formula on these data, and below that a list
// of what could follow. What was typed stays: an offer takes its place only after an arrow key or the mouse chose it.
import type { ComponentChildren } from 'preact';
import { useEffect, useId, useRef, useState } from 'preact/hooks';
import { count } from '@/format/numbers';
import { Mark } from '@/ui/verdict';
import { completionAt, take, type Completion, type Known } from './complete';
import { useFormulaCheck, type FormulaData, type FormulaState } from './use_check';
import './formula.css';

// "q ~ " is no mistake yet: nobody has typed what the outputs depend on.
const isBegun = (text: string) => text.replace(/^[^~]*~/, '').trim() !== '';

const none = -1; // no offer is chosen: Tab and Enter leave the text as it is
const nothing: Known = { channels: [], effects: [] };

export function FormulaField({ label, value, onInput, data, onEnter, children }: {
  label: string;
  value: string;
  onInput: (text: string) => void;
  data: FormulaData | undefined; // undefined: no data chosen yet
  onEnter?: () => void;
  children?: ComponentChildren; // what failed with this formula: stands above the list, which therefore never covers it
}) {
  const id = useId();
  const input = useRef<HTMLInputElement>(null);
  const [open, setOpen] = useState<Completion>();
  const [active, setActive] = useState(none);
  const state = useFormulaCheck(value, data);
  const known = state.check ?? nothing;
  const offers = open?.offers ?? [];

  // Offers wanted now: while typing, for a word that is no name yet; after an arrow key, always.
  const wanted = useRef<'no' | 'typing' | 'asked'>('no');
  const look = (text: string, caret: number, how: 'typing' | 'asked') => {
    wanted.current = how;
    const found = completionAt(text, caret, known);
    setOpen(found.offers.length > 0 && (how === 'asked' || !found.exact) ? found : undefined);
    setActive(none);
  };
  const away = () => {
    wanted.current = 'no';
    setOpen(undefined);
  };
  // What the daemon knows may come after the key that asked for it.
  useEffect(() => {
    if (wanted.current !== 'no' && !open && document.activeElement === input.current)
      look(value, input.current?.selectionStart ?? value.length, wanted.current);
  }, [state.check]);
  const choose = (index: number) => {
    if (!open) return;
    const next = take(value, open, open.offers[index]);
    onInput(next.text);
    away();
    requestAnimationFrame(() => {
      input.current?.focus();
      input.current?.setSelectionRange(next.caret, next.caret);
    });
  };
  const onKey = (event: KeyboardEvent) => {
    if (event.key === 'Escape' && open) {
      away();
      event.preventDefault();
    } else if ((event.key === 'ArrowDown' || event.key === 'ArrowUp') && !open) {
      look(value, input.current?.selectionStart ?? value.length, 'asked');
      event.preventDefault();
    } else if (open && (event.key === 'ArrowDown' || event.key === 'ArrowUp')) {
      setActive((at) => (event.key === 'ArrowDown' ? (at + 1) % offers.length : at <= 0 ? offers.length - 1 : at - 1));
      event.preventDefault();
    } else if (open && active !== none && (event.key === 'Enter' || event.key === 'Tab')) {
      choose(active);
      event.preventDefault();
    } else if (event.key === 'Enter') {
      away();
      if (!onEnter) return; // the form takes it
      event.preventDefault(); // otherwise the form would be submitted as well: two fits
      onEnter();
    }
  };
  const wrong = isBegun(value) && state.of === value && state.check?.problem ? state.check.problem : undefined;
  return (
    <div class="field formula">
      <label for={id}>{label}</label>
      <input
        ref={input}
        id={id}
        class="mono"
        role="combobox"
        aria-autocomplete="list"
        aria-expanded={open ? 'true' : 'false'}
        aria-controls={`${id}-list`}
        aria-activedescendant={open && active !== none ? `${id}-${active}` : undefined}
        aria-invalid={wrong ? 'true' : undefined}
        aria-describedby={`${id}-says`}
        autoComplete="off"
        autoCapitalize="off"
        spellcheck={false}
        value={value}
        onInput={(event) => {
          onInput(event.currentTarget.value);
          look(event.currentTarget.value, event.currentTarget.selectionStart ?? 0, 'typing');
        }}
        onKeyDown={onKey}
        onBlur={away}
      />
      <div id={`${id}-says`} class="formula-says" role="status">
        <Says state={state} text={value} data={data} />
      </div>
      {children}
      <ul id={`${id}-list`} class="formula-list" role="listbox" aria-label={`${label}: what could follow`} hidden={!open}>
        {offers.map((offer, i) => (
          <li
            key={offer.label}
            id={`${id}-${i}`}
            role="option"
            aria-selected={i === active ? 'true' : 'false'}
            ref={(element) => { if (i === active) element?.scrollIntoView?.({ block: 'nearest' }); }}
            onMouseDown={(event) => { event.preventDefault(); choose(i); }}
          >
            <span class="mono">{offer.label}</span>
            <span class="note muted">{offer.detail}</span>
          </li>
        ))}
      </ul>
    </div>
  );
}

function Says({ state, text, data }: { state: FormulaState; text: string; data: FormulaData | undefined }) {
  if (!data || (data.runIds.length === 0 && !data.csv)) return <p class="note muted">Choose data first: a formula is checked against their channels.</p>;
  if (state.failure) return <p class="note wrong"><Mark kind="bad" /> {state.failure.message}</p>;
  const check = state.check;
  if (!check || (state.waiting && state.of !== text)) return <p class="note muted">Checking …</p>;
  if (!isBegun(text)) return <p class="note muted">For example q ~ x + x^2 + R; press ↓ for what could follow.</p>;
  if (check.problem) return <pre class="note formula-problem"><Mark kind="bad" /> {check.problem}</pre>;
  const full = check.rank === check.columnCount;
  return (
    <>
      <p class="note">
        <Mark kind={full ? 'good' : 'warn'} />{' '}
        {count(check.terms.length)} terms for {check.outputs.join(', ')}; {count(check.calibrationRowCount)} calibration and{' '}
        {count(check.validationRowCount)} validation rows{check.droppedRowCount > 0n && `, ${count(check.droppedRowCount)} left out for missing values`}; rank{' '}
        {check.rank} of {check.columnCount}
      </p>
      {check.lookAlikes.length > 0 && (
        <details class="note">
          <summary>{check.lookAlikes.length === 1 ? 'one term' : `${check.lookAlikes.length} terms`} these rows cannot tell apart</summary>
          <ul>{check.lookAlikes.map((sentence) => <li>{sentence}</li>)}</ul>
        </details>
      )}
      <details class="note">
        <summary>terms offered</summary>
        <p class="mono formula-terms">{check.terms.join('  ')}</p>
      </details>
    </>
  );
}
