// Pictures of every view, light and dark, into a folder: deploy/screenshots.sh builds what this needs and calls it.
//   node scripts/screenshots.mjs [--out FOLDER] [--speed N] [--trajectory FILE]   makes a cell, a campaign, a diagnosis first
//   node scripts/screenshots.mjs --url http://127.0.0.1:8080 [--out FOLDER] [view ...]     photographs a page that runs
// Everything shown is real: a daemon, a simulated Micro-Nano, what they measured. It fails, after taking the pictures, when the
// page wrote to its console, asked for anything elsewhere or was wider than its window.
import { mkdirSync, writeFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs } from 'node:util';
import { Browser, overflow } from '../../../tests/browser/lib/browser.mjs';
import { Cell } from '../../../tests/browser/lib/cell.mjs';
import { sourceFolder } from '../../../tests/browser/lib/places.mjs';
import { smallPng } from './small_png.mjs';

const { values: wanted, positionals: only } = parseArgs({
  allowPositionals: true,
  options: {
    url: { type: 'string' },
    out: { type: 'string', default: join(dirname(fileURLToPath(import.meta.url)), '../../../docs/screenshots') },
    speed: { type: 'string', default: '200' },
    trajectory: { type: 'string', default: join(sourceFolder, 'deploy/cells/micro-nano/trajectories/published.csv') },
  },
});
const folder = resolve(wanted.out);
mkdirSync(folder, { recursive: true });
const troubles = new Set();
let bytes = 0;

// name, address, what has to be seen before the picture is taken, whether a phone's picture is taken too
const views = [
  { name: 'now', path: '/now', while: 'running', phone: true, pause: 4000 },
  { name: 'instruments', path: '/instruments?since=1h', while: 'running', pause: 4000 },
  { name: 'trajectory', path: '/trajectories/1', while: 'running', seen: 'What a run of it would do', phone: true },
  { name: 'runs', path: '/runs' },
  { name: 'run', path: '/runs/1', phone: true },
  { name: 'run-plots', path: '/runs/1?tab=plots' },
  { name: 'models', path: '/models', prepare: typeFormula },
  { name: 'model', path: '/models/2', seen: 'Terms of' },
  { name: 'model-residuals', path: '/models/2?tab=residuals', seen: 'Over time' },
  { name: 'diagnosis', path: '/diagnosis/1', seen: 'What the discrepancy goes with', phone: true },
  { name: 'improvement', path: '/diagnosis/improve/1', optional: true },
  { name: 'targets', path: '/targets?x=0.2&y=-0.1&z=1.2&force=0.392', seen: 'What the correction is made of', pause: 9000, phone: true },
  { name: 'record', path: '/record' },
];

async function typeFormula(page) {
  const field = page.getByRole('combobox', { name: 'Formula' });
  await field.fill('q ~ poly(x, y, z, 3) + F + ');
  await page.getByText(/calibration and|expected/).first().waitFor();
  await field.fill('q ~ poly(x, y, z, 3) + F + la');
  await page.getByRole('listbox').waitFor();
}

async function photograph(browser, view) {
  const note = (words) => troubles.add(`${view.name}: ${words}`);
  const page = await browser.page(view.path);
  page.setDefaultTimeout(20_000);
  try {
    await page.locator('h1').first().waitFor({ state: 'attached' });
    if (view.seen) await page.getByText(view.seen).first().waitFor();
    await view.prepare?.(page);
  } catch (error) {
    if (!view.optional) note(String(error.message).split('\n')[0]);
  }
  await page.waitForTimeout(view.pause ?? 1500);
  for (const [width, themes] of [[1440, ['light', 'dark']], ...(view.phone ? [[390, ['light']]] : [])]) {
    await page.setViewportSize({ width, height: width === 390 ? 844 : 900 });
    for (const theme of themes) {
      await page.emulateMedia({ colorScheme: theme });
      await page.waitForTimeout(600);
      const wide = await overflow(page);
      if (wide > 0) note(`${wide} px wider than a window of ${width} px`);
      const height = await page.evaluate(() => Math.max(document.documentElement.scrollHeight, innerHeight));
      const picture = smallPng(await page.screenshot({ fullPage: true, clip: { x: 0, y: 0, width, height: Math.min(height, width === 390 ? 1700 : 1500) } }));
      writeFileSync(join(folder, `${view.name}-${theme}-${width}.png`), picture);
      bytes += picture.length;
    }
  }
  for (const fault of browser.faults.splice(0)) note(fault);
  await page.close();
}

const photographAll = async (browser, which) => {
  for (const view of which) await photograph(browser, view);
};

// A campaign as a person makes it, the trajectory brought through the page; pictures on the way.
async function wholeStory() {
  const cell = await Cell.start({ cell: 'micro-nano', speed: Number(wanted.speed) });
  const browser = await Browser.open(cell.url);
  const done = async () => (await cell.cli('Anna', 'run', 'show', '1')).run;
  const until = async (test) => {
    for (let run = await done(); !test(run); run = await done()) {
      if (['failed', 'aborted'].includes(run.state)) throw new Error(`the campaign is ${run.state}: ${run.reason}`);
      await new Promise((later) => setTimeout(later, 500));
    }
  };
  try {
    const page = await browser.page('/trajectories');
    await page.getByLabel('a file, CSV').setInputFiles(wanted.trajectory);
    await page.getByText('What a run of it would do').waitFor();
    await page.getByRole('button', { name: 'Keep it' }).click();
    await page.getByRole('heading', { level: 1, name: /^Trajectory 1/ }).waitFor();
    await page.close();
    await cell.cli('Anna', 'run', 'start', wanted.trajectory, '--name', 'weekend');
    await until((run) => run.accepted_count > 0.55 * run.row_count);
    await photographAll(browser, views.filter((view) => view.while === 'running'));
    await until((run) => run.state === 'done');
    console.log('measured; now fitted, diagnosed, improved');
    await cell.cli('Anna', 'fit', '--run', '1', '--model', 'q ~ poly(x, y, z, 3)', '--name', 'geometry');
    await cell.cli('Anna', 'fit', '--run', '1', '--model', 'q ~ poly(x, y, z, 3) + F + F^2 + t04..t10', '--name', 'geometry, force, heat');
    await cell.cli('Anna', 'model', 'promote', '2');
    await diagnose(browser, cell);
    await photographAll(browser, views.filter((view) => view.while !== 'running'));
  } finally {
    await browser.close();
    await cell.stop();
  }
}

// Against geometry alone, so that there is something to find; through the page.
async function diagnose(browser, cell) {
  const page = await browser.page('/diagnosis?model=1');
  await page.getByRole('button', { name: 'Diagnose' }).click();
  await page.locator('.state', { hasText: /Adequate|Extended|Unexplained|Failed/ }).waitFor({ timeout: 600_000 });
  await page.close();
  void cell;
}

if (wanted.url) {
  const browser = await Browser.open(wanted.url.replace(/\/$/, ''));
  await photographAll(browser, views.filter((view) => only.length === 0 || only.includes(view.name)));
  await browser.close();
} else {
  await wholeStory();
}
console.log(`${Math.round(bytes / 1024)} kB of pictures in ${folder}`);
for (const trouble of troubles) console.error(trouble);
process.exit(troubles.size ? 1 : 0);
