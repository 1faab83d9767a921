// A rollback asks with what a promotion of the model would be asked, and with what the runs since say of it.
import { create } from '@bufbuild/protobuf';
import { Code, ConnectError, createRouterTransport } from '@connectrpc/connect';
import { fireEvent, render, screen, within } from '@testing-library/preact';
import { beforeEach, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { CheckModelResponse_Verdict, ModelService, Promotion_Action, PromotionSchema, type Promotion } from '@/api/gen/driftwise/v1/model_service_pb';
import { operatorName } from '@/app/session';
import { connection } from '@/live/connection';
import { ConfirmDialog } from '@/ui/confirm';
import { RollBack } from '@/views/models/roll_back';
import { model } from '../fake/models';

const promoted = (id: bigint) => create(PromotionSchema, { modelId: id, action: Promotion_Action.PROMOTE });
let history: Promotion[]; // oldest first, as the daemon keeps it
let questions: string[];
let check: () => { verdict: CheckModelResponse_Verdict; reasons?: string[] };
const rolledBack = vi.fn();

beforeEach(() => {
  history = [promoted(11n), promoted(12n)];
  questions = [];
  check = () => ({ verdict: CheckModelResponse_Verdict.IN_CONTROL });
  rolledBack.mockClear();
  operatorName.value = 'Anna';
  connection.value = { phase: 'live' };
  HTMLDialogElement.prototype.showModal ??= () => {};
  HTMLDialogElement.prototype.close ??= () => {};
  useTransport(createRouterTransport(({ service }) => service(ModelService, {
    listPromotions: () => ({ promotions: history }),
    getModel: ({ modelId }) => ({ model: model(Number(modelId)), promotionQuestions: questions }),
    checkModel: () => check(),
    rollBackModel: () => (rolledBack(), {}),
  })));
});

async function asked() {
  render(<><RollBack promotions={[...history].reverse()} onDone={() => undefined} /><ConfirmDialog /></>);
  fireEvent.click(screen.getByRole('button', { name: 'Roll back…' }));
  await screen.findByRole('heading', { name: 'Roll back from model 12?' });
  return within(document.querySelector('dialog')!);
}

it('names the model that serves again, its formula and accuracy', async () => {
  const dialog = await asked();
  expect(dialog.getByText('model 11')).toBeTruthy();
  expect(dialog.getByText('q ~ poly(x, y, z, 3)')).toBeTruthy();
  expect(dialog.getByText(/53 nm \(q3, validation rows/)).toBeTruthy();
  expect(dialog.queryByText('although')).toBeNull();
  fireEvent.click(dialog.getByText('Serve model 11'));
  await vi.waitFor(() => expect(rolledBack).toHaveBeenCalledOnce());
});

it('repeats what promotion asks, and what the runs since say', async () => {
  questions = ['no row was held out'];
  check = () => ({ verdict: CheckModelResponse_Verdict.RECALIBRATE, reasons: ['run 2: q1 errs by +58.2 nm'] });
  const dialog = await asked();
  expect(dialog.getByText('no row was held out')).toBeTruthy();
  expect(dialog.getByText('the robot no longer does what model 11 says: run 2: q1 errs by +58.2 nm')).toBeTruthy();
  fireEvent.click(dialog.getByText('Serve model 11 all the same'));
  await vi.waitFor(() => expect(rolledBack).toHaveBeenCalledOnce());
});

it('asks all the same where the model cannot be checked', async () => {
  check = () => { throw new ConnectError('run 2 has no rows', Code.FailedPrecondition); };
  const dialog = await asked();
  expect(dialog.getByText('model 11 could not be checked against the runs since: run 2 has no rows')).toBeTruthy();
  fireEvent.click(dialog.getByText('Keep model 12')); // the question belongs to the page, not to the button: it would outlive the test
});

it('says that targets are refused where no model served before', async () => {
  history = [promoted(12n)];
  const dialog = await asked();
  expect(dialog.getByText(/every target is refused/)).toBeTruthy();
  fireEvent.click(dialog.getByText('Keep model 12'));
  await vi.waitFor(() => expect(screen.getByRole('button', { name: 'Roll back…' }).getAttribute('aria-busy')).toBeNull());
  expect(rolledBack).not.toHaveBeenCalled();
});

it('rolls nothing back when another person changed what serves meanwhile', async () => {
  const dialog = await asked();
  history = [promoted(11n)];
  fireEvent.click(dialog.getByText('Serve model 11'));
  expect(await screen.findByText(/nothing was rolled back: model 11 serves by now, where you were asked about model 12/)).toBeTruthy();
  expect(rolledBack).not.toHaveBeenCalled();
});
