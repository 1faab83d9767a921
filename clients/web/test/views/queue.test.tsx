// The view Queue before a daemon in memory: reasons, order, release.
import { cleanup, fireEvent, render, screen, within } from '@testing-library/preact';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { operatorName } from '@/app/session';
import { go } from '@/app/router';
import { connection } from '@/live/connection';
import { ConfirmDialog } from '@/ui/confirm';
import { metadataTyped } from '@/views/queue/words';
import Queue from '@/views/queue/view';
import { fakeDaemon } from '../fake/daemon';

const moved = vi.fn();
const released = vi.fn();

beforeEach(() => {
  sessionStorage.clear();
  operatorName.value = 'Anna';
  useTransport(fakeDaemon({ moved, released }));
  connection.value = { phase: 'live' };
  go('/queue');
});
afterEach(cleanup);

describe('the queue', () => {
  it('says of each entry why it waits, and what came of those that are over', async () => {
    render(<Queue />);
    const open = within(await screen.findByRole('table', { name: 'Campaigns in their order' }));
    expect(open.getByText('waits for t12_degC below 20.5 degC for 30 min: 21.3 now')).toBeTruthy();
    expect(open.getByText('sample=A12')).toBeTruthy();
    expect(screen.getByText(/The queue is held since/)).toBeTruthy();
    expect(screen.getByText('model 3 was fitted')).toBeTruthy();
  });
  it('moves an entry before the one above it', async () => {
    render(<Queue />);
    fireEvent.click(await screen.findByRole('button', { name: 'Move entry 5 up' }));
    await vi.waitFor(() => expect(moved).toHaveBeenCalledWith(5n, 4n));
  });
  it('asks before it releases', async () => {
    HTMLDialogElement.prototype.showModal ??= () => {};
    HTMLDialogElement.prototype.close ??= () => {};
    render(<><Queue /><ConfirmDialog /></>);
    fireEvent.click(await screen.findByRole('button', { name: 'Release…' }));
    expect(released).not.toHaveBeenCalled();
    fireEvent.click(await screen.findByText('Release it'));
    await vi.waitFor(() => expect(released).toHaveBeenCalled());
  });
  it('reads metadata as a person types it', () => {
    expect(metadataTyped('sample=A12, tool=probe')).toEqual([{ key: 'sample', value: 'A12' }, { key: 'tool', value: 'probe' }]);
    expect(metadataTyped('')).toEqual([]);
    expect(metadataTyped('A12')).toBeUndefined();
  });
});
