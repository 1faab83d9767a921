// Runs chosen in the list, checked and joined; a refusal is read where it was asked for.
import { fireEvent, render, screen, within } from '@testing-library/preact';
import { beforeEach, expect, test } from 'vitest';
import { useTransport } from '@/api/client';
import { go } from '@/app/router';
import { connection } from '@/live/connection';
import Runs from '@/views/runs/view';
import { joinReport, sigmaOf, uOf } from '@/views/runs/join_report';
import { fakeDaemon } from '../fake/daemon';

beforeEach(() => {
  useTransport(fakeDaemon());
  connection.value = { phase: 'live' };
  go('/runs');
});

test('the report of a join says where each coordinate comes from', async () => {
  render(<Runs />);
  fireEvent.click(await screen.findByRole('button', { name: 'Join runs…' }, { timeout: 8000 }));
  expect(screen.getByRole('button', { name: 'Check' }).getAttribute('aria-disabled')).toBe('true');
  for (const run of [16, 15]) fireEvent.click(await screen.findByLabelText(`Join run ${run}`, {}, { timeout: 8000 }));
  fireEvent.click(screen.getByRole('button', { name: 'Check' }));
  const table = within(await screen.findByRole('table', { name: 'Coordinates of the joined dataset' }, { timeout: 8000 }));
  expect(table.getByText('run 16, run 15')).toBeTruthy();
  expect(table.getByText('0.0210 arcsec')).toBeTruthy();
  expect(screen.getByText(/0.300 K apart \(t05_degC\)/)).toBeTruthy();
});

test('a join that is refused says why', async () => {
  render(<Runs />);
  fireEvent.click(await screen.findByRole('button', { name: 'Join runs…' }, { timeout: 8000 }));
  for (const run of [16, 14]) fireEvent.click(await screen.findByLabelText(`Join run ${run}`, {}, { timeout: 8000 }));
  fireEvent.click(screen.getByRole('button', { name: 'Check' }));
  await screen.findByText(/row 17: q2_mm is 0.5 in run 16 and 0.75 in run 14/, {}, { timeout: 8000 });
});

test('a text that is no report shows nothing', () => {
  expect(joinReport('{')).toBeUndefined();
  expect(joinReport('{"rows": 3}')).toBeUndefined();
  const report = joinReport('{"rows":1,"unmatched_rows":0,"warnings":[],"channels":[{"channel":"x_mm","sources":["run 1"],"unit":"nm","u_nm":12}]}')!;
  expect(uOf(report.channels[0])).toBe(12);
  expect(sigmaOf(report.channels[0])).toBeUndefined();
});
