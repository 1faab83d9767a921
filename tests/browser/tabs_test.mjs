// Seven tabs at once over one stream; the leading tab is closed, and the others go on.
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
  browser = await Browser.open(cell.url);
}, { timeout: 120_000 });
after(async () => {
  await browser?.close();
  await cell?.stop();
});

test('seven tabs share one stream, and survive their leader', { timeout: 120_000 }, async () => {
  const streams = [];
  browser.context.on('request', (request) => request.url().endsWith('/Watch') && streams.push(request));
  const pages = [];
  for (const path of ['/now', '/instruments', '/runs', '/models', '/targets', '/record', '/now?wall=1']) pages.push(await browser.page(path));
  for (const page of pages.slice(0, 6)) await live(page);
  await pages[6].locator('.tile').first().waitFor();
  assert.equal(streams.length, 1, 'one stream for all tabs');

  const started = cell.cli('Anna', 'run', 'start', cell.trajectory('plan.csv', diagonal(5)), '--name', 'for all tabs');
  await pages[0].getByText('Running', { exact: true }).waitFor();
  await pages[6].getByText('Running', { exact: true }).waitFor();
  await started;

  await pages[0].close(); // it was first, so it leads
  await new Promise((done) => setTimeout(done, 4500)); // longer than a silent page is taken for live
  for (const page of pages.slice(1, 6)) await live(page);
  assert.equal(streams.length, 2, 'one more stream: the next leader');
  await pages[2].getByRole('row', { name: /for all tabs/ }).getByText('Done').waitFor({ timeout: 60_000 });
  browser.assertQuiet();
});
