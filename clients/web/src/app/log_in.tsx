// In the place of the page where the daemon asks who somebody is and nobody is logged in.
import { useState } from 'preact/hooks';
import { Button } from '@/ui/button';
import { Field } from '@/ui/field';
import { logIn, session } from './session';

export function LogIn() {
  const [token, setToken] = useState('');
  const [refused, setRefused] = useState<string>();
  const [busy, setBusy] = useState(false);
  const send = async () => {
    setBusy(true);
    setRefused(await logIn(token));
    setBusy(false);
  };
  const says = refused ?? session.value.message;
  return (
    <section class="panel log-in" aria-labelledby="log-in-title">
      <h1 id="log-in-title">Log in</h1>
      <form
        class="stack"
        onSubmit={(event) => {
          event.preventDefault();
          if (token.trim() !== '' && !busy) void send();
        }}
      >
        {says && <p role={refused ? 'alert' : 'status'} class={refused ? 'wrong' : 'muted'}>{says}</p>}
        <Field label="Token" type="password" mono autofocus value={token} onInput={setToken} hint="Begins with dwt_. An admin makes it: driftwise token create NAME --role ROLE" />
        <div class="actions"><Button kind="main" submit busy={busy} off={token.trim() === '' ? 'Paste a token first' : undefined}>Log in</Button></div>
      </form>
      <p class="note muted">On the measuring computer <code>driftwise open</code> opens this page without a token.</p>
      <p class="note muted">Nobody can stop a motion here before the log-in: use the emergency switch, or another desk.</p>
    </section>
  );
}
