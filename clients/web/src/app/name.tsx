// Asks for the operator's name: once, before the first command. It stands in the record beside what was done.
import { signal } from '@preact/signals';
import { useEffect, useRef, useState } from 'preact/hooks';
import { Button } from '@/ui/button';
import { Field } from '@/ui/field';
import { operatorName, setOperatorName } from './session';

const asked = signal<((given: boolean) => void) | undefined>(undefined);

export function askName(): Promise<boolean> {
  asked.value?.(false);
  return new Promise((answer) => (asked.value = answer));
}

// true: there is a name now. Every command goes through here.
export const named = (): Promise<boolean> => (operatorName.value === '' ? askName() : Promise.resolve(true));

export function NameDialog() {
  const dialog = useRef<HTMLDialogElement>(null);
  const now = asked.value;
  useEffect(() => {
    if (now) dialog.current?.showModal();
    else dialog.current?.close();
  }, [now]);
  const answer = (given: boolean) => {
    asked.value = undefined;
    now?.(given);
  };
  return (
    <dialog ref={dialog} aria-labelledby="name-title" onCancel={(event) => { event.preventDefault(); answer(false); }}>
      {now && <NameForm answer={answer} />}
    </dialog>
  );
}

function NameForm({ answer }: { answer: (given: boolean) => void }) {
  const [text, setText] = useState(operatorName.value);
  return (
    <form
      onSubmit={(event) => {
        event.preventDefault();
        if (text.trim() === '') return;
        setOperatorName(text);
        answer(true);
      }}
    >
      <h2 id="name-title">Who are you?</h2>
      <Field label="Your name" value={text} onInput={setText} autofocus hint="Stands in the record with everything you change. It is not verified; this browser keeps it" />
      <div class="actions">
        <Button onPress={() => answer(false)}>Cancel</Button>
        <Button kind="main" submit off={text.trim() === '' ? 'Type a name first' : undefined}>Use this name</Button>
      </div>
    </form>
  );
}
