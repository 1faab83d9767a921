// A real daemon before a real simulated cell, in a folder of its own under the system's temporary one, on ports that were
// free. The daemon can be killed and started again at the same address, as a page sees it.
import { spawn } from 'node:child_process';
import { connect, createServer } from 'node:net';
import { appendFileSync, existsSync, mkdtempSync, openSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { binFolder, sourceFolder, webFolder } from './places.mjs';

const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

async function until(what, test, seconds = 60) {
  for (const end = Date.now() + seconds * 1000; Date.now() < end; await sleep(50)) {
    const found = test();
    if (found) return found;
  }
  throw new Error(`${what}: not within ${seconds} s`);
}

async function freePort() {
  const server = createServer();
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  const { port } = server.address();
  await new Promise((done) => server.close(done));
  return port;
}

function ended(child) {
  return child.exitCode !== null || child.signalCode !== null;
}

async function end(child, signal) {
  if (!child || ended(child)) return;
  child.kill(signal);
  await new Promise((done) => child.once('exit', done));
}

export class Cell {
  // access: text of the [access] section; {folder} in it is the cell's folder. hide: causes that the plant hides, as --hide takes them.
  static async start({ cell = 'micro-nano', speed = 100, seed = 1, settings = [], hide = undefined, access = undefined } = {}) {
    const started = new Cell();
    started.folder = mkdtempSync(join(tmpdir(), 'driftwise-browser-'));
    const from = join(sourceFolder, 'deploy/cells', cell);
    try {
      await started.startPlant(from, speed, seed, [...settings.flatMap((one) => ['--set', one]), ...(hide ? ['--hide', hide] : [])]);
      await started.keepAddress();
      if (access !== undefined) appendFileSync(join(started.folder, 'cell.toml'), `\n[access]\n${access.replaceAll('{folder}', started.folder)}\n`);
      await started.startDaemon();
    } catch (error) {
      await started.stop();
      throw error;
    }
    return started;
  }

  log(name) {
    return openSync(join(this.folder, name), 'a');
  }

  async startPlant(from, speed, seed, options) {
    const out = join(this.folder, 'cellsim.out');
    this.plant = spawn(join(binFolder, 'driftwise-cellsim'), [
      '--plant', join(from, 'plant.toml'), '--cell', join(from, 'cell.toml'), '--instantiate', this.folder,
      '--speed', String(speed), '--seed', String(seed), ...options,
    ], { stdio: ['ignore', openSync(out, 'w'), this.log('cellsim.log')] });
    await until('driftwise-cellsim ready', () => {
      if (ended(this.plant)) throw new Error(`driftwise-cellsim ended:\n${readFileSync(join(this.folder, 'cellsim.log'), 'utf8').slice(-2000)}`);
      return existsSync(out) && readFileSync(out, 'utf8').includes('READY');
    });
  }

  // A line to the simulated cell's control port: "fault mute scanner 10 s".
  async control(line) {
    const ready = JSON.parse(readFileSync(join(this.folder, 'cellsim.out'), 'utf8').split('READY ')[1].split('\n')[0]);
    const [host, port] = ready.control.split(':');
    const answer = await new Promise((done, failed) => {
      const socket = connect(Number(port), host, () => socket.write(line + '\n'));
      socket.once('error', failed).once('data', (data) => { socket.end(); done(String(data).trim()); });
    });
    if (!answer.startsWith('OK')) throw new Error(`${line}: ${answer}`);
  }

  // The web address must outlive a restart, for a page that stays open.
  async keepAddress() {
    const file = join(this.folder, 'cell.toml');
    const text = readFileSync(file, 'utf8');
    this.port = await freePort();
    const http = `http = "127.0.0.1:${this.port}"`;
    writeFileSync(file, /^http *=.*$/m.test(text) ? text.replace(/^http *=.*$/m, http) : text.replace(/^\[cell\]$/m, `[cell]\n${http}`));
    this.url = `http://127.0.0.1:${this.port}`;
  }

  async startDaemon() {
    const notice = join(this.folder, 'driftwised.json');
    rmSync(notice, { force: true });
    this.daemon = spawn(join(binFolder, 'driftwised'), ['--cell', join(this.folder, 'cell.toml'), '--web-root', join(webFolder, 'dist')], {
      stdio: ['ignore', this.log('driftwised.out'), this.log('driftwised.log')],
    });
    await until('driftwised ready', () => {
      if (ended(this.daemon)) throw new Error(`driftwised ended:\n${readFileSync(join(this.folder, 'driftwised.log'), 'utf8').slice(-2000)}`);
      return existsSync(notice);
    });
  }

  // What driftwised.json says: "web_tls", "grpc_tls", ...
  notice() {
    return JSON.parse(readFileSync(join(this.folder, 'driftwised.json'), 'utf8'));
  }

  kill() {
    return end(this.daemon, 'SIGKILL');
  }

  stopDaemon() {
    return end(this.daemon, 'SIGTERM');
  }

  // The command line as another person at another desk would use it; the answer of --json (the last one of a watch).
  async cli(operator, ...command) {
    const child = spawn(join(binFolder, 'driftwise'), ['--operator', operator, ...command, '--json'], { cwd: this.folder });
    let out = '';
    let err = '';
    child.stdout.on('data', (data) => (out += data));
    child.stderr.on('data', (data) => (err += data));
    const code = await new Promise((done) => child.once('close', done));
    if (code !== 0) throw new Error(`driftwise ${command.join(' ')} ended with ${code}: ${err}`);
    try {
      return out.trim() === '' ? undefined : JSON.parse(out);
    } catch {
      return JSON.parse(out.trim().split('\n').pop());
    }
  }

  // A small plan within the soft limits, as a file.
  trajectory(name, rows) {
    const file = join(this.folder, name);
    writeFileSync(file, ['q1_mm,q2_mm,q3_mm,set,line,zero', ...rows].join('\n') + '\n');
    return file;
  }

  async stop() {
    await end(this.daemon, 'SIGTERM');
    await end(this.plant, 'SIGTERM');
    rmSync(this.folder, { recursive: true, force: true });
  }
}

// count positions along the diagonal, a return to zero before every fifth.
export function diagonal(count) {
  const rows = [];
  for (let i = 0; i < count; i++) {
    if (i % 5 === 0) rows.push(`0,0,0,calibration,${i / 5},1`);
    const q = (0.2 + (2 * i) / count).toFixed(3);
    rows.push(`${q},${q},${q},${i % 2 ? 'validation' : 'calibration'},${Math.floor(i / 5)},0`);
  }
  return rows;
}
