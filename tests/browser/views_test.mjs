// Every view of a cell with a run behind it and one under way: nothing on the console, nothing asked elsewhere, no finding of
// axe, nothing wider than the window; light and dark, at a desk and on a phone.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { axe, Browser, live, overflow } from './lib/browser.mjs';
import { Cell, diagonal } from './lib/cell.mjs';
import { skipUnlessAllIsThere } from './lib/places.mjs';

skipUnlessAllIsThere();

let cell;
let browser;
before(async () => {
  cell = await Cell.start({ speed: 200 });
  await cell.cli('Anna', 'run', 'start', cell.trajectory('short.csv', diagonal(10)), '--name', 'first', '--watch');
  await cell.cli('Anna', 'fit', '--run', '1', '--model', 'q ~ x + y + z', '--name', 'plane');
  await cell.cli('Anna', 'run', 'start', cell.trajectory('long.csv', diagonal(400)), '--name', 'under way');
  browser = await Browser.open(cell.url);
}, { timeout: 180_000 });
after(async () => {
  await browser?.close();
  await cell?.stop();
});

// First, while the run is surely under way.
test('across a room: numbers, and nothing to press', async () => {
  const page = await browser.page('/now?wall=1');
  await page.getByText('Running', { exact: true }).waitFor();
  assert.equal(await page.locator('main').getByRole('button').count(), 0);
  await page.close();
});

const views = [
  ['/now', 'Now'],
  ['/instruments?since=10min', 'Instruments'],
  ['/trajectories', 'Trajectories'],
  ['/runs', 'Runs'],
  ['/runs/1', 'Run 1 · first'],
  ['/runs/1?tab=plots', 'Run 1 · first'],
  ['/runs/1?tab=dataset', 'Run 1 · first'],
  ['/runs/1?tab=log', 'Run 1 · first'],
  ['/models', 'Models'],
  ['/models/1', undefined],
  ['/diagnosis', 'Diagnosis'],
  ['/targets', 'Targets'],
  ['/record', 'Record'],
];

for (const [path, title] of views) {
  test(`${path} is quiet, accessible and fits, light and dark, desk and phone`, { timeout: 120_000 }, async () => {
    for (const width of [1440, 390]) {
      const page = await browser.page(path, { width });
      await live(page);
      await page.getByRole('heading', { level: 1, ...(title && { name: title }) }).waitFor({ state: 'attached' });
      await page.waitForFunction(() => !document.querySelector('.awaiting'));
      for (const dark of [false, true]) {
        await page.emulateMedia({ colorScheme: dark ? 'dark' : 'light' });
        assert.deepEqual(await axe(page), [], `axe, ${width} px, ${dark ? 'dark' : 'light'}`);
      }
      assert.ok((await overflow(page)) <= 0, `wider than ${width} px by ${await overflow(page)}`);
      await page.close();
    }
    browser.assertQuiet();
  });
}

test('an address that is nobody’s is refused by the daemon, and within the page goes to Now', async () => {
  const refused = await fetch(`${cell.url}/nowhere`);
  assert.equal(refused.status, 404);
  assert.match(await refused.text(), /nothing here/);
  const page = await browser.page('/runs');
  await live(page);
  await page.evaluate(() => {
    history.pushState(null, '', '/nowhere');
    dispatchEvent(new PopStateEvent('popstate'));
  });
  await page.getByRole('heading', { level: 1, name: 'Now' }).waitFor({ state: 'attached' });
  assert.equal(new URL(page.url()).pathname, '/now');
  await page.close();
  browser.assertQuiet();
});
