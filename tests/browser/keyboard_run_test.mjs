// An operator without a mouse: Tab, Enter and what is typed are enough to keep a trajectory, start its run, acknowledge an alarm and read
// the result; and it is seen at every stop where the focus is.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { Browser, live } from './lib/browser.mjs';
import { Cell, diagonal } from './lib/cell.mjs';
import { skipUnlessAllIsThere } from './lib/places.mjs';

skipUnlessAllIsThere();

const mostStops = 150;
let cell;
let browser;
before(async () => {
  cell = await Cell.start({ speed: 200 });
  browser = await Browser.open(cell.url);
}, { timeout: 120_000 });
after(async () => {
  await browser?.close();
  await cell?.stop();
});

// Of what has the focus: its name, and whether an eye finds it.
function stop() {
  const at = document.activeElement;
  const label = at.labels?.[0]?.textContent;
  const name = at === document.body ? '' : (at.getAttribute('aria-label') ?? label ?? at.textContent ?? '').trim();
  // A file input hides behind its button, a radio behind its label: those show the focus then.
  const shown = at.matches('input[type=file]') ? at.nextElementSibling : at.matches('.segments input') ? at.closest('label') : at;
  const box = shown.getBoundingClientRect();
  const style = getComputedStyle(shown);
  const marked = style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) >= 2;
  const inSight = box.width > 0 && box.bottom > 0 && box.top < innerHeight && box.right > 0 && box.left < innerWidth;
  const over = document.elementFromPoint((Math.max(box.left, 0) + Math.min(box.right, innerWidth)) / 2, (Math.max(box.top, 0) + Math.min(box.bottom, innerHeight)) / 2);
  const free = !over || shown.contains(over) || over.contains(shown);
  return { name, tag: at.tagName, seen: (marked && inSight && free) || at === document.body || at.id === 'main' || at.tagName === 'H1' };
}

// Tab until the focus is on it. Every stop on the way must be seen.
async function tabTo(page, name) {
  const unseen = new Set();
  for (let i = 0; i < mostStops; ++i) {
    await page.keyboard.press('Tab');
    const at = await page.evaluate(stop);
    if (!at.seen) unseen.add(`${at.tag} '${at.name.slice(0, 60)}'`);
    if (typeof name === 'string' ? at.name === name : name.test(at.name)) {
      assert.deepEqual([...unseen], [], 'stops of Tab where the focus is not seen');
      return;
    }
  }
  assert.fail(`${name}: not reached with ${mostStops} Tabs`);
}

test('a run is started, an alarm acknowledged and the result read without a mouse', { timeout: 240_000 }, async () => {
  const page = await browser.page('/now');
  await live(page);
  await page.keyboard.press('g');
  await page.keyboard.press('t');
  await page.getByRole('heading', { level: 1, name: 'Trajectories' }).waitFor();
  await tabTo(page, 'or paste it, or mend it');
  await page.keyboard.press('Enter');
  await tabTo(page, /^trajectory, CSV/);
  await page.keyboard.insertText(['q1_mm,q2_mm,q3_mm,set,line,zero', ...diagonal(20)].join('\n') + '\n');
  await page.getByText('What a run of it would do').waitFor();
  await tabTo(page, 'Keep it');
  await page.keyboard.press('Enter');
  await page.getByRole('heading', { level: 1, name: /^Trajectory \d+/ }).waitFor();
  await tabTo(page, 'name of the run');
  await page.keyboard.type('by keyboard');
  await tabTo(page, 'Start a run…');
  await page.keyboard.press('Enter');
  const dialog = page.getByRole('dialog');
  await dialog.getByText(/rows checked, all within/).waitFor();
  await tabTo(page, 'Start a run');
  await page.keyboard.press('Enter');
  await page.getByRole('heading', { level: 1, name: /^Run 1\b/ }).waitFor();
  await page.locator('.run-word', { hasText: 'Done' }).waitFor({ timeout: 120_000 });

  // The room's thermometers are silent: an alarm.
  await cell.control('fault mute scanner 1000000 s');
  await page.keyboard.press('g');
  await page.keyboard.press('n');
  await page.getByRole('heading', { level: 1, name: 'Now' }).waitFor({ state: 'attached' });
  await page.getByRole('button', { name: /^Acknowledge: .*scanner/ }).first().waitFor({ timeout: 60_000 });
  await tabTo(page, /^Acknowledge: .*scanner/);
  await page.keyboard.press('Enter');
  await page.getByText(/acknowledged by Anna|Anna has seen it|seen by Anna/i).first().waitFor();

  await page.keyboard.press('g');
  await page.keyboard.press('r');
  await page.getByRole('heading', { level: 1, name: 'Runs' }).waitFor();
  await page.getByRole('cell', { name: 'by keyboard' }).waitFor();
  await page.keyboard.press('j');
  assert.equal((await page.evaluate(stop)).name, '1');
  assert.ok((await page.evaluate(stop)).seen, 'the row that j chose is seen');
  await page.keyboard.press('Enter');
  await page.getByRole('heading', { level: 1, name: 'Run 1 · by keyboard' }).waitFor();
  await page.getByText(/24 of 24/).first().waitFor();
  await tabTo(page, /^Points/);
  await page.keyboard.press('Enter');
  await page.close();
  browser.assertQuiet();
});
