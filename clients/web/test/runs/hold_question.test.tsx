// Before a robot moves again: who stopped it, how long ago, and a reason from everybody else.
import { create } from '@bufbuild/protobuf';
import { cleanup, fireEvent, render, screen } from '@testing-library/preact';
import { afterEach, beforeEach, expect, test } from 'vitest';
import { RunHold_Kind, RunSchema } from '@/api/gen/driftwise/v1/run_pb';
import { setOperatorName } from '@/app/session';
import { timestampOf } from '@/format/time';
import { connection } from '@/live/connection';
import { askAboutHold } from '@/parts/hold_question';
import { ConfirmDialog } from '@/ui/confirm';

const at = Date.UTC(2026, 10, 22, 8, 0, 0);
const run = (kind: RunHold_Kind) =>
  create(RunSchema, { id: 3n, hold: { id: 77n, kind, who: 'ada', beginTime: timestampOf(at), reason: 'stopped by ada' } });
const verb = () => screen.getByRole('button', { name: 'Resume run 3', hidden: true });

beforeEach(() => {
  setOperatorName('bob');
  connection.value = { phase: 'live' };
  render(<ConfirmDialog />);
});
afterEach(cleanup);

test('a stop by another person needs a reason in writing, and the answer names that stop', async () => {
  const answer = askAboutHold(run(RunHold_Kind.STOP), at + 720_000, 'Resume run 3');
  await screen.findByText('Stopped by');
  expect(screen.getByText('ada, 12 min ago')).toBeTruthy();
  expect(screen.getByText(/no lock-out/)).toBeTruthy();
  expect(verb().getAttribute('aria-disabled')).toBe('true');
  fireEvent.click(verb());
  fireEvent.input(screen.getByRole('textbox', { hidden: true }), { target: { value: 'ada went home' } });
  expect(verb().getAttribute('aria-disabled')).toBeNull();
  fireEvent.click(verb());
  expect(await answer).toEqual({ holdId: 77n, overrideReason: 'ada went home' });
});

test('a pause is ended by anybody who has read whose it is', async () => {
  const answer = askAboutHold(run(RunHold_Kind.PAUSE), at + 30_000, 'Resume run 3');
  await screen.findByText('ada, 30 s ago');
  expect(screen.queryByRole('textbox', { hidden: true })).toBeNull();
  fireEvent.click(verb());
  expect(await answer).toEqual({ holdId: 77n, overrideReason: '' });
});

test('nothing is sent when the question is left', async () => {
  const answer = askAboutHold(run(RunHold_Kind.STOP), at, 'Resume run 3');
  await screen.findByText('Stopped by');
  fireEvent.click(screen.getByRole('button', { name: 'Leave it standing', hidden: true }));
  expect(await answer).toBeUndefined();
});
