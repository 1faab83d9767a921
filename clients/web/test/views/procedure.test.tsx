// The view Procedure before a daemon in memory: states, figures, where to go back, commands to copy.
import { fireEvent, render, screen, within } from '@testing-library/preact';
import { beforeEach, describe, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { go } from '@/app/router';
import { connection } from '@/live/connection';
import Procedure from '@/views/procedure/view';
import { fakeDaemon } from '../fake/daemon';

const copied = vi.fn(() => Promise.resolve());

beforeEach(() => {
  copied.mockClear();
  useTransport(fakeDaemon());
  connection.value = { phase: 'live' };
  Object.defineProperty(navigator, 'clipboard', { value: { writeText: copied }, configurable: true });
  go('/procedure');
});

describe('the procedure as a whole', () => {
  it('says at the top that the wanted accuracy is not reached, and where to go back', async () => {
    render(<Procedure />);
    const back = await screen.findByRole('link', { name: 'back to step 0' });
    expect(back.getAttribute('href')).toBe('#step-0');
    expect(back.parentElement!.textContent).toContain('beam offset, 44.0 nm');
  });
  it('shows each step with its state, in order', async () => {
    render(<Procedure />);
    const steps = await screen.findAllByRole('region');
    const heads = steps.filter((step) => step.tagName === 'SECTION').map((step) => step.querySelector('h2')!.textContent);
    expect(heads).toEqual(['0 · sources of inaccuracy', '1 · wanted accuracy', '2 · measurements', '3 · models', '4 · validation in pose coordinates', '5 · wanted accuracy reached']);
    expect(screen.getAllByText('done')).toHaveLength(5);
    expect(screen.getByText('not reached')).toBeTruthy();
  });
  it('names the sources that nothing measures', async () => {
    render(<Procedure />);
    const table = within(await screen.findByRole('table', { name: 'Sources of inaccuracy' }));
    expect(table.getByText('process force').closest('tr')!.textContent).toContain('not measured');
    expect(table.getByText('x_mm, y_mm, z_mm')).toBeTruthy();
  });
  it('puts a figure beside what is wanted of it', async () => {
    render(<Procedure />);
    const table = within(await screen.findByRole('table', { name: 'Accuracy of step 5' }));
    expect(table.getByText('x').closest('tr')!.textContent).toMatch(/142 nm.*100 nm.*missed/);
    const wanted = within(screen.getByRole('table', { name: 'Accuracy of step 1' }));
    expect(wanted.getByText('every rotation')).toBeTruthy();
  });
  it('copies the command of a step', async () => {
    render(<Procedure />);
    fireEvent.click(await screen.findByRole('button', { name: 'Copy the command of step 5' }));
    await vi.waitFor(() => expect(copied).toHaveBeenCalledWith('driftwise design --model 12 --list'));
  });
});
