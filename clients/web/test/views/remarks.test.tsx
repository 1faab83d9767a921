// A remark, or a join, whose answer was lost is sent again as the same one; what was taken leaves its field.
import { Code, ConnectError, createRouterTransport } from '@connectrpc/connect';
import { configure, fireEvent, render, screen, waitFor } from '@testing-library/preact';
import { beforeEach, expect, test, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { DataService } from '@/api/gen/driftwise/v1/data_service_pb';
import { LookBackService } from '@/api/gen/driftwise/v1/look_back_service_pb';
import { setOperatorName } from '@/app/session';
import { connection } from '@/live/connection';
import { Notes } from '@/views/lookback/notes';
import { JoinPanel } from '@/views/runs/join';

vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });
const sent: string[] = [];
// The first one arrives, its answer does not.
const loseFirst = ({ requestId }: { requestId: string }) => {
  sent.push(requestId);
  if (sent.length === 1) throw new ConnectError('lost', Code.Unavailable);
  return {};
};
beforeEach(() => {
  sent.length = 0;
  sessionStorage.clear();
  setOperatorName('Anna');
  connection.value = { phase: 'live' };
});

test('a remark', async () => {
  useTransport(createRouterTransport(({ service }) => service(LookBackService, { listTimeNotes: () => ({}), addTimeNote: loseFirst })));
  render(<Notes />);
  const field = screen.getByLabelText('What happened') as HTMLInputElement;
  const pin = screen.getByRole('button', { name: 'Pin it' });
  const when = screen.getByLabelText('When, UTC') as HTMLInputElement;
  fireEvent.input(when, { target: { value: '2026-12-02T01:30:00Z' } });
  const pinned = async (text: string, times: number) => {
    fireEvent.input(field, { target: { value: text } });
    await waitFor(() => expect(pin.getAttribute('aria-disabled')).toBeNull());
    fireEvent.click(pin);
    await waitFor(() => expect(sent.length).toBe(times));
  };
  await pinned('door opened', 1);
  await screen.findByText(/The daemon did not answer/);
  expect(field.value).toBe('door opened');
  fireEvent.click(pin);
  await waitFor(() => expect(field.value).toBe(''));
  expect(when.value).toBe(''); // the next remark is of its own time
  expect(pin.getAttribute('aria-disabled')).toBe('true');
  await pinned('door opened', 3);
  expect(sent[1]).toBe(sent[0]);
  expect(sent[2]).not.toBe(sent[0]);
});

test('a join', async () => {
  useTransport(createRouterTransport(({ service }) => service(DataService, { joinRuns: loseFirst })));
  render(<JoinPanel runs={[15n, 16n]} onClose={() => undefined} />);
  const join = screen.getByRole('button', { name: 'Join' });
  fireEvent.click(join);
  await screen.findByText(/The daemon did not answer/);
  fireEvent.click(join);
  await waitFor(() => expect(sent.length).toBe(2));
  expect(sent[1]).toBe(sent[0]);
});
