/**
 * Opens reports in a headless browser without a network: picks panels, switches maps, reads histograms.
 *
 * Usage: node test/report.mjs PHEX CHROMIUM
 */

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { launch, SOFTWARE, undisturbed, watched } from "./browser.mjs";
import { broken, lifted, obj, paraboloid } from "./meshes.mjs";

const [phex, browserPath] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), "phex-report-"));
const MOST_BYTES = 15e6;
/** Exit codes of a report that was written: every check passes, or one fails. */
const WRITTEN = [0, 3];

function report(name, mesh, ...more) {
  writeFileSync(join(folder, `${name}.obj`), obj(mesh));
  const words = ["report", `${name}.obj`, "--html", `${name}.html`, "--quiet", ...more];
  const run = spawnSync(phex, words, { cwd: folder, encoding: "utf8" });
  assert.ok(WRITTEN.includes(run.status), `phex ${words.join(" ")}: ${run.stderr}`);
  return join(folder, `${name}.html`);
}

/** Runs `act` on a page in a browser that has no network; fails on errors in the page and on any request. */
async function visit(file, flags, act) {
  const browser = await launch(browserPath, flags);
  try {
    const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, offline: true });
    const page = await watched(context);
    await page.goto(pathToFileURL(file).href);
    await page.waitForFunction(() => document.documentElement.dataset.viewer);
    await act(page);
    undisturbed(page, (url) => url === pathToFileURL(file).href);
  } finally {
    await browser.close();
  }
}

const text = (page, selector) => page.locator(selector).first().textContent();
const field = (page, name) => text(page, `.selection [data-field="${name}"]`);
const viewer = (page) => page.evaluate(() => document.documentElement.dataset.viewer);

async function clickPanel(page, face) {
  const at = await page.evaluate((f) => window.phexReport.locate(f), face);
  await page.mouse.click(at.x, at.y);
}

async function histogram(page) {
  return page.locator(".legend .bar").evaluateAll((bars) => bars.map((bar) => Number(bar.dataset.count)));
}

const sum = (numbers) => numbers.reduce((a, b) => a + b, 0);

/** Number of different colours in the middle row of the view. */
async function colours(page) {
  return page.evaluate(() => {
    const canvas = document.querySelector(".canvas canvas");
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [canvas.width, canvas.height];
    const pen = copy.getContext("2d");
    pen.drawImage(canvas, 0, 0);
    const row = pen.getImageData(0, canvas.height >> 1, canvas.width, 1).data;
    const seen = new Set();
    for (let i = 0; i < row.length; i += 4) seen.add(`${row[i]},${row[i + 1]},${row[i + 2]}`);
    return seen.size;
  });
}

/** The panels of the workshop files of a mesh, by face. */
function workshopPanels(name) {
  const words = ["fab", `${name}.obj`, "--thickness", "0.1", "--sheet", "100mx100m", "--nest-effort", "0", "-q", "-o", "shop"];
  const run = spawnSync(phex, words, { cwd: folder, encoding: "utf8" });
  assert.equal(run.status, 0, run.stderr);
  const [head, ...rows] = readFileSync(join(folder, "shop", "panels.csv"), "utf8").trim().split("\n");
  const names = head.split(",");
  return rows.map((row) => Object.fromEntries(row.split(",").map((cell, k) => [names[k], cell])));
}

/** The table of sides says what the workshop's table does: lengths, angles and neighbours, side by side. */
async function sidesAgree(page, panel) {
  const column = (name) => page.locator(`.sides [data-field="${name}"]`).allTextContents();
  const [lengths, angles, beside] = [await column("length"), await column("angle"), await column("neighbour")];
  assert.deepEqual(beside, panel.neighbours.split(";"));
  const close = (texts, list, tolerance) =>
    texts.forEach((text, k) => assert.ok(Math.abs(parseFloat(text) - list[k]) < tolerance, `${texts} is ${list}`));
  close(lengths, panel.lengths_mm.split(";").map((mm) => mm / 1000), 1e-3);
  close(angles, panel.angles_deg.split(";").map(Number), 0.06);
  assert.equal(angles.length, 6);
}

