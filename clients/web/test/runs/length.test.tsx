// Length of a run: the daemon's figure. The clock that its instants are from may be set back meanwhile.
import { create } from '@bufbuild/protobuf';
import { DurationSchema } from '@bufbuild/protobuf/wkt';
import { createRouterTransport } from '@connectrpc/connect';
import { configure, render, screen, within } from '@testing-library/preact';
import { beforeEach, expect, test, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { Run_State } from '@/api/gen/driftwise/v1/run_pb';
import { RunService } from '@/api/gen/driftwise/v1/run_service_pb';
import { go } from '@/app/router';
import { connection } from '@/live/connection';
import { ReportPage } from '@/report/page';
import { readReport } from '@/report/data';
import Runs from '@/views/runs/view';
import { at, fakeRun } from '../fake/cell';
import { sampleReport } from '../report/sample';

vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });
vi.mock('@/plot/plot', () => ({ Plot: () => null }));

const setBack = { ...fakeRun, state: Run_State.DONE, startTime: at(0), endTime: at(-30), elapsedDuration: create(DurationSchema, { seconds: 1800n }) };
beforeEach(() => {
  vi.stubGlobal('ResizeObserver', class { observe() {} disconnect() {} unobserve() {} });
  useTransport(createRouterTransport(({ service }) => service(RunService, {
    listRuns: () => ({ runs: [setBack, { ...fakeRun, id: 16n }] }), getRun: () => ({ run: setBack }), listPoints: () => ({ points: [] }), listAttempts: () => ({ attempts: [] }),
  })));
  connection.value = { phase: 'live' };
});

test('in the list', async () => {
  go('/runs');
  render(<Runs />);
  const row = within((await screen.findByRole('link', { name: '17' })).closest('tr')!);
  expect(row.getByText('30 min')).toBeTruthy();
  expect(screen.getByText('under way')).toBeTruthy();
});

test('at the head of its page', async () => {
  go('/runs/17');
  render(<Runs />);
  expect((await screen.findByText('measured')).nextElementSibling!.textContent).toMatch(/ to .*, 30 min$/);
});

test('in a report', () => {
  const report = sampleReport();
  Object.assign(report.run, { end: '2026-11-20T15:30:00Z', elapsed_s: 1800 });
  render(<ReportPage report={readReport(JSON.stringify(report))} />);
  expect(screen.getByText('from, to').nextElementSibling!.textContent).toMatch(/ to 2026-11-20 15:30:00 UTC, 30 min$/);
});
