// Pictures of every view of a page that runs, light and dark, into a folder.
//   node scripts/screenshots.mjs URL FOLDER [name ...]        e.g. http://127.0.0.1:8080 ../../docs/screenshots now run
// What is shown is what the daemon there has: deploy/screenshots.sh makes a cell with a campaign first. Reports what the
// page wrote to its console or asked of other places, and then fails.
import { mkdirSync, writeFileSync, rmSync, mkdtempSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';
import { smallPng } from './small_png.mjs';

const [url, folder, ...only] = process.argv.slice(2);
if (!url || !folder) {
  console.error('usage: node scripts/screenshots.mjs URL FOLDER [name ...]');
  process.exit(2);
}
const env = (name, fallback) => process.env[`SHOT_${name}`] ?? fallback;

// name, address, what has to be seen before the picture is taken, and whether a phone's picture is taken too
const views = [
  { name: 'now', path: '/now', phone: true },
  { name: 'instruments', path: '/instruments' },
  { name: 'trajectory', path: `/trajectories/${env('TRAJECTORY', 1)}`, await: 'text=What a run of it would do', phone: true },
  { name: 'runs', path: '/runs' },
  { name: 'run', path: `/runs/${env('RUN', 1)}` },
  { name: 'run-plots', path: `/runs/${env('RUN', 1)}?tab=plots` },
  { name: 'models', path: '/models', prepare: typeFormula },
  { name: 'model', path: `/models/${env('MODEL', 1)}`, await: 'text=Terms of' },
  { name: 'model-residuals', path: `/models/${env('MODEL', 1)}?tab=residuals`, await: 'text=Over time' },
  { name: 'diagnosis', path: `/diagnosis/${env('DIAGNOSIS', 1)}`, await: 'text=What the discrepancy goes with', phone: true },
  { name: 'improvement', path: `/diagnosis/improve/${env('IMPROVEMENT', 1)}` },
  { name: 'targets', path: `/targets?${env('POSE', 'x=0.2&y=-0.1&z=1.2&force=0.392')}`, await: 'text=What the correction is made of', pause: 9000, phone: true },
  { name: 'record', path: '/record' },
];

async function typeFormula(page) {
  const field = page.getByRole('combobox', { name: 'Formula' });
  await field.fill('q ~ poly(x, y, z, 3) + F + F^2 + la');
  await page.getByRole('listbox').waitFor();
}

const flags = ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'];
const profile = mkdtempSync(join(tmpdir(), 'driftwise-shots-'));
const troubles = [];
const context = await chromium.launchPersistentContext(profile, { executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: flags, headless: true });
await context.route('**/*', (route) => {
  const asked = route.request().url();
  if (asked.startsWith(url) || asked.startsWith('blob:')) return route.continue();
  troubles.push(`asked for ${asked}`);
  return route.abort();
});
mkdirSync(folder, { recursive: true });
let bytes = 0;
const wanted = views.filter((view) => only.length === 0 || only.includes(view.name));
for (const view of wanted) {
  const page = await context.newPage();
  page.on('console', (message) => ['error', 'warning'].includes(message.type()) && troubles.push(`${view.name}: ${message.text()}`));
  page.on('pageerror', (error) => troubles.push(`${view.name}: ${error}`));
  await page.setViewportSize({ width: 1440, height: 900 });
  await page.goto(url + view.path);
  await page.locator('h1').first().waitFor();
  await page.locator(view.await ?? 'h1').first().waitFor({ timeout: 20_000 }).catch(() => troubles.push(`${view.name}: "${view.await}" was not seen`));
  await view.prepare?.(page).catch((error) => troubles.push(`${view.name}: ${error.message.split('\n')[0]}`));
  await page.waitForTimeout(view.pause ?? 1800);
  for (const [width, themes] of [[1440, ['light', 'dark']], ...(view.phone ? [[390, ['light']]] : [])]) {
    await page.setViewportSize({ width, height: width === 390 ? 844 : 900 });
    for (const theme of themes) {
      await page.emulateMedia({ colorScheme: theme });
      await page.waitForTimeout(700);
      const height = await page.evaluate(() => Math.max(document.documentElement.scrollHeight, innerHeight));
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      if (wide > 0) troubles.push(`${view.name}: ${wide} px wider than a window of ${width} px`);
      const picture = smallPng(await page.screenshot({ fullPage: true, clip: { x: 0, y: 0, width, height: Math.min(height, width === 390 ? 1700 : 1500) } }));
      writeFileSync(join(folder, `${view.name}-${theme}-${width}.png`), picture);
      bytes += picture.length;
    }
  }
  await page.close();
}
await context.close();
rmSync(profile, { recursive: true, force: true });
console.log(`${wanted.length} views, ${Math.round(bytes / 1024)} kB in ${folder}`);
for (const trouble of new Set(troubles)) console.error(trouble);
process.exit(troubles.length ? 1 : 0);
