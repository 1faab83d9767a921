// The view Queue before a daemon in memory: reasons, order, release.
import { create, type MessageInitShape } from '@bufbuild/protobuf';
import { createRouterTransport } from '@connectrpc/connect';
import { fireEvent, render, screen, within } from '@testing-library/preact';
import { beforeEach, describe, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { CellService } from '@/api/gen/driftwise/v1/cell_service_pb';
import { ListQueueResponseSchema, QueueEntry_State, QueueService } from '@/api/gen/driftwise/v1/queue_service_pb';
import { RunSchema, Run_State } from '@/api/gen/driftwise/v1/run_pb';
import { TrajectoryService } from '@/api/gen/driftwise/v1/trajectory_service_pb';
import { operatorName } from '@/app/session';
import { go } from '@/app/router';
import { connection } from '@/live/connection';
import { ConfirmDialog } from '@/ui/confirm';
import { mayStartAtOnce, metadataTyped } from '@/views/queue/words';
import Queue from '@/views/queue/view';
import { fakeDaemon, trajectory } from '../fake/daemon';

const moved = vi.fn();
const released = vi.fn();

beforeEach(() => {
  sessionStorage.clear();
  operatorName.value = 'Anna';
  useTransport(fakeDaemon({ moved, released }));
  connection.value = { phase: 'live' };
  go('/queue');
});

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
  it('asks before what may move the robot at once', async () => {
    const set = { id: 7n, state: QueueEntry_State.SET_ASIDE, name: 'night 3', trajectoryName: 'published.csv', rowCount: 240n };
    const did: string[] = [];
    useTransport(createRouterTransport(({ service }) => {
      service(QueueService, {
        listQueue: () => ({ entries: [set] }),
        addQueueEntry: () => (did.push('added'), {}),
        moveQueueEntry: () => (did.push('put back'), {}),
      });
      service(TrajectoryService, { listTrajectories: () => ({ trajectories: [trajectory] }), getTrajectory: () => ({ trajectory }) });
      service(CellService, { listDevices: () => ({}) });
    }));
    render(<><Queue /><ConfirmDialog /></>);
    fireEvent.click(await screen.findByRole('button', { name: 'Put entry 7 back' }));
    expect(await screen.findByText('at once: the robot may move')).toBeTruthy();
    fireEvent.click(screen.getByText('Put it back'));
    await vi.waitFor(() => expect(did).toEqual(['put back']));
    fireEvent.change(await screen.findByLabelText('Trajectory'), { target: { value: '3' } });
    fireEvent.click(screen.getByText('Add to the queue…'));
    expect(await screen.findByText('Add "published.csv" to the queue?')).toBeTruthy();
    fireEvent.click(screen.getByText('Do not add it'));
    await vi.waitFor(() => expect(screen.getByText('Add to the queue…').getAttribute('aria-busy')).toBeNull());
    fireEvent.input(screen.getByLabelText('Not before (UTC)'), { target: { value: '2261-01-01T00:00:00Z' } });
    fireEvent.click(screen.getByText('Add to the queue…'));
    await vi.waitFor(() => expect(did).toEqual(['put back', 'added']));
    // Nothing of it goes into the next entry unseen, and a second press adds no second one.
    await vi.waitFor(() => expect((screen.getByLabelText('Not before (UTC)') as HTMLInputElement).value).toBe(''));
    expect((screen.getByLabelText('Trajectory') as HTMLSelectElement).value).toBe('');
    expect((screen.getByLabelText('Priority') as HTMLInputElement).value).toBe('0');
    expect(screen.getByText('Add to the queue…').getAttribute('aria-disabled')).toBe('true');
  });
  it('knows what holds an entry back', () => {
    const queue = (changes: MessageInitShape<typeof ListQueueResponseSchema> = {}) => create(ListQueueResponseSchema, changes);
    const none = { notBeforeMs: undefined, afterEntryId: undefined };
    const run = (state: Run_State) => create(RunSchema, { id: 1n, state });
    expect(mayStartAtOnce(none, queue(), undefined, 0)).toBe(true);
    expect(mayStartAtOnce(none, queue(), run(Run_State.DONE), 0)).toBe(true);
    expect(mayStartAtOnce(none, queue(), run(Run_State.PAUSED), 0)).toBe(false);
    expect(mayStartAtOnce(none, queue({ hold: { who: 'anna' } }), undefined, 0)).toBe(false);
    expect(mayStartAtOnce(none, queue({ entries: [{ id: 1n, state: QueueEntry_State.RUNNING }] }), undefined, 0)).toBe(false);
    expect(mayStartAtOnce(none, queue({ entries: [{ id: 1n, state: QueueEntry_State.WAITING, condition: 't12 < 20 degC' }] }), undefined, 0)).toBe(true);
    expect(mayStartAtOnce({ ...none, notBeforeMs: 5 }, queue(), undefined, 4)).toBe(false);
    expect(mayStartAtOnce({ ...none, notBeforeMs: 5 }, queue(), undefined, 6)).toBe(true);
    expect(mayStartAtOnce({ ...none, afterEntryId: 1n }, queue({ entries: [{ id: 1n, state: QueueEntry_State.FOLLOWING }] }), undefined, 0)).toBe(false);
    expect(mayStartAtOnce({ ...none, afterEntryId: 1n }, queue({ entries: [{ id: 1n, state: QueueEntry_State.DONE, accepted: true }] }), undefined, 0)).toBe(true);
  });
  it('reads metadata as a person types it', () => {
    expect(metadataTyped('sample=A12, tool=probe')).toEqual([{ key: 'sample', value: 'A12' }, { key: 'tool', value: 'probe' }]);
    expect(metadataTyped('')).toEqual([]);
    expect(metadataTyped('A12')).toBeUndefined();
  });
});
