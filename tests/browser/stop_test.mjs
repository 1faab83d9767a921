// Stop motion on every view, and over every dialog: a dialog makes the bar inert, and so has a Stop of its own in the same place.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { axe, Browser, live, overflow } from './lib/browser.mjs';
import { Cell, diagonal } from './lib/cell.mjs';
import { skipUnlessAllIsThere } from './lib/places.mjs';

skipUnlessAllIsThere();

let cell;
let browser;
before(async () => {
  cell = await Cell.start({ speed: 50 });
  await cell.cli('Carla', 'run', 'start', cell.trajectory('plan.csv', diagonal(200)), '--name', 'long');
  browser = await Browser.open(cell.url);
}, { timeout: 120_000 });
after(async () => {
  await browser?.close();
  await cell?.stop();
});

const wide = { width: 1440, height: 900 };
const phone = { width: 390, height: 844 };
const press = (name) => (page) => page.getByRole('button', { name, exact: true }).click();
const dialogs = [
  { what: 'the name', open: press('Your name?'), size: wide, operator: '' }, // first: the browser keeps the names that come after
  { what: 'a question', open: press('Abort…'), size: wide },
  { what: 'a question on a phone', open: press('Abort…'), size: phone },
  { what: 'settings and keys', open: press('Settings and keys'), size: wide },
  { what: 'more views on a phone', open: press('More'), size: phone },
];

for (const { what, open, size, operator } of dialogs) {
  test(`Stop motion is pressed where it always is while ${what} stands open, and Esc ends only the dialog`, { timeout: 60_000 }, async () => {
    const page = await browser.page('/now', { ...size, operator });
    await live(page);
    const place = await page.locator('.bar button.stop').boundingBox();
    const views = await page.evaluate(() => location.href);
    await open(page);
    const dialog = page.getByRole('dialog');
    await dialog.waitFor();
    assert.ok(!(await page.evaluate(() => document.activeElement.matches('.stop'))), 'the focus is on Stop: Enter would press it');
    assert.deepEqual(await axe(page), []);
    assert.equal(await overflow(page), 0);
    const heard = page.waitForEvent('websocket', (socket) => socket.url().includes('/StopAll'));
    await page.mouse.move(place.x + place.width / 2, place.y + place.height / 2);
    await page.mouse.down(); // and never up
    await heard;
    await dialog.getByText('Axes halted').first().waitFor();
    await page.keyboard.press('Escape');
    await dialog.waitFor({ state: 'hidden' });
    assert.equal(await page.evaluate(() => location.href), views);
    await page.close();
    browser.assertQuiet();
  });
}

test('Stop motion reaches the daemon while all six connections of the browser are taken, and once for each press of Space', { timeout: 60_000 }, async () => {
  const page = await browser.page('/now', wide);
  await live(page);
  await page.evaluate(() => {
    for (let i = 0; i < 6; i++) void fetch('/driftwise.v1.WatchService/Watch', { method: 'POST', headers: { 'content-type': 'application/grpc-web+proto' }, body: new Uint8Array(5) });
  });
  let sockets = 0;
  page.on('websocket', () => sockets++);
  const begun = Date.now();
  await page.locator('.bar button.stop').focus();
  await page.keyboard.press('Space');
  await page.locator('.bar').getByText('Axes halted').waitFor();
  const tookMs = Date.now() - begun;
  assert.ok(tookMs < 4000, `Stop took ${tookMs} ms: it waited for a connection`);
  assert.equal(sockets, 1);
  await page.close();
  browser.assertQuiet();
});

test('Stop motion of a dialog is reached and pressed by the keyboard', { timeout: 60_000 }, async () => {
  const page = await browser.page('/now', wide);
  await live(page);
  await page.getByRole('button', { name: 'Abort…' }).click();
  const dialog = page.getByRole('dialog');
  await dialog.waitFor();
  for (let i = 0; i < 6 && !(await page.evaluate(() => document.activeElement.matches('dialog .stop'))); i++) await page.keyboard.press('Tab');
  await page.keyboard.press('Enter');
  await dialog.getByText('Axes halted').first().waitFor();
  await page.close();
  browser.assertQuiet();
});
