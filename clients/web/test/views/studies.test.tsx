// The two studies of the view Models before a daemon in memory: progress, the answer, and that leaving ends the work.
import { fireEvent, render, screen, within } from '@testing-library/preact';
import { beforeEach, describe, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { go } from '@/app/router';
import { connection } from '@/live/connection';
import { supportedDigits } from '@/views/models/geometry';
import { intervalOf, methodsOf } from '@/views/models/methods_json';
import { overOutputs } from '@/views/models/methods_result';
import { sensorsSpec } from '@/views/models/sensors_plot';
import Models from '@/views/models/view';
import { fakeDaemon } from '../fake/daemon';
import { comparison, sensorStudy } from '../fake/studies';

vi.mock('@/plot/plot', () => ({ Plot: ({ spec }: { spec: { title: string } }) => <figure>{spec.title}</figure> }));

beforeEach(() => {
  sessionStorage.clear();
  useTransport(fakeDaemon());
  connection.value = { phase: 'live' };
});

async function begin(address: string, verb: string) {
  go(address);
  const shown = render(<Models />);
  await screen.findByText(/16 terms for q1/);
  fireEvent.click(screen.getByRole('button', { name: verb }));
  return shown;
}

describe('methods side by side', () => {
  it('names the best, ranks the rest by rows held out, and shows the geometry found', async () => {
    await begin('/models/methods', 'Compare methods');
    await screen.findByRole('heading', { name: 'Methods, least error first' });
    const table = within(screen.getByRole('table', { name: 'Methods by A90 on validation rows' }));
    const rows = table.getAllByRole('row').slice(1).map((row) => row.querySelector('strong')!.textContent);
    expect(table.getByText('least error')).toBeTruthy();
    expect(table.getByText('as good within 5 %')).toBeTruthy();
    expect(rows).toEqual(['Ours: stepwise regression', 'Classic: drawing and error model', 'Geometry identified', 'The drawing']);
    expect(screen.getByText('40.0123 ± 0.0021')).toBeTruthy();
    expect(screen.getByText('cannot be told apart from arm_mm')).toBeTruthy();
  });
  it('judges by blocks of time when asked to, with the interval', async () => {
    await begin('/models/methods?judged=blocks', 'Compare methods');
    await screen.findByRole('table', { name: 'Methods by A90 on blocks of time held out' });
    expect(screen.getAllByText(/\(88 to 123\)/)).toHaveLength(3);
  });
  it('compares only what was marked', async () => {
    go('/models/methods');
    render(<Models />);
    await screen.findByText(/16 terms for q1/);
    fireEvent.click(screen.getByLabelText('the drawing'));
    fireEvent.click(screen.getByRole('button', { name: 'Compare methods' }));
    expect(within(await screen.findByRole('table', { name: /Methods by/ })).getAllByRole('row')).toHaveLength(2);
  });
  it('leaves no claim on outputs of different units', () => {
    const [method] = comparison(['nominal']).methods;
    expect(overOutputs(method as never, () => 3)).toBeCloseTo(3);
    expect(overOutputs({ ...method, outputs: [{ unit: 'nm' }, { unit: 'arcsec' }] } as never, () => 3)).toBeUndefined();
  });
  it('reads what only the JSON says, and does without it', () => {
    expect(intervalOf(methodsOf(comparison(['stepwise']).json)[0], 'q1', 'a90_blocks', 'nm')!.map(Math.round)).toEqual([88, 122]);
    expect(methodsOf('no JSON')).toEqual([]);
    expect(intervalOf(undefined, 'q1', 'a90_blocks', 'nm')).toBeUndefined();
  });
  it('prints no more digits of a length than its standard error supports', () => {
    expect([0.0021, 12, null].map(supportedDigits)).toEqual([4, 0, 4]);
  });
});

describe('which thermometers suffice', () => {
  it('says which, what they cost against all of them, and every set by size', async () => {
    await begin('/models/sensors', 'Try all sets');
    await screen.findByText('2 of 7 thermometers suffice');
    expect(screen.getByText('+7.6 nm against all 7')).toBeTruthy();
    expect(screen.getByText(/the best of 128 sets/)).toBeTruthy();
    const rows = within(screen.getByRole('table', { name: /best set of each number/ })).getAllByRole('row');
    expect(rows).toHaveLength(9);
    expect(rows[6].textContent).toContain('suffices');
  });
  it('draws them by number, the limit above the best of all', () => {
    const { best, recommended, tolerance, unit } = sensorStudy(0.1);
    const spec = sensorsSpec(best as never, recommended, tolerance, unit);
    expect([...(spec.series[0].x as number[])]).toEqual([0, 1, 2, 3, 4, 5, 6, 7]);
    expect(spec.note).toBeUndefined();
    const far = sensorsSpec(best.map((set) => (set.sensors.length === 0 ? { ...set, a90BlocksRms: 5000 } : set)) as never, recommended, tolerance, unit);
    expect([...(far.series[0].x as number[])]).toEqual([1, 2, 3, 4, 5, 6, 7]);
    expect(far.note).toBe('beyond the picture: 0 thermometers');
    expect(spec.limits![0].at).toBeCloseTo(105.6);
    expect(spec.series.at(-1)!.x).toEqual([2]);
  });
  it('shows how far it is and can be cancelled; the daemon is told', async () => {
    const told = vi.fn();
    useTransport(fakeDaemon({ endless: told }));
    await begin('/models/sensors', 'Try all sets');
    await screen.findByText('512 of 1024 sets, 50 %');
    fireEvent.click(screen.getByRole('button', { name: 'Cancel' }));
    await screen.findByText('Cancelled: nothing was kept.');
    await vi.waitFor(() => expect(told).toHaveBeenLastCalledWith(true));
  });
  it('ends the work when the view is left', async () => {
    const told = vi.fn();
    useTransport(fakeDaemon({ endless: told }));
    const { unmount } = await begin('/models/methods', 'Compare methods');
    await screen.findByText('classic, 2 of 3, 40 %');
    unmount();
    await vi.waitFor(() => expect(told).toHaveBeenLastCalledWith(true));
  });
});
