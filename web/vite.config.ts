import { defineConfig } from 'vite';

// Names without hashes: the page is embedded in the `ylm` binary by name, and the same sources give the same bytes.
const wasm = '[name][extname]';

export default defineConfig({
  base: './',
  build: {
    outDir: '../crates/ylm-cli/page',
    emptyOutDir: true,
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 1000,
    modulePreload: { polyfill: false },
    rolldownOptions: {
      output: { entryFileNames: 'viewer.js', assetFileNames: (asset) => (asset.names[0]?.endsWith('.css') ? 'viewer.css' : wasm) },
    },
  },
  worker: {
    format: 'es',
    rolldownOptions: { output: { entryFileNames: 'worker.js', assetFileNames: wasm } },
  },
});
