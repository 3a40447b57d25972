/**
 * Bundles the viewer of the HTML report and the page of the studio: `node build.mjs [--outDir FOLDER]`. Each is one
 * classic script, since a page opened from a file may not load modules.
 */

import { readFileSync } from "node:fs";
import { build } from "vite";

const SCRIPTS = { viewer: "src/main.ts", studio: "src/studio/main.ts" };
const at = process.argv.indexOf("--outDir");
const outDir = at < 0 ? "../../crates/phex-html/bundle" : process.argv[at + 1];
const licence = `/*! three.js\n\n${readFileSync("node_modules/three/LICENSE", "utf8").trim()}\n*/\n`;

/** Puts the licence of three.js first, after the minifier, which would take it away. */
const withLicence = {
  name: "licence",
  enforce: "post",
  generateBundle(_, bundle) {
    for (const chunk of Object.values(bundle)) if (chunk.type === "chunk") chunk.code = licence + chunk.code;
  },
};

for (const [name, entry] of Object.entries(SCRIPTS)) {
  const lib = { entry, formats: ["iife"], name: "phexViewer", fileName: () => `${name}.js` };
  await build({ configFile: false, logLevel: "warn", plugins: [withLicence], build: { lib, outDir, emptyOutDir: false } });
}
