// The formula box under the keys of a person: what was typed stays unless an offer was chosen.
import { configure, fireEvent, render, screen } from '@testing-library/preact';
import { useState } from 'preact/hooks';
import { beforeEach, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { FormulaField } from '@/formula/formula_field';
import { fakeDaemon } from '../fake/daemon';

vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });

const fit = vi.fn();
const submit = vi.fn();
const data = { runIds: [1n] };

function Box() {
  const [text, setText] = useState('');
  return (
    <form onSubmit={(event) => { event.preventDefault(); submit(); }}>
      <FormulaField label="Formula" value={text} onInput={setText} data={data} onEnter={() => fit(text)}>
        {text && <p>no fit yet</p>}
      </FormulaField>
      <button type="submit">Fit</button>
    </form>
  );
}

const box = () => screen.getByRole<HTMLInputElement>('combobox');
const type = (text: string) => {
  fireEvent.input(box(), { target: { value: text, selectionStart: text.length } });
};
const offered = () => screen.queryAllByRole('option').map((option) => option.firstElementChild!.textContent);
// True: the browser's own action (focus goes on, the form is submitted) was left to it.
const press = (key: string) => fireEvent.keyDown(box(), { key });

beforeEach(async () => {
  fit.mockClear();
  submit.mockClear();
  useTransport(fakeDaemon({ problem: (formula) => (formula.endsWith('t0') ? "unknown channel 't0'" : '') }));
  render(<Box />);
  type('q ~ z'); // a name of the data: what the daemon knows of them has come once its count is shown
  await screen.findByText(/16 terms|terms for/);
});

it('leaves a finished formula alone: an exact name offers nothing, Tab goes on, Enter fits once', async () => {
  type('q ~ t0');
  await vi.waitFor(() => expect(offered()).toContain('t07'));
  type('q ~ T'); // T is a short form of its own, though t07 begins with the same letter
  expect(offered()).toEqual([]);
  expect(press('Tab')).toBe(true);
  expect(box().value).toBe('q ~ T');
  expect(press('Enter')).toBe(false);
  expect(fit.mock.calls).toEqual([['q ~ T']]);
  expect(submit).not.toHaveBeenCalled();
});

it('completes with Tab only what an arrow key chose', async () => {
  type('q ~ t0');
  await vi.waitFor(() => expect(offered()).toContain('t07'));
  expect(screen.queryByRole('option', { selected: true })).toBeNull();
  expect(box().getAttribute('aria-activedescendant')).toBeNull();
  expect(press('Tab')).toBe(true);
  expect(box().value).toBe('q ~ t0');
  press('ArrowDown');
  const chosen = screen.getByRole('option', { selected: true }).firstElementChild!.textContent;
  expect(press('Tab')).toBe(false);
  expect(box().value).toBe(`q ~ ${chosen}`);
  expect(fit).not.toHaveBeenCalled();
});

it('fits with Enter while the list is open and nothing in it was chosen', async () => {
  type('q ~ t0');
  await vi.waitFor(() => expect(offered()).toContain('t07'));
  press('Enter');
  expect(fit.mock.calls).toEqual([['q ~ t0']]);
  expect(offered()).toEqual([]);
});

it('shows what is wrong while the list is open, above it', async () => {
  type('q ~ t0');
  const problem = await screen.findByText(/unknown channel 't0'/);
  expect(offered()).toContain('t07');
  const list = screen.getByRole('listbox');
  for (const message of [problem, screen.getByText('no fit yet')])
    expect(message.compareDocumentPosition(list) & Node.DOCUMENT_POSITION_FOLLOWING).toBeTruthy();
  expect(list.parentElement!.contains(problem)).toBe(true); // the list hangs below the box that holds both
  expect(box().getAttribute('aria-invalid')).toBe('true');
});
