// Asks once before something moves, heats or discards. The harmless button has the focus, Esc means it. A question ends with the
// view that asks it and when the page loads afresh, and is not answered while the page is not live.
import { signal, type ReadonlySignal } from '@preact/signals';
import type { ComponentChildren } from 'preact';
import { useEffect } from 'preact/hooks';
import { place } from '@/app/router';
import { epoch } from '@/live/epoch';
import { typed } from '@/app/storage';
import { Button, CommandButton } from './button';
import { Dialog } from './dialog';
import { Field } from './field';

export interface Question {
  title: string; // "Abort run 17?"
  facts?: readonly (readonly [string, ComponentChildren])[]; // object, from -> to with units, duration, who is affected
  words?: ComponentChildren;
  verb: string; // "Abort run 17"
  keep: string; // "Keep running"
  bad?: boolean; // the verb discards or ends something
  off?: ReadonlySignal<string | undefined>; // why the verb cannot be pressed yet
}

const asked = signal<{ question: Question; answer: (yes: boolean) => void } | undefined>(undefined);

export function confirm(question: Question): Promise<boolean> {
  asked.value?.answer(false);
  return new Promise((answer) => (asked.value = { question, answer }));
}

// A reason in writing, among the facts of a question whose `off` waits for it.
// id: of what is reasoned about; text that was typed for it stays until the question is answered with its verb.
export function ReasonField({ id, label, reason }: { id: string; label: string; reason: { value: string } }) {
  const key = `reason.${id}`;
  useEffect(() => void (reason.value ||= typed.get(key) ?? ''), [key]);
  return <Field label={label} value={reason.value} onInput={(text) => typed.set(key, (reason.value = text))} />;
}

export const reasonTaken = (id: string): void => typed.set(`reason.${id}`, '');

// Stands once in the shell.
export function ConfirmDialog() {
  const now = asked.value;
  const { path } = place.value;
  useEffect(() => () => {
    asked.peek()?.answer(false);
    asked.value = undefined;
  }, [path, epoch.value]);
  const answer = (yes: boolean) => {
    asked.value = undefined;
    now?.answer(yes);
  };
  return (
    <Dialog subject={now} titleId="confirm-title" onEnd={() => answer(false)}>
      {now && (
        <>
          <h2 id="confirm-title">{now.question.title}</h2>
          {now.question.words && <p>{now.question.words}</p>}
          {now.question.facts && (
            <dl class="facts">
              {now.question.facts.map(([what, value]) => [<dt>{what}</dt>, <dd>{value}</dd>])}
            </dl>
          )}
          <div class="actions">
            <span data-harmless><Button onPress={() => answer(false)}>{now.question.keep}</Button></span>
            <CommandButton kind={now.question.bad ? 'bad' : 'main'} off={now.question.off?.value} onPress={() => answer(true)}>{now.question.verb}</CommandButton>
          </div>
        </>
      )}
    </Dialog>
  );
}
