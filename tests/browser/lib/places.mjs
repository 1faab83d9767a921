// Where things are, and whether they are: without Node modules, page, programs or browser the tests skip aloud.
import { existsSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

export const sourceFolder = join(dirname(fileURLToPath(import.meta.url)), '../../..');
export const webFolder = process.env.DRIFTWISE_WEB_DIR ?? join(sourceFolder, 'clients/web');
export const binFolder = process.env.DRIFTWISE_BIN_DIR ?? join(sourceFolder, 'build/dev/bin');
export const chromiumPath = process.env.DRIFTWISE_CHROMIUM ?? '/usr/bin/chromium';
export const ofWeb = createRequire(join(webFolder, 'package.json'));

export function whyNot() {
  if (!existsSync(join(webFolder, 'node_modules/playwright-core'))) return `${webFolder}/node_modules: cmake --build BUILD --target web`;
  if (!existsSync(join(webFolder, 'dist/index.html'))) return `${webFolder}/dist: cmake --build BUILD --target web`;
  for (const program of ['driftwised', 'driftwise', 'driftwise-cellsim']) {
    if (!existsSync(join(binFolder, program))) return `${binFolder}/${program}: build it, or set DRIFTWISE_BIN_DIR`;
  }
  if (!existsSync(chromiumPath)) return `${chromiumPath}: apt-get install chromium, or set DRIFTWISE_CHROMIUM`;
  return undefined;
}

export function skipUnlessAllIsThere() {
  const missing = whyNot();
  if (missing === undefined) return;
  console.log(`SKIPPED: not there: ${missing}`);
  process.exit(0);
}
