// A question before something moves: with its view, and while the page is live.
import { act, configure, fireEvent, render, screen } from '@testing-library/preact';
import { signal } from '@preact/signals';
import { beforeEach, expect, it, vi } from 'vitest';
import { go } from '@/app/router';
import { connection } from '@/live/connection';
import { epoch } from '@/live/epoch';
import { confirm, ConfirmDialog, ReasonField, reasonTaken } from '@/ui/confirm';

vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });

beforeEach(() => {
  sessionStorage.clear();
  go('/targets?x=1');
  connection.value = { phase: 'live' };
  render(<ConfirmDialog />);
});

const question = { title: 'Move the robot there?', verb: 'Move there', keep: 'Stay' };

it('ends with the view that asked it, and not with a change of its query', async () => {
  let answer: boolean | undefined;
  act(() => void confirm(question).then((yes) => (answer = yes)));
  act(() => go('/targets?x=2'));
  expect(screen.getByText('Move there')).toBeTruthy();
  act(() => go('/now'));
  await act(async () => undefined);
  expect(screen.queryByText('Move there')).toBeNull();
  expect(answer).toBe(false);
});
it('ends when another record stands behind the daemon', async () => {
  let answer: boolean | undefined;
  act(() => void confirm(question).then((yes) => (answer = yes)));
  act(() => void epoch.value++);
  await act(async () => undefined);
  expect(screen.queryByText('Move there')).toBeNull();
  expect(answer).toBe(false);
});
it('cannot be answered while the page is not live', () => {
  act(() => void confirm(question));
  act(() => void (connection.value = { phase: 'lost', lastMs: Date.UTC(2026, 0, 1, 10, 21, 7) }));
  const verb = screen.getByText('Move there').closest('button')!;
  expect(verb.getAttribute('aria-disabled')).toBe('true');
  expect(verb.title).toMatch(/not live since/);
  fireEvent.click(verb);
  expect(screen.getByText('Move there')).toBeTruthy();
});
it('keeps a reason that was typed until it is taken', () => {
  const written = () => {
    const reason = signal('');
    const shown = render(<ReasonField id="hold 7" label="Why" reason={reason} />);
    return { reason, shown };
  };
  const first = written();
  fireEvent.input(screen.getByLabelText(/Why/), { target: { value: 'the probe is free' } });
  first.shown.unmount();
  const second = written();
  expect(second.reason.value).toBe('the probe is free');
  second.shown.unmount();
  reasonTaken('hold 7');
  expect(written().reason.value).toBe('');
});
