// The page's log-in, before a daemon that is a list of answers.
import { fireEvent, render, screen } from '@testing-library/preact';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { LogIn } from '@/app/log_in';
import { PageBars } from '@/app/page_bars';
import { serverTimeMs } from '@/live/connection';
import { NameDialog, askName } from '@/app/name';
import { place } from '@/app/router';
import { enter, operatorName, session, sessionLost, setOperatorName } from '@/app/session';

interface Asked { method: string; body?: unknown }
let asked: Asked[];

function daemon(...answers: { status?: number; json: object }[]): void {
  asked = [];
  vi.stubGlobal('fetch', vi.fn((url: string, init: RequestInit) => {
    expect(url).toBe('/session');
    asked.push({ method: init.method!, ...(init.body ? { body: JSON.parse(init.body as string) as unknown } : {}) });
    const { status = 200, json } = answers.shift()!;
    return Promise.resolve(new Response(JSON.stringify(json), { status }));
  }));
}

beforeEach(() => {
  history.replaceState(null, '', '/now');
  setOperatorName('');
  session.value = { state: 'open' };
});
afterEach(() => vi.unstubAllGlobals());

test('where nobody has to log in, the typed name stands', async () => {
  setOperatorName('Anna');
  daemon({ json: { state: 'open', role: 'admin' } });
  await enter();
  expect(session.value.state).toBe('open');
  expect(operatorName.value).toBe('Anna');
});

test('a session gives the name and role, whatever was typed', async () => {
  setOperatorName('Anna');
  daemon({ json: { state: 'in', name: 'vera', role: 'viewer', ends: '2026-11-22T20:00:00Z' } });
  await enter();
  expect(operatorName.value).toBe('vera');
  expect(session.value.role).toBe('viewer');
});

test('the link of the address logs in once and does not stay in the address', async () => {
  history.replaceState(null, '', '/log-in#dwl_secret');
  daemon({ json: { state: 'in', name: 'root', role: 'admin' } });
  await enter();
  expect(asked).toEqual([{ method: 'POST', body: { link: 'dwl_secret' } }]);
  expect(location.pathname + location.hash).toBe('/now');
  expect(place.value.path).toBe('/now');
  expect(session.value.state).toBe('in');
});

test('a used link is refused with the daemon’s sentence', async () => {
  history.replaceState(null, '', '/log-in#dwl_used');
  daemon({ status: 401, json: { reason: 'BAD_TOKEN', message: 'this link was used before' } });
  await enter();
  render(<LogIn />);
  expect(screen.getByText('this link was used before')).toBeTruthy();
});

test('a wrong token is said and stays typed', async () => {
  daemon({ status: 401, json: { reason: 'BAD_TOKEN', message: 'the token is not good' } });
  session.value = { state: 'out', message: 'nobody is logged in here' };
  render(<LogIn />);
  expect(screen.getByRole('status').textContent).toBe('nobody is logged in here');
  const field = screen.getByLabelText('Token') as HTMLInputElement;
  expect(field.type).toBe('password');
  fireEvent.input(field, { target: { value: ' dwt_wrong ' } });
  fireEvent.click(screen.getByRole('button', { name: 'Log in' }));
  expect((await screen.findByRole('alert')).textContent).toBe('the token is not good');
  expect(asked).toEqual([{ method: 'POST', body: { token: 'dwt_wrong' } }]);
  expect(field.value).toBe(' dwt_wrong ');
});

test('who is logged in sees name, role and what it may do, and can log out', async () => {
  session.value = { state: 'in', name: 'vera', role: 'viewer', ends: '2026-11-22T20:00:00Z' };
  render(<NameDialog />);
  void askName();
  expect(await screen.findByText('viewer: sees everything and may stop every motion')).toBeTruthy();
  expect(await screen.findByRole('button', { name: 'Log out' })).toBeTruthy();
});

test('a refused call finds out that the session has ended', async () => {
  session.value = { state: 'in', name: 'vera', role: 'viewer' };
  daemon({ json: { state: 'out', message: 'the session has ended' } });
  await sessionLost();
  expect(session.value).toEqual({ state: 'out', message: 'the session has ended' });
});

test('a name full of markup is text', async () => {
  const hostile = '<img src=x onerror=alert(1)><script>alert(2)</script>';
  session.value = { state: 'in', name: hostile, role: 'viewer' };
  render(<NameDialog />);
  void askName();
  expect((await screen.findByRole('heading')).textContent).toBe(hostile);
  expect(document.querySelector('img, script')).toBeNull();
});

test('a session that is about to end says so, and that Stop ends with it', () => {
  const ends = Date.UTC(2026, 10, 22, 20);
  session.value = { state: 'in', name: 'vera', role: 'viewer', ends: '2026-11-22T20:00:00Z' };
  serverTimeMs.value = ends - 11 * 60e3;
  const { unmount } = render(<PageBars />);
  expect(screen.queryByText(/Stop motion with it/)).toBeNull();
  unmount();
  serverTimeMs.value = ends - 9 * 60e3;
  render(<PageBars />);
  expect(screen.getByRole('alert').textContent).toContain('ends at 20:00:00 UTC');
  serverTimeMs.value = undefined;
});
