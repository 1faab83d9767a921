// What is on paper is the record: all rows and columns, the zone of its times, its hashes, and no navigation.
import { configure, render, screen, waitFor, within } from '@testing-library/preact';
import { afterAll, afterEach, beforeAll, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { followPrinting } from '@/app/printing';
import { go } from '@/app/router';
import { setOperatorName } from '@/app/session';
import { Shell } from '@/app/shell';
import { startStream } from '@/live/stream';
import { readReport } from '@/report/data';
import { ReportPage } from '@/report/page';
import { sheets, Table } from '@/ui/table';
import css from '@/styles/print.css?raw';
import { fakeDaemon } from '../fake/daemon';
import { fakeRun } from '../fake/cell';
import { sampleReport } from '../report/sample';

vi.mock('@/plot/draw', async (real) => ({ ...(await real<object>()), makePlot: () => ({ destroy: () => undefined, over: document.createElement('div') }), redraw: () => undefined }));
vi.mock('@/poses/poses', () => ({ Poses: () => null })); // no canvas in jsdom
vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });

let ends: (() => void)[];
beforeAll(() => {
  vi.stubGlobal('scrollTo', () => undefined);
  useTransport(fakeDaemon());
  ends = [startStream(), followPrinting()];
});
afterAll(() => ends.forEach((end) => end()));
afterEach(() => dispatchEvent(new Event('afterprint')));
const print = () => dispatchEvent(new Event('beforeprint')); // the picture is taken when this returns

it('holds every row and every column of a wide table, in parts that repeat the first column', async () => {
  const columns = Array.from({ length: 40 }, (_, k) => ({ title: `c${k}`, of: (row: number) => `${row}/${k}` }));
  render(<Table caption="wide" rows={Array.from({ length: 60 }, (_, i) => i)} keyOf={(i) => i} columns={columns} page={20} />);
  expect(screen.getAllByRole('table')).toHaveLength(1);
  expect(screen.queryByText('59/39')).toBeNull();
  print();
  const tables = screen.getAllByRole('table');
  expect(tables.length).toBeGreaterThan(2);
  for (const table of tables) expect(within(table).getByText('59/0')).toBeTruthy();
  expect(screen.getByText('59/39')).toBeTruthy();
  expect(new Set(tables.flatMap((table) => within(table).getAllByRole('columnheader').map((head) => head.textContent))).size).toBe(40);
  dispatchEvent(new Event('afterprint'));
  await waitFor(() => expect(screen.queryByText('59/39')).toBeNull());
  expect(sheets(columns.slice(0, 13))).toHaveLength(1);
});

it('says which cell, which configuration, where, when and in which zone, and draws plots for paper', async () => {
  fakeRun.configHash = 'c0ffee1234';
  setOperatorName('Anna');
  go('/runs/17?tab=plots');
  render(<Shell />);
  await screen.findByText('Spread of the repeats');
  await screen.findByText('Live');
  expect(screen.queryByLabelText('What was printed')).toBeNull();
  print();
  const head = screen.getByLabelText('What was printed').textContent!;
  expect(head).toContain('micro-nano, Driftwise 0.1.0');
  expect(head).toContain('91ab23cd45ef'); // the cell file in force
  expect(head).toContain('c0ffee1234'); // the one of the run
  expect(head).toContain('/runs/17?tab=plots');
  expect(head).toContain('times inUTC');
  expect(head).toContain('by Anna');
  const papers = [...document.querySelectorAll('.plot-paper svg')];
  expect(papers.length).toBeGreaterThan(1);
  const ids = [...document.querySelectorAll('.plot-paper [id]')].map((one) => one.id);
  expect(new Set(ids).size).toBe(ids.length);
});

it('has the zone and the hash in a report', () => {
  render(<ReportPage report={readReport(JSON.stringify(sampleReport()))} />);
  expect(screen.getByText('UTC', { selector: 'dd' })).toBeTruthy();
  expect(screen.getByText('abc123')).toBeTruthy();
});

it('leaves navigation and tools off the paper and cuts no table', () => {
  const style = document.createElement('style');
  style.textContent = css.slice(css.indexOf('@media print {') + 14, css.lastIndexOf('}')); // jsdom is a screen
  document.head.append(style);
  document.body.insertAdjacentHTML('beforeend', '<div id="paper"><header class="bar"></header><nav class="tabs-bottom"></nav><nav class="tabs"></nav><div class="plot-tools"></div><div class="table-scroll"></div></div>');
  const [table, ...gone] = [...document.querySelector('#paper')!.children].reverse();
  for (const one of gone) expect(getComputedStyle(one).display, one.className).toBe('none');
  expect(getComputedStyle(table).overflow).toBe('visible');
  style.remove();
  document.querySelector('#paper')!.remove();
});
