import { defineConfig } from "vite";
import base from "./vite.config";

// The same page as one script, which `cardan check --live` puts into a file with its answers.
export default defineConfig({
  ...base,
  publicDir: false,
  build: {
    ...base.build,
    outDir: "../src/cardan/web/static/live",
    cssCodeSplit: false,
    lib: { entry: "src/main.tsx", formats: ["iife"], name: "cardan", fileName: () => "live.js", cssFileName: "live" },
    rolldownOptions: { output: { codeSplitting: false } },
  },
});
