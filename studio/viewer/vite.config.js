import { readFileSync } from "node:fs";
import { defineConfig } from "vite";

const licence = readFileSync("node_modules/three/LICENSE", "utf8").trim();

// One classic script, since a page opened from a file may not load modules.
export default defineConfig({
  build: {
    lib: { entry: "src/main.ts", formats: ["iife"], name: "phexViewer", fileName: () => "viewer.js" },
    outDir: "../../crates/phex-html/bundle",
    emptyOutDir: false,
    rollupOptions: { output: { banner: `/*! three.js\n${licence}\n*/` } },
  },
});
