// Without a mouse: skip link, g and a letter, rows, help, a question that Esc means no to; off inside fields.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { Browser, live } from './lib/browser.mjs';
import { Cell, diagonal } from './lib/cell.mjs';
import { skipUnlessAllIsThere } from './lib/places.mjs';

skipUnlessAllIsThere();

let cell;
let browser;
before(async () => {
  cell = await Cell.start({ speed: 100 });
  await cell.cli('Anna', 'run', 'start', cell.trajectory('plan.csv', diagonal(300)), '--name', 'long');
  browser = await Browser.open(cell.url);
}, { timeout: 120_000 });
after(async () => {
  await browser?.close();
  await cell?.stop();
});

const focused = (page) => page.evaluate(() => document.activeElement?.textContent?.trim());

test('every view is a g and a letter away, with the focus on its heading', { timeout: 60_000 }, async () => {
  const page = await browser.page('/now');
  await live(page);
  for (const [key, name] of [
    ['i', 'Instruments'], ['h', 'Manual'], ['c', 'Commissioning'], ['t', 'Trajectories'], ['r', 'Runs'], ['q', 'Queue'], ['m', 'Models'], ['p', 'Plans'],
    ['o', 'Indentation'], ['s', 'Procedure'], ['d', 'Diagnosis'], ['a', 'Targets'], ['b', 'Look back'], ['e', 'Record'], ['n', 'Now'],
  ]) {
    await page.keyboard.press('g');
    await page.keyboard.press(key);
    await page.getByRole('heading', { level: 1, name }).waitFor({ state: 'attached' });
    await page.waitForFunction((words) => document.activeElement?.tagName === 'H1' && document.activeElement.textContent === words, name);
  }
  await page.close();
  browser.assertQuiet();
});

test('the first stop of Tab is the skip link', async () => {
  const page = await browser.page('/runs');
  await live(page);
  await page.keyboard.press('Tab');
  assert.equal(await focused(page), 'Skip to the content');
  await page.keyboard.press('Enter');
  assert.equal(await page.evaluate(() => document.activeElement?.id), 'main');
  await page.close();
});

test('a run is found, opened and not aborted', { timeout: 60_000 }, async () => {
  const page = await browser.page('/runs');
  await page.getByRole('cell', { name: 'long' }).waitFor();
  await page.keyboard.press('/');
  await page.keyboard.type('grid'); // letters of a field are letters: g then r goes nowhere
  assert.equal(new URL(page.url()).pathname, '/runs');
  await page.keyboard.press('Control+A');
  await page.keyboard.type('long');
  await page.keyboard.press('Tab');
  await page.evaluate(() => document.activeElement.blur());
  await page.keyboard.press('j');
  assert.equal(await focused(page), '1');
  await page.keyboard.press('Enter');
  await page.getByRole('heading', { level: 1, name: 'Run 1 · long' }).waitFor();
  const abort = page.getByRole('button', { name: 'Abort…' });
  await abort.focus();
  await page.keyboard.press('Enter');
  await page.getByRole('heading', { name: 'Abort run 1?' }).waitFor();
  assert.equal(await focused(page), 'Keep running');
  await page.keyboard.press('Escape');
  await page.getByRole('heading', { name: 'Abort run 1?' }).waitFor({ state: 'hidden' });
  await page.locator('.run-word', { hasText: /Running|Waiting/ }).waitFor();
  await page.close();
});

test('help tells the keys, and can switch them off', async () => {
  const page = await browser.page('/now');
  await live(page);
  await page.keyboard.press('?');
  await page.getByRole('heading', { name: 'Settings and keys' }).waitFor();
  await page.getByLabel('Single keys act as below').uncheck();
  await page.keyboard.press('Escape');
  await page.keyboard.press('g');
  await page.keyboard.press('r');
  assert.equal(new URL(page.url()).pathname, '/now');
  await page.close();
  browser.assertQuiet();
});
