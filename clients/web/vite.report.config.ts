// The page of a report: one file without references (docs/web-report.md).
import { createHash } from 'node:crypto';
import { readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { defineConfig, type Plugin } from 'vite';
import { viteSingleFile } from 'vite-plugin-singlefile';

const hashes = (html: string, tag: RegExp) => [...html.matchAll(tag)].map((found) => `'sha256-${createHash('sha256').update(found[1]).digest('base64')}'`).join(' ');

// Nothing but the script and the styles that stand in the page. Last of all: the hashes are of what is written.
const policy: Plugin = {
  name: 'content-security-policy',
  closeBundle() {
    const page = fileURLToPath(new URL('./dist/report.html', import.meta.url));
    const html = readFileSync(page, 'utf8');
    const scripts = hashes(html, /<script type="module"[^>]*>([\s\S]*?)<\/script>/g);
    const styles = hashes(html, /<style[^>]*>([\s\S]*?)<\/style>/g);
    const content = `default-src 'none'; script-src ${scripts}; style-src ${styles}; img-src blob: data:; base-uri 'none'; form-action 'none'`;
    writeFileSync(page, html.replace('<meta charset="utf-8">', `<meta charset="utf-8">\n    <meta http-equiv="Content-Security-Policy" content="${content}">`));
  },
};

export default defineConfig({
  resolve: { alias: { '@': fileURLToPath(new URL('./src', import.meta.url)) } },
  esbuild: { jsx: 'automatic', jsxImportSource: 'preact' },
  build: {
    target: 'es2022', emptyOutDir: false, modulePreload: { polyfill: false }, reportCompressedSize: false,
    rollupOptions: { input: 'report.html' },
  },
  plugins: [viteSingleFile({ removeViteModuleLoader: true }), policy],
});
