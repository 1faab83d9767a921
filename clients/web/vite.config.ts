import { fileURLToPath } from 'node:url';
import { defineConfig } from 'vitest/config';

// `npm run dev` shows a daemon that runs already: DRIFTWISE_URL=http://127.0.0.1:PORT npm run dev
const daemon = process.env['DRIFTWISE_URL'] ?? 'http://127.0.0.1:8080';

export default defineConfig({
  resolve: { alias: { '@': fileURLToPath(new URL('./src', import.meta.url)) } },
  esbuild: { jsx: 'automatic', jsxImportSource: 'preact' },
  build: {
    target: 'es2022',
    assetsInlineLimit: 0, // the content security policy knows no data: addresses
    cssCodeSplit: false, // one style sheet: a dozen small ones pack worse
    modulePreload: { polyfill: false },
    reportCompressedSize: false,
    rollupOptions: {
      output: {
        experimentalMinChunkSize: 16000, // bytes: many small files pack worse than few; more is loaded first
        chunkFileNames: (chunk) =>
          `assets/${/views\/(\w+)\/view/.exec(chunk.facadeModuleId ?? '')?.[1] ?? '[name]'}-[hash].js`,
      },
    },
  },
  server: { host: '127.0.0.1', proxy: { '^/(driftwise\\.v1\\.|session$)': { target: daemon } } },
  test: { environment: 'jsdom', include: ['test/**/*.test.{ts,tsx}'], css: true, setupFiles: ['test/setup.ts'] },
});
