// Not a test but a measurement: what an open page costs the browser, and ten clients that watch the daemon, each beside its floor
// in the same run, in turns. Usage: node cost.mjs [rounds, 5 unless told] [seconds of each, 8 unless told]
//   the page    Instruments over 10 minutes of a cell at 20 times the speed, a run under way, 1440 x 900.
//               Floor: an empty page on which two numbers in opposite corners change as often as the view paints.
//   watching    ten clients of Watch over gRPC-Web, 20 updates a second asked for.
//               Floor: a program that does nothing but write as many bytes as often to ten connections.
// Shares of a core are processor time over wall time, of all processes of the browser or of the daemon.
// DRIFTWISE_WEB_DIR: another page's folder, to compare two.
import { spawn } from 'node:child_process';
import { loadavg } from 'node:os';
import { Browser, live } from './lib/browser.mjs';
import { Cell, diagonal } from './lib/cell.mjs';
import { skipUnlessAllIsThere } from './lib/places.mjs';
import { browserPids, percentOfACore } from './lib/processor_time.mjs';

skipUnlessAllIsThere();
const [rounds, seconds] = [Number(process.argv[2] ?? 5), Number(process.argv[3] ?? 8)];
const paintsPerS = 4;
const clients = 10;
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));
const inOrder = (values) => [...values].sort((a, b) => a - b);
const middle = (values) => inOrder(values)[values.length >> 1];
const shown = (values) => `${middle(values).toFixed(1)} (${inOrder(values)[0].toFixed(1)} to ${inOrder(values).at(-1).toFixed(1)})`;

// ---------- the page

async function emptyPage(browser) {
  const page = await browser.context.newPage();
  await page.setViewportSize({ width: 1440, height: 900 });
  await page.setContent('<p>0</p><p style="position: fixed; right: 8px; bottom: 8px">0</p>');
  await page.evaluate((everyMs) => setInterval(() => requestAnimationFrame((now) => {
    for (const one of document.querySelectorAll('p')) one.textContent = now.toFixed(1);
  }), everyMs), 1000 / paintsPerS);
  return page;
}

async function pageCost(cell) {
  const browser = await Browser.open(cell.url);
  const share = () => percentOfACore(() => browserPids(browser.profile), seconds);
  const [floor, view, updates] = [[], [], []];
  for (let round = 0; round < rounds; round++) {
    const empty = await emptyPage(browser);
    await sleep(2000);
    floor.push(await share());
    await empty.close();
    const page = await browser.page('/instruments?since=10min', { counting: true });
    await live(page);
    await sleep(4000);
    const [before, began] = [await page.evaluate(() => globalThis.updates), performance.now()];
    view.push(await share());
    updates.push(((await page.evaluate(() => globalThis.updates)) - before) / ((performance.now() - began) / 1000));
    await page.close();
  }
  await browser.close();
  console.log(`Instruments, 10 min: ${shown(view)} % of a core at ${middle(updates).toFixed(1)} updates/s; floor ${shown(floor)} %; ratio ${middle(view.map((one, i) => one / floor[i])).toFixed(1)}; goal 15 %`);
}

// ---------- clients that watch

// A WatchRequest with max_hz (field 3, a double) of 20, in a frame of gRPC-Web.
function request() {
  const message = Buffer.alloc(9);
  message[0] = (3 << 3) | 1;
  message.writeDoubleLE(20, 1);
  const head = Buffer.alloc(5);
  head.writeUInt32BE(message.length, 1);
  return Buffer.concat([head, message]);
}

class Watchers {
  pieces = 0;
  bytes = 0;
  abort = new AbortController();
  begin(url, many) {
    for (let i = 0; i < many; i++) void this.one(url);
  }
  async one(url) {
    try {
      const answer = await fetch(`${url}/driftwise.v1.WatchService/Watch`, { method: 'POST', headers: { 'content-type': 'application/grpc-web+proto' }, body: request(), signal: this.abort.signal });
      for await (const piece of answer.body) (this.pieces++, (this.bytes += piece.length));
    } catch (error) {
      if (!this.abort.signal.aborted) throw error;
    }
  }
}

const bareSender = `
const [bytes, hz] = process.argv.slice(1).map(Number);
const piece = Buffer.alloc(bytes);
const sockets = new Set();
require('node:http').createServer((ask, answer) => {
  sockets.add(answer);
  answer.on('close', () => sockets.delete(answer));
  answer.flushHeaders();
}).listen(0, '127.0.0.1', function () { console.log(this.address().port); });
setInterval(() => sockets.forEach((one) => one.write(piece)), 1000 / hz);
`;

async function sender(bytes, hz) {
  const child = spawn(process.execPath, ['-e', bareSender, String(Math.round(bytes)), String(hz)], { stdio: ['ignore', 'pipe', 'inherit'] });
  const port = await new Promise((done) => child.stdout.once('data', (data) => done(Number(data))));
  return { child, url: `http://127.0.0.1:${port}` };
}

async function watched(url, pid, many) {
  const watchers = new Watchers();
  watchers.begin(url, many);
  await sleep(1500);
  const [pieces, bytes, began] = [watchers.pieces, watchers.bytes, performance.now()];
  const share = await percentOfACore(() => [pid], seconds);
  const s = (performance.now() - began) / 1000;
  watchers.abort.abort();
  return { share, perS: (watchers.pieces - pieces) / s / Math.max(1, many), bytes: (watchers.bytes - bytes) / Math.max(1, watchers.pieces - pieces) };
}

async function watchCost(cell) {
  const [none, one, ten, floor, perS] = [[], [], [], [], []];
  const added = (list) => list.map((share, i) => share - none[i]);
  for (let round = 0; round < rounds; round++) {
    none.push((await watched(cell.url, cell.daemon.pid, 0)).share);
    one.push((await watched(cell.url, cell.daemon.pid, 1)).share);
    const many = await watched(cell.url, cell.daemon.pid, clients);
    ten.push(many.share);
    perS.push(many.perS);
    const bare = await sender(many.bytes, many.perS);
    floor.push((await watched(bare.url, bare.child.pid, clients)).share);
    bare.child.kill();
  }
  console.log(`daemon without watchers ${shown(none)} %; one adds ${shown(added(one))} %; ${clients} add ${shown(added(ten))} % at ${middle(perS).toFixed(1)} updates/s each; floor ${shown(floor)} %; ratio ${middle(added(ten).map((share, i) => share / floor[i])).toFixed(1)}; goal 5 %`);
}

const cell = await Cell.start({ speed: 20 });
try {
  console.log(`load of the machine before: ${loadavg().map((one) => one.toFixed(1)).join(' ')}`);
  await cell.cli('Anna', 'run', 'start', cell.trajectory('plan.csv', diagonal(1500)), '--name', 'under way');
  await sleep(15_000); // five minutes of the cell: the pictures have something to show
  await watchCost(cell);
  await pageCost(cell);
  console.log(`load of the machine after: ${loadavg().map((one) => one.toFixed(1)).join(' ')}`);
} finally {
  await cell.stop();
}
