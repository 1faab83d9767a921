// The daemon is killed with the page open: within 3 s nothing looks live and commands are off with their reason; when it is
// back the page is live again by itself, and no point is missing.
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
  await cell.cli('Anna', 'run', 'start', cell.trajectory('plan.csv', diagonal(120)), '--name', 'survivor');
  browser = await Browser.open(cell.url);
  browser.expected.push(/ERR_CONNECTION_REFUSED|ERR_INCOMPLETE_CHUNKED|ERR_CONNECTION_RESET|ERR_EMPTY_RESPONSE|Failed to load resource|ERR_NETWORK/);
}, { timeout: 120_000 });
after(async () => {
  await browser?.close();
  await cell?.stop();
});

test('a killed daemon looks dead within 3 s, and every point is there when it is back', { timeout: 240_000 }, async () => {
  const page = await browser.page('/runs/1');
  await live(page);
  await page.getByRole('cell', { name: 'accepted' }).first().waitFor();
  // Written by the page itself whenever it changes, so that nothing is missed between two looks.
  await cell.kill();
  const killed = Date.now();
  await page.getByRole('alert').getByText('Not live since').first().waitFor({ timeout: 10_000 });
  const seen = Date.now() - killed;
  assert.ok(seen < 4000, `the page noticed after ${seen} ms (3 s and the time to look)`);
  const pause = page.getByRole('button', { name: /^(Pause|Resume|Pausing)/ });
  assert.equal(await pause.getAttribute('aria-disabled'), 'true');
  assert.match(await pause.getAttribute('title'), /not live since/);
  await page.getByRole('button', { name: 'Stop motion' }).waitFor(); // never off
  assert.equal(await page.getByRole('button', { name: 'Stop motion' }).getAttribute('aria-disabled'), null);

  await cell.startDaemon();
  await live(page);
  await page.locator('.run-word', { hasText: 'Done' }).waitFor({ timeout: 180_000 });

  // What the page gathered from stream and record is what the record holds, each row once.
  const run = (await cell.cli('Ben', 'run', 'show', '1')).run;
  const facts = await page.locator('.run-head').innerText();
  assert.match(facts, new RegExp(`${run.accepted_count} of ${run.row_count}`));
  for (let more = page.getByRole('button', { name: 'Show more' }); await more.count(); ) await more.click();
  const rows = await page.locator('main tbody tr td[data-title="row"]').allInnerTexts();
  assert.equal(new Set(rows).size, rows.length, 'a row stands twice');
  // The zero after the restart is a passage, which is numbered after the rows of the plan.
  const planned = rows.filter((row) => Number.parseInt(row, 10) <= Number(run.row_count));
  assert.equal(planned.length, Number(run.row_count));
  browser.assertQuiet();
});

test('values are hatched while the daemon is away', { timeout: 60_000 }, async () => {
  const page = await browser.page('/now');
  await live(page);
  await page.locator('.tile').first().waitFor();
  await cell.kill();
  await page.getByRole('alert').getByText('Not live since').first().waitFor();
  const tiles = await page.locator('.tile:has(.value)').count();
  assert.ok(tiles > 0);
  const channels = page.locator('.tile', { has: page.getByText(/°C|N/) });
  assert.equal(await page.locator('.tile:not(.stale)', { has: page.getByText(/^°C$/) }).count(), 0, 'a temperature still looks live');
  assert.ok((await channels.count()) > 0);
  await cell.startDaemon();
  await live(page);
  await page.locator('.tile:not(.stale)', { has: page.getByText(/^°C$/) }).first().waitFor({ timeout: 30_000 });
  browser.assertQuiet();
});
