// A question whose answer failed is asked again when the page becomes live: nothing else would ask.
import { act, render, screen } from '@testing-library/preact';
import { beforeEach, expect, it, vi } from 'vitest';
import { connection } from '@/live/connection';
import { Failed } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';

const ask = vi.fn<() => Promise<string>>();

function List() {
  const asked = useAsked('list', ask);
  return <>{asked.failure && <Failed asked="List" failure={asked.failure} />}{asked.value && <p>{asked.value}</p>}</>;
}

beforeEach(() => {
  ask.mockReset();
  connection.value = { phase: 'connecting' };
});

it('shows the list after a first answer that failed, once the page is live', async () => {
  ask.mockRejectedValueOnce(new Error('gone')).mockResolvedValue('the list');
  render(<List />);
  await screen.findByRole('alert');
  act(() => void (connection.value = { phase: 'live' }));
  expect(await screen.findByText('the list')).toBeTruthy();
  expect(screen.queryByRole('alert')).toBeNull();
});

it('asks again when the page became live while the answer that failed was on its way', async () => {
  let fail = (_: Error): void => undefined;
  ask.mockReturnValueOnce(new Promise((_, failed) => (fail = failed))).mockResolvedValue('the list');
  render(<List />);
  await vi.waitFor(() => expect(ask).toHaveBeenCalledTimes(1));
  act(() => void (connection.value = { phase: 'live' }));
  fail(new Error('gone'));
  expect(await screen.findByText('the list')).toBeTruthy();
  expect(ask).toHaveBeenCalledTimes(2);
});

it('asks again on a live page what was asked while it was not, and hangs', async () => {
  connection.value = { phase: 'lost', lastMs: 0 };
  ask.mockReturnValueOnce(new Promise(() => undefined)).mockResolvedValue('the list');
  render(<List />);
  await vi.waitFor(() => expect(ask).toHaveBeenCalledTimes(1));
  act(() => void (connection.value = { phase: 'live' }));
  expect(await screen.findByText('the list')).toBeTruthy();
});

it('does not ask again for what it has, nor more than once for what fails again', async () => {
  ask.mockResolvedValueOnce('the list').mockRejectedValue(new Error('refused'));
  const { unmount } = render(<List />);
  await screen.findByText('the list');
  act(() => void (connection.value = { phase: 'live' }));
  expect(ask).toHaveBeenCalledTimes(1);
  unmount();
  render(<List />);
  await screen.findByRole('alert');
  act(() => void (connection.value = { phase: 'lost', lastMs: 0 }));
  act(() => void (connection.value = { phase: 'live' }));
  await vi.waitFor(() => expect(ask).toHaveBeenCalledTimes(3));
  await act(async () => undefined); // the answer is in, and what follows from it
  expect(screen.getByRole('alert')).toBeTruthy();
  expect(ask).toHaveBeenCalledTimes(3);
});
