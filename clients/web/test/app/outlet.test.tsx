// A fault in a view ends with that view: what is around it stays, and another address shows its own.
import { configure, fireEvent, render, screen } from '@testing-library/preact';
import { beforeEach, expect, it, vi } from 'vitest';
import { Outlet } from '@/app/outlet';
import { go, place } from '@/app/router';

configure({ asyncUtilTimeout: 15_000 }); // a busy machine
vi.setConfig({ testTimeout: 30_000 });

let broken = true;
function View() {
  const { path } = place.value;
  if (broken && path === '/runs/17') throw new TypeError('no length');
  return <h1>{path}</h1>;
}
const entry = { name: 'runs', title: 'Runs', key: 'r', load: () => Promise.resolve({ default: View }) };
const show = () => render(<><button>Stop motion</button><Outlet entry={entry} /></>);

beforeEach(() => {
  broken = true;
  vi.spyOn(console, 'error').mockImplementation(() => undefined);
  vi.stubGlobal('scrollTo', () => undefined);
  go('/runs/17');
});

it('says what failed, keeps what is around it, and shows the view again when asked', async () => {
  show();
  expect((await screen.findByRole('alert')).textContent).toContain('The view Runs failed in the page: TypeError: no length.');
  expect(screen.getByRole('button', { name: 'Stop motion' })).toBeTruthy();
  broken = false;
  fireEvent.click(screen.getByRole('button', { name: 'Show it again' }));
  expect(await screen.findByRole('heading', { name: '/runs/17' })).toBeTruthy();
});

it('shows another address of the same view', async () => {
  show();
  await screen.findByRole('alert');
  go('/runs/18');
  expect(await screen.findByRole('heading', { name: '/runs/18' })).toBeTruthy();
  expect(screen.queryByRole('alert')).toBeNull();
});

it('catches a fault of a view that was shown already', async () => {
  go('/runs/18');
  show();
  await screen.findByRole('heading', { name: '/runs/18' });
  go('/runs/17');
  expect(await screen.findByRole('alert')).toBeTruthy();
});
