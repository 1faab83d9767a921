// proto/*.proto -> src/api/gen/*.ts with protoc and protoc-gen-es. The folder is not in git: the protos are the source.
// Does nothing when what is there is newer than every proto, so that it can stand before every other step.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readdirSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const web = join(dirname(fileURLToPath(import.meta.url)), '..');
const protos = join(web, '../../proto');
const out = join(web, 'src/api/gen');
const stamp = join(out, '.made');

const files = readdirSync(join(protos, 'driftwise/v1')).filter((name) => name.endsWith('.proto'));
const newest = Math.max(...files.map((name) => statSync(join(protos, 'driftwise/v1', name)).mtimeMs));
if (!existsSync(stamp) || statSync(stamp).mtimeMs < newest) {
  rmSync(out, { recursive: true, force: true });
  mkdirSync(out, { recursive: true });
  try {
    execFileSync('protoc', [
      `--plugin=protoc-gen-es=${join(web, 'node_modules/.bin/protoc-gen-es')}`,
      `-I${protos}`, `--es_out=${out}`, '--es_opt=target=ts',
      ...files.map((name) => `driftwise/v1/${name}`),
    ], { stdio: 'inherit' });
  } catch (error) {
    console.error(error.code === 'ENOENT'
      ? 'protoc is not there: install protobuf-compiler (deploy/packages.txt lists it)'
      : 'protoc could not read the protos: its words are above');
    process.exit(1);
  }
  writeFileSync(stamp, '');
}
