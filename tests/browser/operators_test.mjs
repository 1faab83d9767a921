// Two operators at two desks: what one does the other sees, who was first is said, Stop works for everybody at once.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { Browser, live } from './lib/browser.mjs';
import { Cell, diagonal } from './lib/cell.mjs';
import { skipUnlessAllIsThere } from './lib/places.mjs';

skipUnlessAllIsThere();

let cell;
let desks;
before(async () => {
  cell = await Cell.start({ speed: 50 });
  desks = [await Browser.open(cell.url), await Browser.open(cell.url)];
}, { timeout: 120_000 });
after(async () => {
  for (const desk of desks ?? []) await desk.close();
  await cell?.stop();
});

test('the name is asked for once, before the first command', { timeout: 60_000 }, async () => {
  await cell.cli('Carla', 'run', 'start', cell.trajectory('plan.csv', diagonal(200)), '--name', 'shared');
  const page = await desks[0].page('/now', { operator: '' });
  await live(page);
  await page.getByRole('button', { name: 'Pause', exact: true }).click();
  await page.getByLabel('Your name').fill('Anna');
  await page.getByRole('button', { name: 'Use this name' }).click();
  await page.getByText('Paused', { exact: true }).waitFor({ timeout: 60_000 });
  await page.getByText(/paused by Anna/).first().waitFor();
  await page.close();
});

test('the second desk sees who paused, resumes, and the first sees that', { timeout: 120_000 }, async () => {
  const anna = await desks[0].page('/now');
  const ben = await desks[1].page('/now', { operator: 'Ben' });
  await ben.getByText(/paused by Anna/).first().waitFor();
  await ben.getByRole('button', { name: 'Resume…', exact: true }).click();
  await ben.getByText(/^Anna, .* ago$/).waitFor();
  await ben.getByRole('button', { name: 'Resume run 1' }).click();
  await anna.getByText('Running', { exact: true }).waitFor();
  await anna.close();
  await ben.close();
});

test('a lease that somebody holds is refused with the holder’s name, and what was typed stays', { timeout: 60_000 }, async () => {
  await cell.cli('Carla', 'lease', 'take', '--hold', '3000');
  const page = await desks[1].page('/instruments', { operator: 'Ben' });
  await live(page);
  await page.getByRole('button', { name: /^Set-point/ }).first().click();
  await page.getByLabel('New set-point, °C').fill('23.5');
  await page.getByRole('button', { name: 'Change…' }).click();
  await page.getByRole('button', { name: 'Set 23.500 °C' }).click();
  await page.getByRole('alert').getByText(/Carla/).waitFor();
  assert.equal(await page.getByLabel('New set-point, °C').inputValue(), '23.5');
  await page.reload();
  await page.getByRole('button', { name: /^Set-point/ }).first().click();
  assert.equal(await page.getByLabel('New set-point, °C').inputValue(), '23.5');
  await page.close();
});

test('Stop motion acts on press, without a question, and the other desk sees it and can go on', { timeout: 60_000 }, async () => {
  const anna = await desks[0].page('/now');
  const ben = await desks[1].page('/runs/1', { operator: 'Ben' });
  await live(anna);
  await live(ben);
  const button = await anna.getByRole('button', { name: 'Stop motion' }).boundingBox();
  await anna.mouse.move(button.x + 20, button.y + 10);
  await anna.mouse.down(); // and never up
  await anna.getByText('Axes halted').first().waitFor();
  await ben.locator('.run-word', { hasText: 'Paused' }).waitFor();
  await ben.getByText(/stopped by Anna/).first().waitFor();
  await ben.getByRole('button', { name: 'Resume…', exact: true }).click();
  await ben.getByLabel('Why the robot may move after another person').fill('Anna slipped');
  await ben.getByRole('button', { name: 'Resume run 1' }).click();
  await ben.locator('.run-word', { hasText: 'Running' }).waitFor();
  for (const desk of desks) desk.assertQuiet();
});
