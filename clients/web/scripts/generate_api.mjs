// proto/*.proto -> src/api/gen/*.ts with protoc and protoc-gen-es. The folder is not in git: the protos are the source.
// Does nothing when what is there is newer than every proto and than this script, so that it can stand before every other step.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { fromBinary, toBinary } from '@bufbuild/protobuf';
import { FileDescriptorProtoSchema } from '@bufbuild/protobuf/wkt';

const web = join(dirname(fileURLToPath(import.meta.url)), '..');
const protos = join(web, '../../proto');
const out = join(web, 'src/api/gen');
const stamp = join(out, '.made');

// The descriptor as the bytes that it is, in place of their base64: gzip finds the names in it, and a quarter of its size goes. Roles of
// methods are the daemon's to judge.
function plainDescriptor(file) {
  const text = readFileSync(file, 'utf8');
  writeFileSync(file, text.replace(/fileDesc\("([^"]+)"/, (_, base64) => {
    const descriptor = fromBinary(FileDescriptorProtoSchema, Buffer.from(base64, 'base64'));
    for (const method of descriptor.service.flatMap((service) => service.method)) method.options = undefined;
    const bytes = Buffer.from(toBinary(FileDescriptorProtoSchema, descriptor)).toString('latin1');
    return `fileDesc(/*@__PURE__*/ btoa(${JSON.stringify(bytes)})`;
  }));
}

const files = readdirSync(join(protos, 'driftwise/v1')).filter((name) => name.endsWith('.proto'));
const sources = [fileURLToPath(import.meta.url), ...files.map((name) => join(protos, 'driftwise/v1', name))];
const newest = Math.max(...sources.map((name) => statSync(name).mtimeMs));
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
  for (const name of readdirSync(join(out, 'driftwise/v1'))) plainDescriptor(join(out, 'driftwise/v1', name));
  writeFileSync(stamp, '');
}
