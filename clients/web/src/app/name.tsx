// Asks for the operator's name: once, before the first command. It stands in the record beside what was done.
import { signal } from '@preact/signals';
import { useState } from 'preact/hooks';
import { Button } from '@/ui/button';
import { Dialog } from '@/ui/dialog';
import { dateClock } from '@/format/time';
import { Field } from '@/ui/field';
import { logOut, operatorName, session, setOperatorName } from './session';

const asked = signal<((given: boolean) => void) | undefined>(undefined);

export function askName(): Promise<boolean> {
  asked.value?.(false);
  return new Promise((answer) => (asked.value = answer));
}

// true: there is a name now. Every command goes through here.
export const named = (): Promise<boolean> => (operatorName.value === '' ? askName() : Promise.resolve(true));

export function NameDialog() {
  const now = asked.value;
  const answer = (given: boolean) => {
    asked.value = undefined;
    now?.(given);
  };
  return (
    <Dialog subject={now} titleId="name-title" onEnd={() => answer(false)}>
      {now && (session.value.state === 'in' ? <WhoIsLoggedIn close={() => answer(true)} /> : <NameForm answer={answer} />)}
    </Dialog>
  );
}

const mays: Record<string, string> = {
  viewer: 'sees everything and may stop every motion',
  controller: 'sees, stops, and asks for targets',
  operator: 'also moves, runs, confirms and acknowledges',
  engineer: 'also changes models, plans, data sets and corrections',
  admin: 'may do everything, tokens included',
};

// A log-in proves the name: it is not typed, and who may do what stands beside it.
function WhoIsLoggedIn({ close }: { close: () => void }) {
  const { name, role = '', ends } = session.value;
  return (
    <>
      <h2 id="name-title">{name}</h2>
      <dl class="facts">
        <dt>Role</dt><dd>{role}{mays[role] && `: ${mays[role]}`}</dd>
        {ends && <><dt>Logged in until</dt><dd>{dateClock(Date.parse(ends))}</dd></>}
      </dl>
      <div class="actions">
        <Button onPress={close}>Close</Button>
        <Button kind="main" onPress={() => void logOut()}>Log out</Button>
      </div>
    </>
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
