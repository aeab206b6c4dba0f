import { defineConfig } from "vite";

export default defineConfig({
  oxc: { jsx: { runtime: "automatic", importSource: "preact" } },
  build: {
    outDir: "../src/cardan/web/static",
    emptyOutDir: true,
    target: "es2022",
    modulePreload: { polyfill: false },
    // No picture or font as text in a style sheet: the page's policy allows its own files alone.
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 900,
  },
});
