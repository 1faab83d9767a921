// Chromium with an empty profile. Every page is watched: a message on its console, an error, a request beyond the daemon is a
// fault of the test that opened it.
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromiumPath, ofWeb } from './places.mjs';

const flags = [
  '--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync',
];

// What the page's stream brings: the pieces of bytes that are read of it, counted where they arrive.
function countUpdates() {
  globalThis.updates = 0;
  const read = ReadableStreamDefaultReader.prototype.read;
  ReadableStreamDefaultReader.prototype.read = function (...rest) {
    const piece = read.apply(this, rest);
    void piece.then(({ value }) => value instanceof Uint8Array && globalThis.updates++, () => undefined);
    return piece;
  };
}

export class Browser {
  static async open(origin, { ignoreHTTPSErrors = false } = {}) {
    const browser = new Browser();
    browser.profile = mkdtempSync(join(tmpdir(), 'driftwise-profile-'));
    const { chromium } = ofWeb('playwright-core'); // here: who imports this file may skip without it
    browser.context = await chromium.launchPersistentContext(browser.profile, { executablePath: chromiumPath, args: flags, acceptDownloads: true, ignoreHTTPSErrors });
    browser.faults = [];
    browser.expected = []; // patterns of console messages that a test brings about itself (a daemon that was killed)
    await browser.context.route('**/*', (route) => {
      const { origin: asked } = new URL(route.request().url());
      if (asked === origin) return route.continue();
      browser.faults.push(`a request beyond the daemon: ${route.request().url()}`);
      return route.abort();
    });
    browser.origin = origin;
    return browser;
  }

  async page(path, { width = 1440, height = 900, dark = false, operator = 'Anna', counting = false } = {}) {
    const page = await this.context.newPage();
    page.on('console', (message) => ['error', 'warning'].includes(message.type()) && this.fault(`console: ${message.text()}`));
    page.on('pageerror', (error) => this.fault(`page error: ${error.stack}`));
    page.setDefaultTimeout(20_000);
    await page.emulateMedia({ colorScheme: dark ? 'dark' : 'light', reducedMotion: 'reduce' });
    await page.setViewportSize({ width, height });
    if (operator) await page.addInitScript((name) => localStorage.setItem('driftwise.operator', name), operator);
    if (counting) await page.addInitScript(countUpdates);
    await page.goto(this.origin + path);
    return page;
  }

  fault(words) {
    if (!this.expected.some((pattern) => pattern.test(words))) this.faults.push(words);
  }

  // Nothing on any console, nothing asked elsewhere, so far.
  assertQuiet() {
    assert.deepEqual(this.faults.splice(0), []);
  }

  async close() {
    await this.context.close();
    rmSync(this.profile, { recursive: true, force: true });
  }
}

export const live = (page) => page.getByText('Live', { exact: true }).waitFor();

// What axe finds, as sentences; [] is good.
export async function axe(page) {
  await page.evaluate(readFileSync(ofWeb.resolve('axe-core/axe.min.js'), 'utf8'));
  const { violations } = await page.evaluate(() => globalThis.axe.run({ preload: false }));
  return violations.flatMap(({ id, nodes }) => nodes.map((node) => `${id}: ${node.target.join(' ')}: ${node.failureSummary.split('\n').slice(1, 3).join(' ')}`));
}

export const overflow = (page) => page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
