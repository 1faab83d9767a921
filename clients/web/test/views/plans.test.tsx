// The view Plans before a daemon in memory: which plan serves, its check, a joint target.
import { create } from '@bufbuild/protobuf';
import { createRouterTransport } from '@connectrpc/connect';
import { act, fireEvent, render, screen, within } from '@testing-library/preact';
import { beforeEach, describe, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { EventSchema } from '@/api/gen/driftwise/v1/cell_service_pb';
import { PlanService } from '@/api/gen/driftwise/v1/plan_service_pb';
import { WatchEventSchema } from '@/api/gen/driftwise/v1/watch_service_pb';
import { operatorName } from '@/app/session';
import { timestampOf } from '@/format/time';
import { go } from '@/app/router';
import { connection } from '@/live/connection';
import { announce } from '@/live/events';
import { cellTimeMs } from '@/live/state';
import { ConfirmDialog } from '@/ui/confirm';
import { jointPoseTyped } from '@/views/plans/words';
import Plans from '@/views/plans/view';
import { fakeDaemon } from '../fake/daemon';

const promoted = vi.fn();

beforeEach(() => {
  sessionStorage.clear();
  promoted.mockClear();
  operatorName.value = 'Anna';
  useTransport(fakeDaemon({ promoted }));
  connection.value = { phase: 'live' };
  go('/plans');
  HTMLDialogElement.prototype.showModal ??= () => {};
  HTMLDialogElement.prototype.close ??= () => {};
});

describe('serving plans', () => {
  it('shows which one serves, and its steps', async () => {
    render(<Plans />);
    const table = within(await screen.findByRole('table', { name: 'Serving plans, oldest first' }));
    expect(table.getByText('serves')).toBeTruthy();
    expect(await screen.findByText('model 13 predicts parasitic motion of ma; it adds ma.x_mm to mn.x_mm')).toBeTruthy();
  });
  it('does not promote a plan that the check refuses, and says why', async () => {
    render(<><Plans /><ConfirmDialog /></>);
    fireEvent.click(await screen.findByRole('button', { name: 'Show plan 2' }));
    fireEvent.click(await screen.findByRole('button', { name: 'Promote…' }));
    expect(await screen.findByText('the two models differ by 57.6 um')).toBeTruthy();
    expect(screen.getByText(/differ by 57.600 nm of ma.q2_mm \(200.0 arcsec\)/)).toBeTruthy();
    expect(promoted).not.toHaveBeenCalled();
  });
  it('promotes a plan that stands, after asking', async () => {
    render(<><Plans /><ConfirmDialog /></>);
    fireEvent.click(await screen.findByRole('button', { name: 'Promote…' }));
    expect(await screen.findByText('everybody who asks for joint targets, from the next target on')).toBeTruthy();
    fireEvent.click(screen.getByText('Promote plan 1'));
    await vi.waitFor(() => expect(promoted).toHaveBeenCalledWith(1n));
  });
  it('follows what others promote, and promotes over the plan that the question named alone', async () => {
    let serving = 1n;
    const promotePlan = vi.fn((_: { servingPlanId?: bigint }) => ({}));
    useTransport(createRouterTransport(({ service }) => service(PlanService, {
      listPlans: () => ({ plans: [1n, 2n, 3n].map((id) => ({ id, name: 'joint', version: Number(id), serves: id === serving })) }),
      getPlan: () => ({}), checkPlan: () => ({}), promotePlan,
    })));
    render(<><Plans /><ConfirmDialog /></>);
    const row = async (id: number) => (await screen.findByRole('button', { name: `Show plan ${id}` })).closest('tr')!;
    expect((await row(1)).textContent).toContain('serves');
    serving = 2n;
    act(() => announce(create(WatchEventSchema, { event: { case: 'record', value: create(EventSchema, { what: 'plan.promote' }) } })));
    await vi.waitFor(async () => expect((await row(2)).textContent).toContain('serves'));
    expect((await row(1)).textContent).toContain('kept');
    fireEvent.click(await screen.findByRole('button', { name: 'Promote…' }));
    expect(await screen.findByText('Keep plan 2')).toBeTruthy();
    fireEvent.click(screen.getByText('Promote plan 1'));
    await vi.waitFor(() => expect(promotePlan.mock.calls[0]?.[0].servingPlanId).toBe(2n));
  });
  it('says before a rollback that no plan would serve', async () => {
    const planRolledBack = vi.fn();
    useTransport(fakeDaemon({ planRolledBack }));
    render(<><Plans /><ConfirmDialog /></>);
    fireEvent.click(await screen.findByRole('button', { name: 'Roll back…' }));
    expect(await screen.findByText(/No plan served before it: joint targets are refused/)).toBeTruthy();
    expect(planRolledBack).not.toHaveBeenCalled();
    fireEvent.click(screen.getByText('Serve no plan'));
    await vi.waitFor(() => expect(planRolledBack).toHaveBeenCalledOnce());
  });
  it('asks for a joint target and shows terms and models', async () => {
    render(<Plans />);
    fireEvent.input(await screen.findByLabelText(/Wanted pose/), { target: { value: 'mn.x=1 ma.rx_arcsec=100' } });
    fireEvent.click(screen.getByRole('button', { name: 'Ask' }));
    expect(await screen.findByText(/0.500 of model 11, the rest of model 10/)).toBeTruthy();
    expect(screen.getByText('ma.rx_arcsec=100')).toBeTruthy();
  });
  describe('a joint target', () => {
    const startMs = Date.UTC(2026, 4, 15, 18);
    let serving = 1n;
    const joint = () => createRouterTransport(({ service }) => service(PlanService, {
      listPlans: () => ({ plans: [1n, 2n].map((id) => ({ id, name: 'joint', version: Number(id), serves: id === serving })) }),
      getPlan: () => ({}),
      computeJointTarget: ({ pose }) => ({ target: { coordinates: [{ channel: 'mn.q1_mm', positionMm: pose[0].value }], conditionsTime: timestampOf(startMs), validUntilTime: timestampOf(startMs + 60_000) } }),
    }));
    const type = async (value: string) => fireEvent.input(await screen.findByLabelText(/Wanted pose/), { target: { value } });
    const shown = () => screen.queryByText('1.2500000');
    beforeEach(async () => {
      serving = 1n;
      cellTimeMs.value = startMs + 1000;
      useTransport(joint());
      render(<Plans />);
      await type('mn.x=1.25');
      fireEvent.click(screen.getByRole('button', { name: 'Ask' }));
      await screen.findByText('1.2500000');
    });
    it('is not shown under another pose than it was asked for', async () => {
      await type('mn.x=1.5');
      expect(shown()).toBeNull();
      await type('mn.x=1.25');
      expect(shown()).toBeTruthy();
    });
    it('says of when it is and how long it is good, and is hatched after that', async () => {
      const words = screen.getByText('conditions of 18:00:00 UTC, good until 18:01:00 UTC');
      expect(words.closest('.stale')).toBeNull();
      act(() => void (cellTimeMs.value = startMs + 60_001));
      expect(words.closest('.stale')).toBeTruthy();
    });
    it('goes when another plan begins to serve; the typed pose stays', async () => {
      serving = 2n;
      act(() => announce(create(WatchEventSchema, { event: { case: 'record', value: create(EventSchema, { what: 'plan.promote' }) } })));
      await vi.waitFor(() => expect(shown()).toBeNull());
      expect((screen.getByLabelText(/Wanted pose/) as HTMLInputElement).value).toBe('mn.x=1.25');
    });
  });
  it('reads a joint pose as a person types it', () => {
    expect(jointPoseTyped('mn.x=1,5 z=-2')).toEqual([{ channel: 'mn.x_mm', value: 1.5 }, { channel: 'z_mm', value: -2 }]);
    expect(jointPoseTyped('q1=3')).toBeUndefined();
    expect(jointPoseTyped('')).toBeUndefined();
  });
});
