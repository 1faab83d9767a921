// The unit tests of clients/web, as one test of ctest: skips when `npm ci` has not been run there.
import { spawnSync } from 'node:child_process';
import { existsSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const web = join(dirname(fileURLToPath(import.meta.url)), '../../clients/web');
if (!existsSync(join(web, 'node_modules/vitest'))) {
  console.log(`SKIPPED: ${web}/node_modules is not there: cmake --build BUILD --target web, or npm ci --ignore-scripts`);
  process.exit(0);
}
for (const script of ['check', 'test']) {
  const done = spawnSync('npm', ['run', '--silent', script], { cwd: web, stdio: 'inherit' });
  if (done.status !== 0) process.exit(done.status ?? 1);
}
