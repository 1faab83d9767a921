// Before a robot moves again: who stopped it, how long ago, and a reason from everybody else.
import { create } from '@bufbuild/protobuf';
import { createRouterTransport } from '@connectrpc/connect';
import { act, fireEvent, render, screen } from '@testing-library/preact';
import { beforeEach, expect, test } from 'vitest';
import { useTransport } from '@/api/client';
import { CellService } from '@/api/gen/driftwise/v1/cell_service_pb';
import { RunHold_Kind, RunSchema } from '@/api/gen/driftwise/v1/run_pb';
import { session, setOperatorName } from '@/app/session';
import { timestampOf } from '@/format/time';
import { connection } from '@/live/connection';
import { askAboutHold } from '@/parts/hold_question';
import { ConfirmDialog } from '@/ui/confirm';
import Record from '@/views/record/view';

const at = Date.UTC(2026, 10, 22, 8, 0, 0);
const run = (kind: RunHold_Kind) =>
  create(RunSchema, { id: 3n, hold: { id: 77n, kind, who: 'ada', beginTime: timestampOf(at), reason: 'stopped by ada' } });
const verb = () => screen.getByRole('button', { name: 'Resume run 3', hidden: true });

beforeEach(() => {
  setOperatorName('bob');
  connection.value = { phase: 'live' };
  render(<ConfirmDialog />);
});

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

test('names are called not proved only where nobody logs in', async () => {
  void askAboutHold(run(RunHold_Kind.PAUSE), at, 'Resume run 3');
  await screen.findByText(/Names are stated, not proved: this is no lock-out/);
  fireEvent.click(screen.getByRole('button', { name: 'Leave it standing', hidden: true }));
  session.value = { state: 'in', name: 'bob', role: 'operator' };
  void askAboutHold(run(RunHold_Kind.PAUSE), at, 'Resume run 3');
  await screen.findByText(/A log-in is no lock-out/);
  expect(screen.queryByText(/not proved/)).toBeNull();
  fireEvent.click(screen.getByRole('button', { name: 'Leave it standing', hidden: true }));
  useTransport(createRouterTransport(({ service }) => {
    service(CellService, { listEvents: () => ({}) });
  }));
  const shown = render(<Record />);
  expect(screen.getByText(/Names are proved since a log-in is asked for/)).toBeTruthy();
  act(() => void (session.value = { state: 'open' }));
  expect(screen.getByText(/Names are as typed, not verified/)).toBeTruthy();
  shown.unmount();
});

test('nothing is sent when the question is left', async () => {
  const answer = askAboutHold(run(RunHold_Kind.STOP), at, 'Resume run 3');
  await screen.findByText('Stopped by');
  fireEvent.click(screen.getByRole('button', { name: 'Leave it standing', hidden: true }));
  expect(await answer).toBeUndefined();
});
