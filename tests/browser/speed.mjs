// Not a test but a measurement, for an idle machine: how soon the first number is there, what the open page costs, how smooth a
// zoom is. Usage: node speed.mjs [run]      run: rows of the run whose plots are zoomed, 300 unless told
import { readdirSync, readFileSync } from 'node:fs';
import { Browser, live } from './lib/browser.mjs';
import { Cell, diagonal } from './lib/cell.mjs';
import { skipUnlessAllIsThere } from './lib/places.mjs';

skipUnlessAllIsThere();
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));
const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1];

// CPU seconds of a process and all its descendants.
function cpuOf(roots) {
  const stats = readdirSync('/proc').filter((name) => /^\d+$/.test(name)).flatMap((pid) => {
    try {
      const fields = readFileSync(`/proc/${pid}/stat`, 'utf8').replace(/^.*\) /, '').split(' ');
      return [{ pid: Number(pid), parent: Number(fields[1]), s: (Number(fields[11]) + Number(fields[12])) / 100 }];
    } catch {
      return [];
    }
  });
  const wanted = new Set(roots);
  for (let grew = true; grew; ) {
    grew = false;
    for (const one of stats) if (wanted.has(one.parent) && !wanted.has(one.pid)) grew = !!wanted.add(one.pid);
  }
  return stats.filter((one) => wanted.has(one.pid)).reduce((sum, one) => sum + one.s, 0);
}

const browserPids = (profile) => readdirSync('/proc').filter((pid) => {
  try {
    return /^\d+$/.test(pid) && readFileSync(`/proc/${pid}/cmdline`, 'utf8').includes(profile);
  } catch {
    return false;
  }
}).map(Number);

async function firstNumber(url) {
  const browser = await Browser.open(url);
  const page = await browser.page('/now');
  const ms = await page.evaluate(() => new Promise((done) => {
    const look = () => (/\d/.test(document.querySelector('.tile .value')?.textContent ?? '') ? done(performance.now()) : requestAnimationFrame(look));
    look();
  }));
  await browser.close();
  return ms;
}

async function share(label, cell, browser, path, seconds = 10) {
  const page = await browser.page(path);
  await live(page);
  await sleep(4000);
  const counts = await page.evaluate(() => ({ plots: document.querySelectorAll('.uplot').length, tiles: document.querySelectorAll('.live, .tile .value').length }));
  const [of, d] = [browserPids(browser.profile), [cell.daemon.pid]];
  const [b0, d0, t0] = [cpuOf(of), cpuOf(d), performance.now()];
  await sleep(seconds * 1000);
  const s = (performance.now() - t0) / 1000;
  console.log(`${label}: ${counts.plots} plots, ${counts.tiles} live numbers: browser ${((100 * (cpuOf(of) - b0)) / s).toFixed(1)} % of a core, daemon ${((100 * (cpuOf(d) - d0)) / s).toFixed(1)} %`);
  await page.close();
}

async function zoom(browser) {
  const page = await browser.page('/runs/1?tab=plots');
  await page.locator('.plot-box canvas').first().waitFor();
  await sleep(1500);
  const figures = await page.evaluate(async () => {
    const over = document.querySelector('.plot-box .u-over');
    const box = over.getBoundingClientRect();
    const times = [];
    const frames = await new Promise((done) => {
      let n = 0;
      const end = performance.now() + 3000;
      const frame = () => {
        const before = performance.now();
        over.dispatchEvent(new WheelEvent('wheel', { ctrlKey: true, deltaY: n % 60 < 30 ? -1 : 1, clientX: box.left + box.width / 2, clientY: box.top + 20, cancelable: true }));
        times.push(performance.now() - before);
        n++;
        if (before < end) requestAnimationFrame(frame);
        else done(n);
      };
      requestAnimationFrame(frame);
    });
    return { perSecond: frames / 3, plots: document.querySelectorAll('.uplot').length };
  });
  console.log(`zoom: ${figures.perSecond.toFixed(1)} frames/s on ${figures.plots} plots`);
  await page.close();
}

const cell = await Cell.start({ speed: 20 });
try {
  const firsts = [];
  for (let i = 0; i < 5; i++) firsts.push(await firstNumber(cell.url));
  console.log(`first number after ${median(firsts).toFixed(0)} ms (cold profile, median of 5: ${firsts.map((ms) => ms.toFixed(0)).join(', ')})`);
  await cell.cli('Anna', 'run', 'start', cell.trajectory('plan.csv', diagonal(Number(process.argv[2] ?? 300))), '--name', 'long');
  const browser = await Browser.open(cell.url);
  await share('Now', cell, browser, '/now');
  await share('Instruments', cell, browser, '/instruments?since=10min');
  await zoom(browser);
  await browser.close();
} finally {
  await cell.stop();
}
