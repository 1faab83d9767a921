// A whole campaign from the page alone, on the simulated Micro-Nano: a trajectory is brought and run, a model fitted from a
// formula that had a typo first, promoted, asked for a compensated target, rolled back to, and the run diagnosed. And what the page says to
// files that are none.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { axe, Browser, live } from './lib/browser.mjs';
import { Cell } from './lib/cell.mjs';
import { skipUnlessAllIsThere } from './lib/places.mjs';

skipUnlessAllIsThere();

const longMs = 240_000;
let cell;
let browser;
before(async () => {
  cell = await Cell.start({ cell: 'micro-nano', speed: 200, seed: 7 });
  browser = await Browser.open(cell.url);
}, { timeout: 120_000 });
after(async () => {
  await browser?.close();
  await cell?.stop();
});

// A grid of 4 x 4 x 4 with a return to zero before every layer and every fifth point kept for validation.
function plan() {
  const rows = ['q1_mm,q2_mm,q3_mm,set,line,zero'];
  for (let i = 0; i < 4; ++i) {
    rows.push(`0,0,0,calibration,${i},1`);
    for (let j = 0; j < 16; ++j) {
      const set = (i * 16 + j) % 5 === 3 ? 'validation' : 'calibration';
      rows.push([0.3 + 0.6 * (j % 4), 0.3 + 0.6 * Math.floor(j / 4), 0.3 + 0.6 * i].map((q) => q.toFixed(2)).join(',') + `,${set},${i},0`);
    }
  }
  return rows.join('\n') + '\n';
}

const file = (name, content) => {
  const path = join(cell.folder, name);
  writeFileSync(path, content);
  return path;
};
const heading = (page, name) => page.getByRole('heading', { level: 1, name });
const dialog = (page) => page.getByRole('dialog');

test('files that are no trajectory are refused where they are, with line and field', { timeout: 60_000 }, async () => {
  const page = await browser.page('/trajectories');
  await live(page);
  const input = page.getByLabel('a file, CSV');
  await input.setInputFiles(file('empty.csv', ''));
  await page.getByText('empty.csv is empty').waitFor();
  await input.setInputFiles(file('words.csv', 'dear robot, please go there\n'));
  await page.getByText(/UNKNOWN|unknown|expected/).first().waitFor();
  await input.setInputFiles(file('far.csv', 'q1_mm,q2_mm,q3_mm\n0,0,0\n0,99,0\n'));
  const refusal = page.getByRole('alert').filter({ hasText: 'Check the trajectory' });
  await refusal.getByText(/99/).waitFor();
  const keep = page.getByRole('button', { name: 'Keep it' });
  assert.equal(await keep.getAttribute('aria-disabled'), 'true');
  // Mended where it stands, it can be kept; and a reload loses nothing of what was typed.
  await page.getByLabel(/trajectory, CSV/).fill('q1_mm,q2_mm,q3_mm\n0,0,0\n0,1,0\n');
  await page.reload();
  await live(page);
  await page.getByText('What a run of it would do').waitFor();
  assert.equal(await page.getByLabel(/trajectory, CSV/).inputValue(), 'q1_mm,q2_mm,q3_mm\n0,0,0\n0,1,0\n');
  await page.getByRole('button', { name: 'Start afresh' }).click();
  await page.close();
  browser.assertQuiet();
});

test('a trajectory is brought, looked at, kept and run', { timeout: longMs }, async () => {
  const page = await browser.page('/trajectories');
  await live(page);
  await page.getByLabel('a file, CSV').setInputFiles(file('plan.csv', plan()));
  await page.getByText('What a run of it would do').waitFor();
  await page.getByText('68: 55 calibration, 13 validation; 4 of them returns to zero').waitFor();
  await page.getByRole('slider').waitFor();
  assert.deepEqual(await axe(page), []);
  await page.getByRole('button', { name: 'Keep it' }).click();
  await heading(page, /^Trajectory \d+, plan\.csv$/).waitFor();
  await page.getByLabel('name of the run').fill('from the page');
  await page.getByRole('button', { name: 'Start a run…' }).click();
  await dialog(page).getByText(/68 rows checked, all within/).waitFor();
  await dialog(page).getByRole('button', { name: 'Start a run' }).click();
  await heading(page, /^Run 1\b/).waitFor();
  await page.getByText(/^([5-9]|\d\d) of 68 /).first().waitFor(); // a mark lies between points
  await page.getByRole('button', { name: 'Pause', exact: true }).click();
  await page.locator('.run-word', { hasText: 'Paused' }).waitFor();
  await page.getByRole('button', { name: 'Resume…' }).click();
  await dialog(page).getByText(/Anna, .* ago/).waitFor();
  await dialog(page).getByRole('button', { name: 'Resume run 1' }).click();
  await page.locator('.run-word', { hasText: 'Done' }).waitFor({ timeout: longMs });
  // The pause, as the daemon wrote it into the record, is a line in every plot over time.
  await page.getByText('1 stop or pause').first().waitFor();
  await page.close();
  browser.assertQuiet();
});

