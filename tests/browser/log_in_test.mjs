// The log-in of the page, on plain loopback and over TLS: who somebody is, what a role may not do, and how it ends.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { Browser, axe, live } from './lib/browser.mjs';
import { Cell } from './lib/cell.mjs';
import { skipUnlessAllIsThere } from './lib/places.mjs';

skipUnlessAllIsThere();

// A certificate of its own authority for 127.0.0.1.
function certificate(folder) {
  const [pem, key] = [join(folder, 'server.pem'), join(folder, 'server.key')];
  execFileSync('openssl', ['req', '-x509', '-newkey', 'ec', '-pkeyopt', 'ec_paramgen_curve:P-256', '-nodes', '-days', '2',
    '-subj', '/CN=cell', '-addext', 'subjectAltName=IP:127.0.0.1', '-keyout', key, '-out', pem], { stdio: 'ignore' });
  execFileSync('chmod', ['600', key]);
  return { pem, key };
}

let folder;
let cell;
let browser;
before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'driftwise-certificates-'));
  const { pem, key } = certificate(folder);
  cell = await Cell.start({
    speed: 50,
    access: `loopback = "token"\ncertificate = "${pem}"\nkey = "${key}"\nhttp = "127.0.0.1:0"`,
  });
  browser = await Browser.open(cell.url);
  browser.expected.push(/401|Failed to load resource/); // wrong tokens, which this test sends
}, { timeout: 120_000 });
after(async () => {
  await browser?.close();
  await cell?.stop();
  rmSync(folder, { recursive: true, force: true });
});

const token = async (name, role) => (await cell.cli('root', 'token', 'create', name, '--role', role)).text;

async function logIn(page, text) {
  await page.getByLabel('Token').fill(text);
  await page.getByRole('button', { name: 'Log in' }).click();
}

test('a wrong token is refused in a sentence, a good one shows name and role', { timeout: 60_000 }, async () => {
  const page = await browser.page('/now', { operator: '' });
  await page.getByRole('heading', { name: 'Log in' }).waitFor();
  assert.deepEqual(await axe(page), []);
  await logIn(page, 'dwt_wrong');
  await page.getByRole('alert').getByText(/token is not good/).waitFor();
  await logIn(page, await token('vera', 'viewer'));
  await live(page);
  await page.getByRole('button', { name: /^vera viewer/ }).waitFor();
  assert.equal(await page.evaluate(() => document.cookie), '', 'no cookie that a script can read');
  await page.close();
  browser.assertQuiet();
});

test('what a viewer may not do is refused by the daemon with a sentence; stop is not', { timeout: 60_000 }, async () => {
  const page = await browser.page('/instruments', { operator: '' });
  await live(page);
  await page.getByRole('button', { name: /^Set-point/ }).first().click();
  await page.getByLabel('New set-point, °C').fill('23.5');
  await page.getByRole('button', { name: 'Change…' }).click();
  await page.getByRole('button', { name: 'Set 23.500 °C' }).click();
  await page.getByRole('alert').getByText(/vera.*operator/).waitFor();
  await page.getByRole('button', { name: 'Stop motion' }).click();
  await page.getByText('Axes halted').first().waitFor();
  await page.close();
});

test('log-out ends the session in every tab', { timeout: 60_000 }, async () => {
  const [one, two] = [await browser.page('/now', { operator: '' }), await browser.page('/runs', { operator: '' })];
  await live(one);
  await live(two);
  await one.getByRole('button', { name: /^vera viewer/ }).click();
  await one.getByText(/sees everything and may stop/).waitFor();
  await one.getByRole('button', { name: 'Log out' }).click();
  await one.getByRole('heading', { name: 'Log in' }).waitFor();
  await two.getByRole('heading', { name: 'Log in' }).waitFor({ timeout: 20_000 });
  await one.close();
  await two.close();
});

test('the link of `driftwise open` works once', { timeout: 60_000 }, async () => {
  const { link } = await cell.cli('root', 'open');
  assert.match(link, /^http:\/\/127\.0\.0\.1:\d+\/log-in#dwl_/);
  const path = link.slice(cell.url.length);
  const page = await browser.page(path, { operator: '' });
  await live(page);
  await page.getByRole('button', { name: /admin$/ }).waitFor();
  assert.ok(!page.url().includes('dwl_'), 'the address keeps no link');
  await page.getByRole('button', { name: /admin$/ }).click();
  await page.getByRole('button', { name: 'Log out' }).click();
  await page.getByRole('heading', { name: 'Log in' }).waitFor();
  await page.close();
  const again = await browser.page(path, { operator: '' });
  await again.getByText(/used before/).waitFor();
  await again.close();
});

test('over TLS the same, with a cookie that no plain page gets', { timeout: 60_000 }, async () => {
  const origin = cell.notice().web_tls.replace(/\/$/, '');
  assert.match(origin, /^https:/);
  const secure = await Browser.open(origin, { ignoreHTTPSErrors: true });
  try {
    const page = await secure.page('/now', { operator: '' });
    await logIn(page, await token('olga', 'operator'));
    await live(page);
    await page.getByRole('button', { name: /^olga operator/ }).waitFor();
    const cookies = await secure.context.cookies();
    assert.equal(cookies.length, 1);
    assert.match(cookies[0].name, /^__Host-driftwise-/);
    assert.ok(cookies[0].secure && cookies[0].httpOnly && cookies[0].sameSite === 'Strict');
    await page.close();
    secure.assertQuiet();
  } finally {
    await secure.close();
  }
});
