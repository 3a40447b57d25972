import { readFileSync } from "node:fs";
import { defineConfig } from "vite";

const licence = `/*! three.js\n\n${readFileSync("node_modules/three/LICENSE", "utf8").trim()}\n*/\n`;

/** Puts the licence of three.js first, after the minifier, which would take it away. */
const withLicence = {
  name: "licence",
  enforce: "post",
  generateBundle(_, bundle) {
    for (const chunk of Object.values(bundle)) if (chunk.type === "chunk") chunk.code = licence + chunk.code;
  },
};

// One classic script, since a page opened from a file may not load modules.
export default defineConfig({
  plugins: [withLicence],
  build: {
    lib: { entry: "src/main.ts", formats: ["iife"], name: "phexViewer", fileName: () => "viewer.js" },
    outDir: "../../crates/phex-html/bundle",
    emptyOutDir: false,
  },
});
