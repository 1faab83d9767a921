// The page from another computer: a real browser at a daemon that is reached over TLS, logged in by a token. Executed by
// the test of the second network namespace, inside it: node across.mjs ORIGIN TOKEN_FILE
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { Browser, live } from './lib/browser.mjs';
import { skipUnlessAllIsThere } from './lib/places.mjs';

skipUnlessAllIsThere();

const [origin, tokenFile] = process.argv.slice(2);
const browser = await Browser.open(origin, { ignoreHTTPSErrors: true });
try {
  browser.expected.push(/401|403|Failed to load resource/); // what this test is refused
  const page = await browser.page('/now', { operator: '' });
  await page.getByLabel('Token').fill(readFileSync(tokenFile, 'utf8').trim());
  await page.getByRole('button', { name: 'Log in' }).click();
  await live(page);
  await page.getByRole('button', { name: /^viewer-page viewer/ }).waitFor();
  assert.equal(await page.evaluate(() => document.cookie), '', 'no cookie that a script can read');
  // As the page's own client does it: what a viewer may not do is refused with a sentence.
  const refused = await page.evaluate(async () => {
    const answer = await fetch('/driftwise.v1.CellService/Home', {
      method: 'POST', headers: { 'Content-Type': 'application/grpc-web+proto' }, body: new Uint8Array(5),
    });
    return [...answer.headers].map((pair) => pair.join(': ')).join('\n') + new TextDecoder().decode(await answer.arrayBuffer());
  });
  assert.match(decodeURIComponent(refused), /viewer-page .* may not Home: it needs the role operator, this is viewer/);
  await page.getByRole('button', { name: 'Stop motion' }).click();
  await page.getByText('Axes halted').first().waitFor();
  browser.assertQuiet();
  console.log('the page over TLS: logged in as viewer-page, Home refused, stopped');
} finally {
  await browser.close();
}
