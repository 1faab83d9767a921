// What is fetched first, and in all: gzip -9 of dist. No address beyond the daemon stands in any file.
import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { gzipSync } from 'node:zlib';
import { skipUnlessAllIsThere, webFolder } from './lib/places.mjs';

skipUnlessAllIsThere();

const dist = join(webFolder, 'dist');
const files = readdirSync(dist, { recursive: true, withFileTypes: true }).filter((entry) => entry.isFile())
  .map((entry) => join(entry.parentPath ?? entry.path, entry.name));
const packed = (names) => names.reduce((sum, name) => sum + gzipSync(readFileSync(name), { level: 9 }).length, 0) / 1000;

// The page, what it names, what those import without being asked, and Now.
function firstLoad() {
  const wanted = new Set([join(dist, 'index.html')]);
  const queue = [...wanted];
  const html = readFileSync(join(dist, 'index.html'), 'utf8');
  for (const [, name] of html.matchAll(/(?:src|href)="\/([^"]+)"/g)) queue.push(join(dist, name));
  queue.push(files.find((name) => /assets\/now-[\w-]+\.js$/.test(name)), ...files.filter((name) => /assets\/(?:now|view|plot)-[\w-]+\.css$/.test(name)));
  for (let name; (name = queue.pop()); ) {
    wanted.add(name);
    if (!name.endsWith('.js')) continue;
    for (const [, other] of readFileSync(name, 'utf8').matchAll(/(?:from|import)\s*"\.\/([\w.-]+\.js)"/g)) {
      const file = join(dist, 'assets', other);
      if (!wanted.has(file)) queue.push(file);
    }
  }
  return [...wanted];
}

test('the first load is at most 120 kB gzip, all of it below 300 kB', () => {
  const first = packed(firstLoad());
  const all = packed(files);
  console.log(`first load ${first.toFixed(1)} kB of 120, all ${all.toFixed(1)} kB of 300 (gzip -9)`);
  assert.ok(first <= 120, `first load ${first.toFixed(1)} kB`);
  assert.ok(all < 300, `all ${all.toFixed(1)} kB`);
});
