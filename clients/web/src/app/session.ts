// Who sits here. Where the daemon asks for a log-in, its session says so: name and role, proved by a token or a link that works
// once, kept in a cookie that no script can read. Elsewhere the name is typed once, kept by this browser and not verified.
import { signal } from '@preact/signals';
import { go } from './router';
import { remembered } from './storage';

export interface Session {
  state: 'open' | 'in' | 'out'; // open: nobody has to prove anything here
  name?: string;
  role?: string;
  ends?: string; // ISO 8601, UTC
  message?: string; // why nobody is logged in, or was refused
}

export const session = signal<Session>({ state: 'open' });
// Whether names in the record are proved; else they are as typed.
export const namesAreProved = (): boolean => session.value.state !== 'open';
export const operatorName = signal(remembered.get('operator') ?? '');

export function setOperatorName(name: string): void {
  operatorName.value = name.trim().slice(0, 64);
  remembered.set('operator', operatorName.value);
}

function take(next: Session): void {
  session.value = next;
  operatorName.value = next.state === 'in' ? next.name ?? '' : remembered.get('operator') ?? '';
}

async function ask(method: 'GET' | 'POST' | 'DELETE', body?: object): Promise<{ ok: boolean; said: Session }> {
  const answer = await fetch('/session', {
    method,
    cache: 'no-store',
    ...(body && { headers: { 'content-type': 'application/json' }, body: JSON.stringify(body) }),
  });
  return { ok: answer.ok, said: (await answer.json()) as Session };
}

// The address of `driftwise open`: /log-in#dwl_...; what stands behind the # is sent to nobody but by us.
function linkOfAddress(): string | undefined {
  if (location.pathname !== '/log-in') return undefined;
  const link = location.hash.slice(1);
  go('/now', 'replace');
  return link.startsWith('dwl_') ? link : undefined;
}

// Before anything else is asked of the daemon. One that cannot be asked leaves the page open: it says itself that it is not live.
export async function enter(): Promise<void> {
  const link = linkOfAddress();
  try {
    const { ok, said } = link ? await ask('POST', { link }) : await ask('GET');
    take(ok ? said : { state: 'out', ...(said.message && { message: said.message }) });
  } catch {
    take({ state: 'open' });
  }
}

// The sentence of a refusal, or nothing: the page loads afresh as whoever it is now.
export async function logIn(token: string): Promise<string | undefined> {
  try {
    const { ok, said } = await ask('POST', { token: token.trim() });
    if (!ok) return said.message ?? 'The daemon refused the token and gave no reason';
  } catch {
    return 'The daemon did not answer; try again when it runs';
  }
  location.reload();
  return undefined;
}

export async function logOut(): Promise<void> {
  try {
    take((await ask('DELETE')).said);
  } catch {
    // still logged in: the page says that it is not live
  }
  location.reload();
}

// A call was refused because nobody is logged in: the session ended, here or in another tab.
let looking = false;
export async function sessionLost(): Promise<void> {
  if (looking || session.value.state === 'out') return;
  looking = true;
  try {
    const { said } = await ask('GET');
    take(said);
  } catch {
    // the daemon is away: the page says that it is not live
  } finally {
    looking = false;
  }
}
