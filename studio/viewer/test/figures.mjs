/**
 * Measures the studio: times from a slider to a lattice, from its release to planar panels and to a verdict; frames of a
 * large mesh, in the studio and in a report; the weight of the page.
 *
 * Usage: node test/figures.mjs PHEX CHROMIUM [ROUNDS]
 */

import { spawn, spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { loadavg, tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { launch, watched } from "./browser.mjs";
import { obj, paraboloid } from "./meshes.mjs";

const [phex, browserPath, rounds = "7"] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), "phex-figures-"));
const roof = fileURLToPath(new URL("../../../data/roof.obj", import.meta.url));
const [ROWS, COLUMNS] = [140, 143];
const FRAMES = 12;
const VIEW = { width: 968, height: 700 };

const median = (list) => [...list].sort((a, b) => a - b)[list.length >> 1];
const told = (list) => `${Math.round(median(list))} ms (${Math.round(Math.min(...list))} to ${Math.round(Math.max(...list))})`;

/** Milliseconds of each frame while a stage turns. */
function turn([where, frames]) {
  const stage = where === "report" ? window.phexReport.stage : window.phexStudio.studio.view.stage;
  return new Promise((resolve) => {
    const times = [];
    const gl = stage.renderer.getContext();
    const pixel = new Uint8Array(4);
    const step = () => {
      const begun = performance.now();
      stage.camera.position.applyAxisAngle(stage.camera.up, 0.05);
      stage.camera.lookAt(stage.controls.target);
      for (const act of stage.calls.before) act();
      stage.renderer.render(stage.scene, stage.camera);
      for (const act of stage.calls.after) act();
      // Waits until it is drawn.
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
      times.push(performance.now() - begun);
      if (times.length < frames) setTimeout(step, 0);
      else resolve(times.slice(2));
    };
    step();
  });
}

const child = spawn(phex, ["studio", "--no-open", "--quiet", roof], { stdio: ["ignore", "pipe", "inherit"] });
const address = await new Promise((resolve) => child.stdout.on("data", (data) => resolve(/http:\S+/.exec(String(data))[0])));
const browser = await launch(browserPath);
try {
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 } });
  const page = await watched(context);
  let weight = 0;
  page.on("response", async (response) => void (weight += (await response.body().catch(() => "")).length));
  await page.goto(`${address}&lang=en`);
  await page.waitForSelector(".outcome:not([data-stale]) [data-verdict]", { timeout: 120_000 });
  const size = (name) => page.evaluate(async (n) => (await (await fetch(n)).blob()).size, name);
  const [html, script, style] = [await size("./"), await size("studio.js"), await size("studio.css")];
  console.log(`page weight: ${((html + script + style) / 1e6).toFixed(2)} MB (script ${script}, style ${style}, page ${html})`);
  const times = [];
  for (let k = 0; k < Number(rounds); k++) {
    await page.waitForTimeout(1000);
    const box = await page.locator('[data-slider="rotate"]').boundingBox();
    await page.mouse.move(box.x + box.width * (0.5 + 0.03 * k), box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * (0.51 + 0.03 * k), box.y + box.height / 2);
    await page.waitForFunction(() => window.phexStudio.studio.times.lattice > 0);
    await page.waitForTimeout(400);
    await page.mouse.up();
    await page.waitForSelector(".outcome:not([data-stale]) [data-verdict]", { timeout: 120_000 });
    times.push(await page.evaluate(() => window.phexStudio.studio.times));
  }
  const of = (name) => told(times.map((t) => t[name]));
  console.log(`roof, 500 panels, load ${loadavg()[0].toFixed(1)}: slider to lattice ${of("lattice")}, release to planar ${of("planar")}, to verdict ${of("verdict")}`);

  // The same mesh in the same number of pixels.
  writeFileSync(join(folder, "many.obj"), obj(paraboloid(ROWS, COLUMNS, 0.001)));
  spawnSync(phex, ["report", "many.obj", "--html", "many.html", "--quiet"], { cwd: folder });
  const html2 = readFileSync(join(folder, "many.html"), "utf8");
  const report = await watched(await browser.newContext({ viewport: { width: VIEW.width + 312, height: VIEW.height + 66 } }));
  await report.goto(pathToFileURL(join(folder, "many.html")).href);
  await report.waitForFunction(() => document.documentElement.dataset.viewer);
  const packed = /id="phex-data">([^]*?)<\/script>/.exec(html2)[1];
  await page.setViewportSize({ width: VIEW.width + 296 + 316, height: VIEW.height + 48 });
  await page.waitForTimeout(300);
  await page.evaluate((text) => {
    const { view } = window.phexStudio.studio;
    const app = view.showResult(JSON.parse(text));
    view.stage.look([app.mesh.positions], view.stage.direction(), false);
  }, packed);
  const inView = (p, where) => p.evaluate((w) => (w === "report" ? window.phexReport.stage : window.phexStudio.studio.view.stage).size.toArray().join(" x "), where);
  for (let k = 0; k < 2; k++) {
    const [studio, own] = [await page.evaluate(turn, ["studio", FRAMES]), await report.evaluate(turn, ["report", FRAMES])];
    console.log(`frames of ${ROWS * COLUMNS} panels: studio ${told(studio)} at ${await inView(page, "studio")}, report ${told(own)} at ${await inView(report, "report")}`);
  }
} finally {
  await browser.close();
  child.kill("SIGINT");
  rmSync(folder, { recursive: true, force: true });
}
