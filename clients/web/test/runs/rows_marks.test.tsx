// Residuals and discrepancies over time are drawn from rows: the marks come from the record of the runs those rows are of.
import { createRouterTransport } from '@connectrpc/connect';
import { configure, render, screen } from '@testing-library/preact';
import { useContext } from 'preact/hooks';
import { expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { CellService } from '@/api/gen/driftwise/v1/cell_service_pb';
import { RunService } from '@/api/gen/driftwise/v1/run_service_pb';
import { RowsMarks } from '@/parts/rows_marks';
import { RowMarks, withTimeMarks } from '@/plot/marks';
import { residualSpecs } from '@/plot/residual_specs';
import { at, fakePoints, fakeRun } from '../fake/cell';

vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });

const Shown = () => <ul>{useContext(RowMarks).map((mark) => <li>{mark.kind} at {mark.at}: {mark.label}</li>)}</ul>;

it('marks stops and restarts at their hours since the first row', async () => {
  const events = [
    { id: 1n, what: 'run.pause', detail: 'anna paused', minute: 90, runId: 17n },
    { id: 2n, what: 'run.restarted', detail: 'went on', minute: 120, runId: 18n },
    { id: 3n, what: 'stop', detail: 'long before', minute: -500 },
    { id: 4n, what: 'run.pause', detail: 'another run', minute: 100, runId: 16n },
  ];
  useTransport(createRouterTransport(({ service }) => {
    service(CellService, { listEvents: () => ({ events: events.map(({ minute, ...event }) => ({ ...event, who: 'Anna', peer: '', eventTime: at(minute) })) }) });
    service(RunService, {
      getRun: ({ runId }) => ({ run: { ...fakeRun, id: runId, startTime: at(runId === 17n ? 0 : 110), endTime: at(200) } }),
      listPoints: ({ runId }) => ({ points: [{ ...fakePoints[0], runId, measureTime: at(runId === 17n ? 30 : 115) }] }),
    });
  }));
  render(<RowsMarks runIds={[17n, 18n]}><Shown /></RowsMarks>);
  await screen.findByText('stop at 1: anna paused'); // the first row was measured at minute 30
  expect(screen.getAllByRole('listitem').map((one) => one.textContent)).toEqual(['stop at 1: anna paused', 'restart at 1.5: went on']);
});

it('draws them in residuals over time, beside the changes of force, and in no other plot', () => {
  const rows = {
    timeS: [0, 3600, 7200, 10800], validation: [false, false, false, true], excluded: [false, false, false, false],
    variables: [{ symbol: 'force', unit: 'N', values: [0, 0, 2, 2] }, { symbol: 'x', unit: 'mm', values: [0, 1, 2, 3] }],
    outputs: [{ output: 'q1', values: [1, -2, 3, -1] }],
  };
  const marks = [{ at: 1.5, kind: 'stop' as const, label: 'anna paused' }, { at: 99, kind: 'stop' as const, label: 'afterwards' }];
  const specs = residualSpecs(rows, 'q1', 'nm', 2, 'model-1').map((spec) => withTimeMarks(spec, [], marks));
  expect(specs[0].marks?.map((mark) => [mark.at, mark.kind])).toEqual([[1.5, 'stop'], [2, 'force']]);
  for (const spec of specs.slice(1)) expect(spec.marks).toBeUndefined();
});
