// Pictures of every view, light and dark, into a folder: deploy/screenshots.sh builds what this needs and calls it.
//   node scripts/screenshots.mjs [--out FOLDER] [--speed N] [--keep]                       makes a cell and a campaign first
//   node scripts/screenshots.mjs --url http://127.0.0.1:8080 [--out FOLDER] [view ...]     photographs a page that runs
// Everything shown is real: a daemon, a simulated Micro-Nano, what they measured, fitted, found and improved. --keep leaves the
// cell running afterwards, until a signal. It fails, after taking the pictures, when the page wrote to its console, asked for
// anything elsewhere or was wider than its window.
import { mkdirSync, writeFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs } from 'node:util';
import { Browser, overflow } from '../../../tests/browser/lib/browser.mjs';
import { Cell } from '../../../tests/browser/lib/cell.mjs';
import { smallPng } from './small_png.mjs';

const { values: wanted, positionals: only } = parseArgs({
  allowPositionals: true,
  options: {
    url: { type: 'string' },
    out: { type: 'string', default: join(dirname(fileURLToPath(import.meta.url)), '../../../docs/screenshots') },
    speed: { type: 'string', default: '60' },
    hide: { type: 'string', default: 'backlash:q2=300nm' }, // what the diagnosis has to find
    keep: { type: 'boolean', default: false },
    trajectory: { type: 'string' }, // of the campaign; else campaignPlan()
  },
});
const folder = resolve(wanted.out);
mkdirSync(folder, { recursive: true });
const troubles = new Set();
let bytes = 0;

// name, address, when ("running": while the campaign is measured; "served": as soon as a model serves; "robots": of the cell with two robots), what has to be seen before
// the picture is taken, whether a phone's picture is taken too, how tall at most or down to the end of which panel
const views = [
  { name: 'now', path: '/now', when: 'running', phone: true, pause: 4000 },
  { name: 'instruments', path: '/instruments?since=1h', when: 'running', phone: true, pause: 4000, tall: 1700 },
  { name: 'manual', path: '/manual', when: 'running', pause: 3000 },
  { name: 'trajectory', path: '/trajectories/1', when: 'running', seen: 'What a run of it would do' },
  { name: 'queue', path: '/queue', when: 'running', seen: 'weekend 2', phone: true },
  { name: 'targets', path: '/targets?x=0.2&y=-0.1&z=1.2&force=0.768', when: 'served', seen: 'What the correction is made of', phone: true, pause: 6000, tall: 1700 },
  { name: 'commissioning', path: '/commissioning', prepare: checkCell },
  { name: 'runs', path: '/runs', phone: true },
  { name: 'run', path: '/runs/1', phone: true, tall: 1300 },
  { name: 'run-plots', path: '/runs/1?tab=plots', tall: 1900 },
  { name: 'models', path: '/models', phone: true, prepare: typeFormula },
  { name: 'model', path: '/models/3', seen: 'Terms of', phone: true },
  { name: 'model-residuals', path: '/models/3?tab=residuals', seen: 'Over time', tall: 1300 },
  { name: 'rollback', path: '/models', prepare: askRollBack },
  { name: 'methods', path: '/models/methods?run=1', prepare: study('Compare methods', 'Methods, least error first'), tall: 1300 },
  { name: 'sensors', path: '/models/sensors?run=1&formula=q ~ poly(x, y, z, 3) %2B F %2B t04..t09', prepare: study('Try all sets', 'The best set of each size'), tall: 1600 },
  { name: 'procedure', path: '/procedure', seen: 'wanted accuracy reached', phone: true },
  { name: 'diagnosis', path: '/diagnosis/1', seen: 'What the discrepancy goes with', phone: true, until: 'q2 has play' },
  { name: 'improvement', path: '/diagnosis/improve/1', seen: 'Turn 1' },
  { name: 'lookback', path: '/lookback', prepare: lookBack },
  { name: 'record', path: '/record', phone: true, tall: 1100 },
  { name: 'plans', path: '/plans', when: 'robots', seen: 'serves' },
  { name: 'indentation', path: '/indentation/1', when: 'robots', seen: 'Contacts', tall: 1700 },
];

