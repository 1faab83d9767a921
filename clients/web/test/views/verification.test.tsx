import { fireEvent, render, screen, within } from '@testing-library/preact';
import { create } from '@bufbuild/protobuf';
import { beforeEach, describe, expect, it } from 'vitest';
import { useTransport } from '@/api/client';
import { JudgedAccuracySchema } from '@/api/gen/driftwise/v1/accuracy_pb';
import { go } from '@/app/router';
import { accuracyText, figure, meanFigure } from '@/ui/accuracy';
import Runs from '@/views/runs/view';
import { fakeDaemon } from '../fake/daemon';

beforeEach(() => useTransport(fakeDaemon()));

describe('accuracy', () => {
  const judged = (a90: number, before?: number) => create(JudgedAccuracySchema, {
    output: 'q1', unit: 'nm', rows: 'validation', figures: { mean: 24.31, u90: 12.83, a90, rowCount: 40n },
    ...(before === undefined ? {} : { before: { mean: 1, u90: 53, a90: before, rowCount: 40n } }),
  });
  it('is said as the command line says it', () => {
    expect(accuracyText(judged(42.04))).toBe('42 nm (q1, validation rows, mean +24.3 nm, S90 12.8 nm)');
    expect(accuracyText(judged(42.04, 53.06))).toBe('53.1 → 42 nm (q1, validation rows, mean +24.3 nm, S90 12.8 nm)');
  });
  it('has three digits at most', () => {
    expect([12.849, 9.999, 0.57449, 3, 0].map(figure)).toEqual(['12.8', '10', '0.574', '3', '0']);
    expect(([[24.31, 42], [-8, 13.4], [0.624, 9.24], [1.5e-10, 12.8], [-0.004, 12.8], [0.0004, 0.0021], [3, undefined]] as const).map(([mean, a90]) => meanFigure(mean, a90)))
      .toEqual(['+24.3', '−8', '+0.62', '0', '0', '+0.0004', '+3']);
  });
});

describe('the verification of a run', () => {
  it('shows target minus measured, inside and outside the range', async () => {
    go('/runs/17?tab=verification');
    render(<Runs />);
    const table = within(await screen.findByRole('table', { name: 'Verification of run 17' }, { timeout: 8000 }));
    expect(table.getAllByRole('row')).toHaveLength(5);
    expect(table.getByText('42 nm')).toBeTruthy();
    expect(table.getByText('84.5 nm')).toBeTruthy();
    expect(screen.getByText(/3 outside the model’s range: t05_degC above 23.1/)).toBeTruthy();
    expect(document.querySelector('[data-accuracy="42"]')!.textContent).toContain('of x, fresh points');
  });
  it('compares with another run on the positions of both', async () => {
    go('/runs/17?tab=verification');
    render(<Runs />);
    fireEvent.input(await screen.findByLabelText('against run', {}, { timeout: 8000 }), { target: { value: '16' } });
    const table = within(await screen.findByRole('table', { name: 'Run 17 against run 16' }, { timeout: 8000 }));
    expect(table.getByText('1110 nm')).toBeTruthy();
    expect(document.querySelector('.accuracy-heading')!.textContent).toContain('1110 → 42 nm');
  });
});
