// More runs than one answer of the daemon holds.
import { act, configure, fireEvent, render, screen, waitFor } from '@testing-library/preact';
import { createRouterTransport } from '@connectrpc/connect';
import { beforeEach, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { Run_State } from '@/api/gen/driftwise/v1/run_pb';
import { RunService } from '@/api/gen/driftwise/v1/run_service_pb';
import { go } from '@/app/router';
import { connection } from '@/live/connection';
import { announce } from '@/live/events';
import { DataFields, useDataChoice } from '@/views/models/data_choice';
import { RunList } from '@/views/runs/list';
import { fakeRun } from '../fake/cell';

vi.setConfig({ testTimeout: 30_000 }); // a busy machine
configure({ asyncUtilTimeout: 15_000 });

const all = 450;
const run = (id: number) => ({ ...fakeRun, id: BigInt(id), name: id === 3 ? 'the old proof' : `campaign ${id}`, state: Run_State.DONE, acceptedCount: 9n });
let pages = 0;

beforeEach(() => {
  pages = 0;
  connection.value = { phase: 'live' };
  useTransport(createRouterTransport(({ service }) => service(RunService, {
    listRuns: ({ limit, beforeRunId }) => {
      pages++;
      const newest = beforeRunId === 0n ? all : Number(beforeRunId) - 1;
      return { runs: Array.from({ length: Math.min(limit, newest) }, (_, i) => run(newest - i)) };
    },
    getRun: ({ runId }) => ({ run: run(Number(runId)) }),
  })));
});

it('a search looks through all of them, and says so until it is done', async () => {
  go('/runs?q=proof');
  render(<RunList />);
  await screen.findByText(/No run matches among the newest \d+; looking through older ones/);
  await screen.findByText('the old proof');
  expect(pages).toBe(3);
});
it('without a search the newest are shown, and it is said how many', async () => {
  go('/runs');
  render(<RunList />);
  await screen.findByText('200 newest runs');
  fireEvent.click(screen.getByRole('button', { name: 'Load older runs' }));
  await screen.findByText('400 newest runs');
  expect(pages).toBe(2);
});

function Choice() {
  const choice = useDataChoice();
  return <><DataFields choice={choice} label="Runs to fit" /><output>{choice.data.runIds.join()}</output></>;
}
const subject = () => document.querySelector('output')!.textContent;

it('a run that is chosen is in its list, however old', async () => {
  go('/models?run=3');
  render(<Choice />);
  await waitFor(() => expect((screen.getByRole('checkbox', { name: /the old proof/ }) as HTMLInputElement).checked).toBe(true));
});
it('a run that ends meanwhile is offered, and changes nothing', async () => {
  go('/models');
  render(<Choice />);
  await waitFor(() => expect(subject()).toBe('450'));
  act(() => announce({ event: { case: 'run', value: run(451) } } as never));
  await screen.findByRole('checkbox', { name: /campaign 451/ });
  expect(subject()).toBe('450');
});
