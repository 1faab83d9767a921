// Every view of a cell with a run behind it and one under way: nothing on the console, nothing asked elsewhere, no finding of
// axe, nothing wider than the window; light and dark, at a desk and on a phone.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
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
  const rows = join(cell.folder, 'rows.csv');
  writeFileSync(rows, 'time_s,zero,q1_um,x_um,t01_K\n0,1,0,0,293.1\n60,0,1000,1000.2,293.2\n120,1,0,0.9,293.3\n');
  await cell.cli('Anna', 'data', 'import', rows, '--name', 'of a file');
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
  ['/manual', 'Manual'],
  ['/commissioning', 'Commissioning'],
  ['/trajectories', 'Trajectories'],
  ['/runs', 'Runs'],
  ['/runs/1', 'Run 1 · first'],
  ['/runs/1?tab=plots', 'Run 1 · first'],
  ['/runs/1?tab=dataset', 'Run 1 · first'],
  ['/runs/1?tab=log', 'Run 1 · first'],
  ['/runs/3?tab=plots', 'Run 3 · of a file'],
  ['/queue', 'Queue'],
  ['/plans', 'Plans'],
  ['/indentation', 'Indentation'],
  ['/procedure', 'Procedure'],
  ['/models', 'Models'],
  ['/models/1', undefined],
  ['/models/methods', 'Models'],
  ['/models/sensors', 'Models'],
  ['/diagnosis', 'Diagnosis'],
  ['/targets', 'Targets'],
  ['/lookback', 'Look back'],
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

// The views above are measured when they have their answers; the tools of a plot come with its record, and the hash of the cell file
// with the model.
for (const [path, last] of [['/runs/1?tab=plots', 'Deviation from the start'], ['/models/1', 'measured under cell file']]) {
  test(`${path} fits a phone once everything is there`, { timeout: 60_000 }, async () => {
    const page = await browser.page(path, { width: 390, height: 844 });
    await page.getByText(last).first().waitFor();
    assert.ok((await overflow(page)) <= 0, `wider than 390 px by ${await overflow(page)}`);
    await page.close();
  });
}

test('an imported run shows what its file has, and asks for no readings', { timeout: 60_000 }, async () => {
  const page = await browser.page('/runs/3?tab=plots');
  await page.getByText('K against hours since start · imported: values of its points, no readings on record').waitFor();
  await page.getByText('Channels shown: 1 of 3').waitFor();
  assert.equal(await page.getByRole('alert').count(), 0);
  await page.close();
});

// An axis that grows with t01; t02 and t03 wander by themselves.
function warmAxis(rows = 120) {
  const lines = ['time_s,set,line,zero,dwell_s,q1_mm,x_mm,t01_degC,t02_degC,t03_degC'];
  for (let i = 0; i < rows; i++) {
    const [x, t01, t02, t03] = [(i * 7) % 11, 21 + Math.sin(i / 17), 21 + Math.cos(i / 13), 21 + Math.sin(i / 29)].map((value) => value.toFixed(6));
    const noise = 1e-6 * (((i * 7919) % 101) - 50);
    lines.push(`${60 * i},${i % 5 === 4 ? 'validation' : 'calibration'},${Math.floor(i / 10)},0,10,${(Number(x) + 1e-3 * (t01 - 21) + noise).toFixed(9)},${x},${t01},${t02},${t03}`);
  }
  return `${lines.join('\n')}\n`;
}

// The answer's tables and pictures come only after the daemon's work, so they have a test of their own.
test('which thermometers suffice, by keyboard: progress, then an answer that is accessible and fits', { timeout: 180_000 }, async () => {
  for (const width of [1440, 390]) {
    const page = await browser.page('/models/sensors?formula=q1 ~ x %2B t01..t03', { width });
    await page.getByLabel('or a dataset, CSV').setInputFiles({ name: 'warm.csv', mimeType: 'text/csv', buffer: Buffer.from(warmAxis()) });
    await page.getByText(/terms for q1/).waitFor();
    await page.getByRole('button', { name: 'Try all sets' }).focus();
    await page.keyboard.press('Enter');
    await page.getByText('1 of 3 thermometers suffice').waitFor({ timeout: 90_000 });
    await page.getByRole('table', { name: 'The best set of each number of thermometers' }).waitFor();
    assert.deepEqual(await axe(page), []);
    assert.ok((await overflow(page)) <= 0, `wider than ${width} px by ${await overflow(page)}`);
    await page.close();
  }
  browser.assertQuiet();
});

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

// Last: a model serves from here on.
test('a target that no axis reaches, and one with twenty digits, fit a phone', { timeout: 60_000 }, async () => {
  await cell.cli('Anna', 'model', 'promote', '1', '--yes');
  for (const width of [390, 360]) {
    for (const x of ['9', '-1000000000']) {
      const page = await browser.page(`/targets?x=${x}&y=0&z=0`, { width });
      await page.getByText(/^not reachable: limits/).first().waitFor();
      assert.ok((await overflow(page)) <= 0, `x=${x}: wider than ${width} px by ${await overflow(page)}`);
      await page.close();
    }
  }
  browser.assertQuiet();
});
