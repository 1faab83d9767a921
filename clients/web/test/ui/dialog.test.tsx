// Stop motion in every dialog: showModal() makes the bar inert.
import { create } from '@bufbuild/protobuf';
import { createRouterTransport } from '@connectrpc/connect';
import { act, fireEvent, render, screen, within } from '@testing-library/preact';
import { beforeEach, expect, it, vi } from 'vitest';
import { useTransport } from '@/api/client';
import { CellService, StopAllResponseSchema } from '@/api/gen/driftwise/v1/cell_service_pb';
import { BottomTabs } from '@/app/bar';
import { HelpDialog } from '@/app/help';
import { helpOpen } from '@/app/keys';
import { askName, NameDialog } from '@/app/name';
import { StopButton } from '@/app/stop';
import { confirm, ConfirmDialog } from '@/ui/confirm';

let answer: (confirmed: boolean) => void;
const stopped = vi.fn();

beforeEach(() => {
  stopped.mockClear();
  useTransport(createRouterTransport(({ service }) => service(CellService, {
    stopAll: () => {
      stopped();
      return new Promise((done) => (answer = (confirmed) => done(create(StopAllResponseSchema, { confirmed, message: 'q1 moves' }))));
    },
  })));
  render(<><StopButton /><ConfirmDialog /><HelpDialog /><NameDialog /><BottomTabs current={undefined} /></>);
});

const press = (on: HTMLElement) => fireEvent(on, new MouseEvent('pointerdown', { button: 0, bubbles: true })); // jsdom's pointer events have no button
const opened = () => vi.waitFor(() => {
  const dialog = [...document.querySelectorAll('dialog')].find((one) => one.open);
  expect(dialog).toBeDefined();
  return dialog!;
});
const question = () => confirm({ title: 'Abort run 2?', verb: 'Abort run 2', keep: 'Keep running' });
const closing: [string, () => unknown][] = [
  ['a question', question],
  ['the name', askName],
  ['settings and keys', () => (helpOpen.value = true)],
  ['more views', () => fireEvent.click(screen.getByRole('button', { name: 'More' }))],
];

it.each(closing)('stands in %s, and Esc ends only that', async (_, open) => {
  act(() => void open());
  const dialog = await opened();
  press(within(dialog).getByText('Stop motion'));
  await vi.waitFor(() => expect(stopped).toHaveBeenCalledTimes(1));
  answer(true);
  expect(await within(dialog).findByText('Axes halted', { selector: '.stop-says' })).toBeTruthy();
  expect(dialog.open).toBe(true);
  fireEvent(dialog, new Event('cancel', { cancelable: true }));
  await vi.waitFor(() => expect(dialog.open).toBe(false));
});

it('says what came of a stop also when its dialog is gone', async () => {
  act(() => void question());
  const dialog = await opened();
  press(within(dialog).getByText('Stop motion'));
  await vi.waitFor(() => expect(stopped).toHaveBeenCalled());
  fireEvent.click(within(dialog).getByText('Keep running'));
  await vi.waitFor(() => expect(dialog.open).toBe(false));
  answer(false);
  expect(await screen.findByText(/Stop not confirmed: use the emergency switch. q1 moves/, { selector: '.stop-says' })).toBeTruthy();
});

it('answers with no when the browser closes the dialog by itself', async () => {
  let yes: boolean | undefined;
  act(() => void question().then((given) => (yes = given)));
  const dialog = await opened();
  dialog.open = false;
  fireEvent(dialog, new Event('close'));
  await vi.waitFor(() => expect(yes).toBe(false));
});