async function aGoodMesh() {
  const mesh = paraboloid(16, 14, 0.02);
  writeFileSync(join(folder, "before.obj"), obj(lifted(mesh, 0.2)));
  const file = report("good", mesh, "--before", "before.obj", "--surface", "before.obj");
  const panels = workshopPanels("good");
  assert.match(readFileSync(file, "utf8"), /The MIT License[^]*three\.js authors/, "the licence goes with the code");
  await visit(file, SOFTWARE, async (page) => {
    assert.equal(await viewer(page), "ready");
    await page.waitForTimeout(200);
    assert.ok((await colours(page)) > 8, "the mesh is drawn");
    const face = 8 * 14 + 7;
    await clickPanel(page, face);
    assert.equal(await field(page, "id"), panels[face].id, "as the workshop files name it");
    assert.match(await field(page, "face"), new RegExp(`^${face} `));
    assert.match(await field(page, "shape"), /^6 corners, convex$/);
    await sidesAgree(page, panels[face]);
    assert.match(await field(page, "area"), /^2\.(598|6\d*) m²$/);

    await page.click('[data-map="planarity"]');
    assert.match(await text(page, ".legend h3"), /Planarity/);
    assert.equal(await page.getAttribute('[data-map="planarity"]', "aria-pressed"), "true");
    const counts = await histogram(page);
    assert.equal(sum(counts), mesh.faces.length, "each panel is counted once");
    assert.equal(counts[0], mesh.faces.length, "all are planar");
    await page.click('[data-map="edge-length"]');
    const edges = new Set(mesh.faces.flatMap((f) => f.map((v, k) => [v, f[(k + 1) % 6]].sort().join())));
    assert.equal(sum(await histogram(page)), edges.size, "each edge is counted once");

    for (const layer of ["ids", "surface", "gauss", "offset"]) await page.check(`[data-layer="${layer}"]`);
    await page.locator("[data-offset]").fill("0.1");
    assert.match(await text(page, ".more output"), /^0\.1 m$/);
    await page.click('[data-map="planarity"]');
    await page.click('[data-compare="before"]');
    assert.equal((await histogram(page))[0], 0, "before, no panel is planar");
    for (const mode of ["both", "after"]) await page.click(`[data-compare="${mode}"]`);
    assert.equal((await histogram(page))[0], mesh.faces.length);
    await page.keyboard.press("Escape");
    assert.equal(await page.locator(".selection dl").count(), 0);
    assert.match(await text(page, ".command"), /^phex report good\.obj/);
    await page.setViewportSize({ width: 360, height: 740 });
    const covered = await page.evaluate(() => {
      const isCovered = (element) => {
        const { left, width, top, height } = element.getBoundingClientRect();
        return !element.contains(document.elementFromPoint(left + width / 2, top + height / 2));
      };
      document.querySelector(".view").scrollIntoView();
      return [...document.querySelectorAll(".views button, .compare button")].filter(isCovered).map((b) => b.textContent);
    });
    assert.deepEqual(covered, [], "in a small window, too");
    await page.emulateMedia({ media: "print" });
    const hidden = await page.$$eval("details > :not(summary)", (all) => all.filter((e) => !e.checkVisibility()).map((e) => e.outerHTML.slice(0, 80)));
    assert.deepEqual(hidden, [], "what is folded away is printed");
  });
}

async function aBrokenMesh() {
  const face = 3 * 9 + 4;
  const file = report("broken", broken(paraboloid(8, 9, 0.02), face));
  await visit(file, SOFTWARE, async (page) => {
    assert.equal(await text(page, ".verdict"), "Invalid");
    const first = page.locator(".offenders li button").first();
    assert.equal(await first.getAttribute("class"), "loud", "what crosses itself comes first");
    await first.click();
    assert.match(await field(page, "face"), new RegExp(`^${face} `));
    await page.waitForTimeout(600);
    const at = await page.evaluate((f) => window.phexReport.locate(f), face);
    const box = await page.locator(".canvas").boundingBox();
    assert.ok(Math.hypot(at.x - box.x - box.width / 2, at.y - box.y - box.height / 2) < 3, "it is in the middle");
    await page.click('[data-map="validity"]');
    const bar = page.locator('.legend .bar[data-label="self-intersecting"]');
    assert.equal(await bar.getAttribute("data-count"), "1");
  });
}

async function manyPanels() {
  const mesh = paraboloid(100, 100, 0.002);
  const file = report("many", mesh);
  const { size } = statSync(file);
  assert.ok(size < MOST_BYTES, `${size} bytes`);
  const start = Date.now();
  await visit(file, SOFTWARE, async (page) => {
    const ready = Date.now() - start;
    await clickPanel(page, 5050);
    assert.match(await field(page, "face"), /^5050 /);
    await page.click('[data-map="dihedral"]');
    assert.ok(sum(await histogram(page)) > 29_000);
    const megabytes = (size / 1e6).toFixed(1);
    console.log(`10000 panels: ${megabytes} MB, open after ${ready} ms, answers after ${Date.now() - start} ms`);
  });
}

async function withoutThreeDimensions() {
  const file = report("flat", paraboloid(6, 6, 0.02));
  await visit(file, ["--disable-3d-apis"], async (page) => {
    assert.equal(await viewer(page), "failed");
    assert.ok(await page.locator(".needs-3d").isVisible());
    assert.ok(await page.locator("#pictures[open] img").first().isVisible(), "the pictures stand for the view");
    assert.ok((await page.locator(".checks tbody tr").count()) > 8);
  });
}

try {
  for (const test of [aGoodMesh, aBrokenMesh, manyPanels, withoutThreeDimensions]) {
    await test();
    console.log(`ok ${test.name}`);
  }
} finally {
  rmSync(folder, { recursive: true, force: true });
}