async function typeFormula(page) {
  const field = page.getByRole('combobox', { name: 'Formula' });
  await field.fill('q ~ poly(x, y, z, 3) + F + t07');
  await page.getByText(/calibration and/).first().waitFor();
  await field.fill('q ~ poly(x, y, z, 3) + F + t0');
  await page.getByRole('listbox').waitFor();
}

async function checkCell(page) {
  await page.getByRole('button', { name: 'Check the cell' }).click();
  await page.getByRole('table').first().waitFor({ timeout: 60_000 });
}

async function askRollBack(page) {
  await page.getByRole('button', { name: 'Roll back…' }).click();
  await page.getByRole('dialog').waitFor({ timeout: 60_000 });
}

async function lookBack(page) {
  await page.locator('select').first().selectOption('t07_degC');
  await page.getByRole('button', { name: 'Analyse' }).click();
  await page.locator('.plot').first().waitFor({ timeout: 60_000 });
}

// What a daemon works out for the page takes its time.
function study(verb, seen) {
  return async (page) => {
    await page.getByText(/terms for q1/).first().waitFor();
    await page.getByRole('button', { name: verb, exact: true }).click();
    await page.getByText(seen).first().waitFor({ timeout: 300_000 });
  };
}

// Where the panel ends that says this, with the gap below it.
async function endOf(page, words) {
  const box = await page.locator('section', { hasText: words }).last().boundingBox({ timeout: 5000 });
  return Math.ceil(box.y + box.height) + 16;
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
    note(String(error.message).split('\n')[0]);
  }
  await page.waitForTimeout(view.pause ?? 1500);
  for (const [width, themes] of [[1440, ['light', 'dark']], ...(view.phone ? [[390, ['light']]] : [])]) {
    // As tall as the page, so that what sticks to an edge of the window does; a phone's window is a phone's.
    await page.setViewportSize({ width, height: width === 390 ? 844 : 900 });
    const height = await page.evaluate(() => document.documentElement.scrollHeight);
    const tall = view.until ? await endOf(page, view.until).catch(() => (note(`no panel says '${view.until}'`), 1500)) : view.tall ?? 1500;
    if (width !== 390) await page.setViewportSize({ width, height: Math.max(600, Math.min(height, tall)) });
    for (const theme of themes) {
      await page.emulateMedia({ colorScheme: theme });
      await page.waitForTimeout(1200);
      const wide = await overflow(page);
      if (wide > 0) note(`${wide} px wider than a window of ${width} px`);
      const picture = smallPng(await page.screenshot());
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

// A short grid for the loop: one layer after the other with a return to zero before each.
function loopPlan() {
  const rows = ['q1_mm,q2_mm,q3_mm,set,line,zero'];
  for (let i = 0; i < 5; ++i) {
    rows.push(`0,0,0,calibration,${i},1`);
    for (let j = 0; j < 25; ++j) rows.push([0.2 + 0.5 * (j % 5), 0.2 + 0.5 * Math.floor(j / 5), 0.2 + 0.5 * i].map((q) => q.toFixed(2)).join(',') + `,${(25 * i + j) % 4 === 2 ? 'validation' : 'calibration'},${i},0`);
  }
  return rows.join('\n') + '\n';
}

// 4 x 4 x 4 places, there and back in a snake, so that every axis comes from both sides; without force, and with it on the way back.
function campaignPlan() {
  const rows = ['q1_mm,q2_mm,q3_mm,set,line,zero,force_N'];
  const places = [0.2, 0.95, 1.7, 2.45];
  let visited = 0;
  for (const [pass, force] of [0, 0.768].entries()) {
    for (const [layer, q3] of places.entries()) {
      const line = 4 * pass + layer;
      rows.push(`0,0,0,calibration,${line},1,${force}`);
      const snake = places.flatMap((q1, i) => (i % 2 ? places.toReversed() : places).map((q2) => `${q1},${q2},${q3}`));
      for (const place of pass ? snake.toReversed() : snake) rows.push(`${place},${++visited % 4 === 3 ? 'validation' : 'calibration'},${line},0,${force}`);
    }
  }
  return rows.join('\n') + '\n';
}

async function bring(browser, file, name) {
  const page = await browser.page('/trajectories');
  await page.getByLabel('a file, CSV').setInputFiles(file);
  await page.getByText('What a run of it would do').waitFor();
  await page.getByRole('button', { name: 'Keep it' }).click();
  await page.getByRole('heading', { level: 1, name }).waitFor();
  await page.close();
}

// A campaign as a person makes it, through the page; pictures on the way.
async function wholeStory() {
  const cell = await Cell.start({ cell: 'micro-nano', speed: Number(wanted.speed), hide: wanted.hide });
  const browser = await Browser.open(cell.url);
  console.log(`the cell: ${cell.url} in ${cell.folder}`);
  const done = async () => (await cell.cli('Anna', 'run', 'show', '1')).run;
  const until = async (test) => {
    for (let run = await done(); !test(run); run = await done()) {
      if (['failed', 'aborted'].includes(run.state)) throw new Error(`the campaign is ${run.state}: ${run.reason}`);
      await new Promise((later) => setTimeout(later, 500));
    }
  };
  const plan = wanted.trajectory ?? join(cell.folder, 'weekend.csv');
  try {
    if (!wanted.trajectory) writeFileSync(plan, campaignPlan());
    await bring(browser, plan, /^Trajectory 1/);
    await cell.cli('Anna', 'run', 'start', plan, '--name', 'weekend');
    await until((run) => run.accepted_count > 0.55 * run.row_count);
    const waiting = [['weekend 2', '--when', 't04 < 18 degC for 30 min', '--then', 'fit:q ~ poly(x, y, z, 3) + F + R'], ['weekend 3', '--not-before', '2030-01-05T20:00:00Z']];
    for (const [name, ...options] of waiting) await cell.cli('Anna', 'queue', 'add', plan, '--name', name, ...options);
    await photographAll(browser, views.filter((view) => view.when === 'running'));
    for (const id of [1, 2]) await cell.cli('Anna', 'queue', 'remove', `${id}`);
    await until((run) => run.state === 'done');
    await cell.cli('Anna', 'run', 'tag', '1', 'wanted_a90.x_nm=100', 'wanted_a90.y_nm=100', 'wanted_a90.z_nm=100');
    console.log('measured; now fitted, diagnosed, improved');
    const geometry = 'q ~ poly(x, y, z, 3)';
    await cell.cli('Anna', 'fit', '--run', '1', '--model', geometry, '--name', 'geometry');
    await cell.cli('Anna', 'fit', '--run', '1', '--model', `${geometry} + F`, '--name', 'geometry, force');
    await cell.cli('Anna', 'fit', '--run', '1', '--model', `${geometry} + F + R`, '--name', 'geometry, force, heat');
    for (const id of ['2', '3']) await cell.cli('Anna', 'model', 'promote', id, '--yes', '--reason', 'to be looked at');
    await photographAll(browser, views.filter((view) => view.when === 'served'));
    await diagnose(browser);
    await improve(browser, cell);
    await photographAll(browser, views.filter((view) => view.when === undefined));
    if (wanted.keep) {
      console.log(`kept: ${cell.url}`);
      await new Promise((end) => ['SIGINT', 'SIGTERM'].forEach((signal) => process.once(signal, end)));
    }
  } finally {
    await browser.close();
    await cell.stop();
  }
}

// Of the model that serves; through the page.
async function diagnose(browser) {
  const page = await browser.page('/diagnosis?model=3');
  await page.getByRole('button', { name: 'Diagnose' }).click();
  await page.locator('.state', { hasText: /Adequate|Extended|Unexplained|Failed/ }).waitFor({ timeout: 1_800_000 });
  await page.close();
}

// The loop from a plane, through the page, until it ends by itself.
async function improve(browser, cell) {
  const plan = join(cell.folder, 'loop.csv');
  writeFileSync(plan, loopPlan());
  await bring(browser, plan, /^Trajectory 2/);
  const page = await browser.page('/diagnosis');
  await page.getByLabel('trajectory of every turn').selectOption({ label: 'loop.csv, 130 rows' });
  await page.getByLabel('formula of the first model').fill('q ~ poly(x, y, z, 2)');
  await page.getByLabel('turns, at most').fill('2');
  await page.getByLabel('time of the cell, at most').fill('3'); // a separating measurement may take a day
  await page.getByRole('button', { name: 'Start the improvement…' }).click();
  await page.getByRole('dialog').getByRole('button', { name: 'Start the improvement' }).click();
  await page.locator('.state', { hasText: /Done|Failed|Cancelled/ }).waitFor({ timeout: 1_800_000 });
  await page.close();
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
