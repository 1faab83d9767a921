// Not a test but a measurement: how soon the first number is there, what the open page costs, how soon a run of 60 hours is
// seen, what a zoom step costs. Shares of a core are processor time over wall time, so that other work on the machine does not
// count, and come with the number of updates they paid for. Usage: node speed.mjs [hours of the long run, 60 unless told]
import { execFileSync } from 'node:child_process';
import { loadavg } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { Browser, live } from './lib/browser.mjs';
import { Cell, diagonal } from './lib/cell.mjs';
import { skipUnlessAllIsThere } from './lib/places.mjs';
import { browserPids, processorSeconds as cpuOf } from './lib/processor_time.mjs';

skipUnlessAllIsThere();
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));
const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1];

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
  const page = await browser.page(path, { counting: true });
  await live(page);
  await sleep(4000);
  const counts = await page.evaluate(() => ({ plots: document.querySelectorAll('.uplot').length, tiles: document.querySelectorAll('.live, .tile .value').length }));
  const [of, d] = [browserPids(browser.profile), [cell.daemon.pid]];
  const [b0, d0, n0, t0] = [cpuOf(of), cpuOf(d), await page.evaluate(() => globalThis.updates), performance.now()];
  await sleep(seconds * 1000);
  const s = (performance.now() - t0) / 1000;
  const updates = ((await page.evaluate(() => globalThis.updates)) - n0) / s;
  const daemon = (100 * (cpuOf(d) - d0)) / s;
  console.log(`${label}: ${counts.plots} plots, ${counts.tiles} live numbers, ${updates.toFixed(1)} updates/s: browser ${((100 * (cpuOf(of) - b0)) / s).toFixed(1)} % of a core, daemon ${daemon.toFixed(1)} %`);
  await page.close();
}

// What the daemon costs without a page: the cell's own work, to be taken off.
async function daemonAlone(cell, seconds = 10) {
  const [d0, t0] = [cpuOf([cell.daemon.pid]), performance.now()];
  await sleep(seconds * 1000);
  console.log(`no page: daemon ${((100 * (cpuOf([cell.daemon.pid]) - d0)) / ((performance.now() - t0) / 1000)).toFixed(1)} %`);
}

// When the record of the run is there and drawn, on the page's own clock, and how long the daemon took to answer.
async function openRun(browser, path) {
  const before = cpuOf(browserPids(browser.profile));
  const page = await browser.page(path);
  const figures = await page.evaluate(async () => {
    const series = () => performance.getEntriesByType('resource').filter((one) => one.name.endsWith('/GetSeries') && one.responseEnd > 0);
    while (series().length === 0) await new Promise((later) => setTimeout(later, 5));
    const last = series().at(-1);
    await new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(drawn))));
    return { drawn: performance.now(), answer: last.responseEnd - last.requestStart, bytes: last.encodedBodySize };
  });
  return { page, ...figures, cpu: 1000 * (cpuOf(browserPids(browser.profile)) - before) };
}

// Zoom steps by the wheel: what the page's main thread spends on one, in processor time (CDP), script, layout and painting.
async function zoom(browser, page, label) {
  const client = await browser.context.newCDPSession(page);
  await client.send('Performance.enable', { timeDomain: 'threadTicks' });
  const busy = async () => (await client.send('Performance.getMetrics')).metrics.find((one) => one.name === 'TaskDuration').value * 1000;
  await sleep(1500);
  const before = await busy();
  const steps = await page.evaluate(async () => {
    const over = document.querySelector('.plot-box .u-over');
    const box = over.getBoundingClientRect();
    const end = performance.now() + 4000;
    let n = 0;
    while (performance.now() < end) {
      over.dispatchEvent(new WheelEvent('wheel', { ctrlKey: true, deltaY: n % 40 < 20 ? -1 : 1, clientX: box.left + box.width / 2, clientY: box.top + 20, cancelable: true }));
      await new Promise((drawn) => requestAnimationFrame(drawn));
      n++;
    }
    return n;
  });
  const per = ((await busy()) - before) / steps;
  const answers = await page.evaluate(() => performance.getEntriesByType('resource').filter((one) => one.name.endsWith('/GetSeries')).map((one) => one.responseEnd - one.requestStart));
  const plots = await page.evaluate(() => document.querySelectorAll('.uplot').length);
  console.log(`${label}: ${plots} plots together, ${per.toFixed(1)} ms of the main thread per zoom step (${steps} steps); the daemon answered ${answers.length} times, ${median(answers).toFixed(0)} ms in the middle`);
}

// A short run made long by hand: a second, a reading, 30 channels.
async function longRun(cell, hours) {
  await cell.stopDaemon();
  const script = join(dirname(fileURLToPath(import.meta.url)), 'lib/long_run.py');
  const database = join(cell.folder, 'driftwise.sqlite');
  const channels = execFileSync('python3', [script, database, String(hours)], { encoding: 'utf8' }).trim();
  await cell.startDaemon();
  const behind = () => Number(execFileSync('python3', ['-c', 'import sqlite3, sys; c = sqlite3.connect(f"file:{sys.argv[1]}?mode=ro", uri=True); print(c.execute("SELECT (SELECT max(reading_id) FROM reading) - reading_id FROM series_mark").fetchone()[0])', database], { encoding: 'utf8' }));
  const began = performance.now();
  while (behind() > 4096) await sleep(1000);
  console.log(`summaries of ${hours} h x 30 channels made in ${((performance.now() - began) / 1000).toFixed(0)} s, beside the cell's work`);
  return channels;
}

const hours = Number(process.argv[2] ?? 60);
const cell = await Cell.start({ speed: 20 });
try {
  console.log(`load of the machine before: ${loadavg().map((one) => one.toFixed(1)).join(' ')}`);
  const firsts = [];
  for (let i = 0; i < 5; i++) firsts.push(await firstNumber(cell.url));
  console.log(`first number after ${median(firsts).toFixed(0)} ms (cold profile, median of 5: ${firsts.map((ms) => ms.toFixed(0)).join(', ')})`);
  await cell.cli('Anna', 'run', 'start', cell.trajectory('short.csv', diagonal(5)), '--name', 'long', '--watch');
  await cell.cli('Anna', 'run', 'start', cell.trajectory('plan.csv', diagonal(300)), '--name', 'under way');
  await daemonAlone(cell);
  const browser = await Browser.open(cell.url);
  await share('Now', cell, browser, '/now');
  await share('Instruments, 10 min', cell, browser, '/instruments?since=10min');
  await share('Instruments, 1 h', cell, browser, '/instruments?since=1h');
  const channels = await longRun(cell, hours);
  const opened = [];
  for (let i = 0; i < 5; i++) {
    const { page, ...figures } = await openRun(browser, `/runs/1?tab=plots&ch=${channels}`);
    opened.push(figures);
    if (i === 4) await zoom(browser, page, `run of ${hours} h, 30 channels`);
    await page.close();
  }
  console.log(`run of ${hours} h opens in ${median(opened.map((one) => one.drawn)).toFixed(0)} ms (median of 5: ${opened.map((one) => one.drawn.toFixed(0)).join(', ')}), of that the daemon's answer ${median(opened.map((one) => one.answer)).toFixed(0)} ms, ${(opened[0].bytes / 1000).toFixed(0)} kB; ${median(opened.map((one) => one.cpu)).toFixed(0)} ms of processor time over all browser processes`);
  await browser.close();
  console.log(`load of the machine after: ${loadavg().map((one) => one.toFixed(1)).join(' ')}`);
} finally {
  await cell.stop();
}