test('a formula with a typo keeps what was typed, and mended it is fitted and promoted', { timeout: 60_000 }, async () => {
  const page = await browser.page('/models');
  await live(page);
  const formula = page.getByRole('combobox', { name: 'Formula' });
  await formula.fill('q ~ poly(x, y, z, 2) + to7');
  await page.getByText(/unknown channel 'to7'/).waitFor();
  await page.keyboard.press('Escape');
  await page.getByRole('button', { name: 'Fit', exact: true }).click();
  await page.getByRole('alert').getByText(/to7/).waitFor();
  await page.reload();
  await live(page);
  assert.equal(await formula.inputValue(), 'q ~ poly(x, y, z, 2) + to7');
  await formula.fill('q ~ poly(x, y, z, 2) + t0');
  await formula.press('ArrowDown');
  await page.getByRole('listbox', { name: /what could follow/ }).getByRole('option').first().waitFor();
  await formula.fill('q ~ poly(x, y, z, 2) + t07');
  await page.getByText(/10 terms for q1, q2, q3; 55 calibration and 13 validation rows; rank 11 of 11/).waitFor();
  await page.keyboard.press('Escape');
  await page.getByRole('button', { name: 'Fit', exact: true }).click();
  await heading(page, /^Model 1\b/).waitFor();
  assert.deepEqual(await axe(page), []);
  await page.getByRole('link', { name: 'Residuals' }).click();
  await page.getByText('Over time').waitFor();
  await page.getByRole('button', { name: 'Promote…' }).click();
  await dialog(page).getByRole('button', { name: 'Promote model 1' }).click();
  await page.getByText('serves targets').first().waitFor();
  await page.close();
  browser.assertQuiet();
});

test('the model answers with a compensated target and a map', { timeout: 60_000 }, async () => {
  const page = await browser.page('/targets');
  await live(page);
  await page.getByLabel('x, mm').fill('0.1x');
  await page.getByText('a number in mm is expected', { exact: true }).waitFor();
  await page.getByLabel('x, mm').fill('0.1');
  await page.waitForURL(/x=0\.1/);
  await page.getByLabel('z, mm').fill('1.2');
  await page.getByText('What the correction is made of').waitFor();
  const q1 = await page.locator('.targets-coordinate').first().innerText();
  assert.match(q1, /q1\s+[-−]?\d\.\d{3}\s\d{3}\s\d{2}\s+mm/u);
  await page.getByText(/Point at a place for its value/).waitFor();
  assert.deepEqual(await axe(page), []);
  await page.close();
  browser.assertQuiet();
});

test('a rollback says what serves again and what stands against it', { timeout: 120_000 }, async () => {
  await cell.cli('Anna', 'fit', '--run', '1', '--model', 'q ~ x + y + z');
  await cell.cli('Anna', 'model', 'promote', '2', '--yes');
  const page = await browser.page('/models');
  await live(page);
  await page.getByText('Model 2 serves targets').waitFor();
  await page.getByRole('button', { name: 'Roll back…' }).click();
  await dialog(page).getByRole('heading', { name: 'Roll back from model 2?' }).waitFor();
  await dialog(page).getByText('q ~ poly(x, y, z, 2) + t07').waitFor();
  await dialog(page).getByText(/ nm \(q\d, .*, mean .*, S90 /).waitFor();
  await dialog(page).getByText('no run since model 1 was made shows whether the robot still does what it says').waitFor();
  assert.deepEqual(await axe(page), []);
  await dialog(page).getByRole('button', { name: 'Serve model 1 all the same' }).click();
  await page.getByText('Model 1 serves targets').waitFor();
  await page.getByRole('button', { name: 'Roll back…' }).click();
  await dialog(page).getByText(/every target is refused/).waitFor();
  await dialog(page).getByRole('button', { name: 'Keep model 1' }).click();
  await page.close();
  browser.assertQuiet();
});

test('the run is diagnosed against the model that serves', { timeout: longMs }, async () => {
  const page = await browser.page('/diagnosis');
  await live(page);
  await page.getByRole('button', { name: 'Diagnose' }).click();
  await heading(page, /^Diagnosis 1\b/).waitFor();
  await page.locator('.state', { hasText: /Adequate|Extended|Unexplained/ }).waitFor({ timeout: longMs });
  await page.getByText(/^Before: ±/).waitFor();
  await page.getByText(/What the discrepancy goes with/).waitFor();
  assert.deepEqual(await axe(page), []);
  await page.close();
  browser.assertQuiet();
});
