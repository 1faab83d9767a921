// The page from another computer: a real browser at a daemon that is reached over TLS, logged in by a token, once with
// each role. Executed by the test of the second network namespace, inside it: node across.mjs ORIGIN TOKEN_FOLDER
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { Browser, live } from './lib/browser.mjs';
import { skipUnlessAllIsThere } from './lib/places.mjs';

skipUnlessAllIsThere();

const [origin, folder] = process.argv.slice(2);
// What each may not do, as the page's own client would ask for it; the last one may do all.
const roles = [
  { role: 'viewer', call: 'CellService/Home', needs: 'operator' },
  { role: 'controller', call: 'CellService/Home', needs: 'operator' },
  { role: 'operator', call: 'ModelService/PromoteModel', needs: 'engineer' },
  { role: 'engineer', call: 'AccessService/ListTokens', needs: 'admin' },
  { role: 'admin', call: 'AccessService/ListTokens' },
];

for (const { role, call, needs } of roles) {
  const browser = await Browser.open(origin, { ignoreHTTPSErrors: true });
  try {
    browser.expected.push(/401|403|Failed to load resource/); // what this test is refused
    const page = await browser.page('/now', { operator: '' });
    await page.getByLabel('Token').fill(readFileSync(`${folder}/${role}.token`, 'utf8').trim());
    await page.getByRole('button', { name: 'Log in' }).click();
    await live(page);
    await page.getByRole('button', { name: new RegExp(`^${role}-page ${role}`) }).waitFor();
    assert.equal(await page.evaluate(() => document.cookie), '', 'no cookie that a script can read');
    const answer = decodeURIComponent(
      await page.evaluate(async (path) => {
        const got = await fetch(`/driftwise.v1.${path}`, {
          method: 'POST', headers: { 'Content-Type': 'application/grpc-web+proto' }, body: new Uint8Array(5),
        });
        return [...got.headers].map((pair) => pair.join(': ')).join('\n') + new TextDecoder().decode(await got.arrayBuffer());
      }, call),
    );
    const act = call.split('/')[1];
    if (needs) assert.match(answer, new RegExp(`${role}-page .* may not ${act}: it needs the role ${needs}, this is ${role}`));
    else assert.match(answer, /grpc-status: ?0/);
    await page.getByRole('button', { name: 'Stop motion' }).click();
    await page.getByText('Axes halted').first().waitFor();
    browser.assertQuiet();
    console.log(`the page over TLS: logged in as ${role}-page, ${act} ${needs ? 'refused' : 'answered'}, stopped`);
  } finally {
    await browser.close();
  }
}
