/**
 * Drives `phex studio` in a headless browser: everything that docs/book/src/studio.md promises a newcomer, and what goes wrong.
 *
 * Usage: node test/studio.mjs PHEX CHROMIUM [TEST...]
 */

import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { launch, undisturbed, watched } from "./browser.mjs";

const [phex, browserPath, ...only] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), "phex-studio-"));
const roof = fileURLToPath(new URL("../../../data/roof.obj", import.meta.url));
/** How long anything may take on a machine that has other things to do, in milliseconds. */
const PATIENCE = 60_000;
const SMALL = "&job=" + encodeURIComponent(JSON.stringify({ panels: 80 }));

let serving;
let browser;

/** A studio: its address, and a way to end it. */
async function serve(...words) {
  const child = spawn(phex, ["studio", "--no-open", "--quiet", ...words], { stdio: ["ignore", "pipe", "inherit"] });
  const address = await new Promise((resolve, reject) => {
    child.stdout.on("data", (data) => {
      const found = /http:\S+/.exec(String(data));
      if (found) resolve(found[0]);
    });
    child.on("exit", (code) => reject(new Error(`phex studio ended with ${code}`)));
  });
  const ended = new Promise((resolve) => child.on("exit", (code) => resolve(code)));
  return { address: address.split("#")[0], child, ended };
}

/** A page of the studio; what it asks for and what goes wrong in it is judged by `leave`. */
async function visit(state = "", server = serving) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, acceptDownloads: true, locale: "en-GB" });
  const page = await watched(context);
  page.setDefaultTimeout(PATIENCE);
  page.server = server;
  await page.goto(`${server.address}#lang=en&theme=light${state}`);
  await page.waitForSelector(state.includes("surface=") ? ".surface-facts .name" : "[data-sample]");
  return page;
}

async function leave(page) {
  undisturbed(page, (url) => url.startsWith(page.server.address));
  await page.context().close();
}

const text = (page, selector) => page.locator(selector).first().textContent();
const studio = (page, act) => page.evaluate(`(${act})(window.phexStudio.studio)`);
const verdict = (page) => page.waitForSelector(".outcome:not([data-stale]) [data-verdict]").then((mark) => mark.getAttribute("data-verdict"));
const runs = async (page) => (await page.evaluate(async () => (await fetch("status")).json())).runs;

/** Drops a file on the page, as a hand does. */
const drop = (page, name, content) => dropAll(page, [[name, content]]);

/** Drops files at once. */
async function dropAll(page, files) {
  const all = files.map(([name, content]) => [name, [...Buffer.from(content)]]);
  const transfer = await page.evaluateHandle((all) => {
    const data = new DataTransfer();
    for (const [name, bytes] of all) data.items.add(new File([new Uint8Array(bytes)], name));
    return data;
  }, all);
  await page.dispatchEvent("body", "drop", { dataTransfer: transfer });
}

/** Drops the roof and waits for the verdict on a few panels. */
async function small(page) {
  await drop(page, "roof.obj", readFileSync(roof));
  await page.waitForSelector('[data-setting="panels"]');
  await set(page, "panels", "80");
  assert.equal(await verdict(page), "pass");
}

/** Types a value into a setting. */
async function set(page, name, value) {
  const field = page.locator(`[data-setting="${name}"] input[type="text"]`);
  await field.fill(value);
  await field.press("Enter");
  await page.waitForSelector('.outcome:not([data-stale]) [data-verdict], .status[data-kind="problem"]');
}

/** Clicks a point of the model, given as shares of the bounding box; the surface is hit straight from above. */
async function clickSurface(page, u, v) {
  const box = await page.locator(".stage-area > .view canvas").first().boundingBox();
  await page.mouse.click(box.x + u * box.width, box.y + v * box.height);
}

async function saved(page, selector) {
  const refused = page.waitForSelector('.status[data-kind="problem"]').then((status) => status.textContent());
  const [download] = await Promise.all([Promise.race([page.waitForEvent("download"), refused]), page.click(selector)]);
  refused.catch(() => {});
  assert.equal(typeof download, "object", download);
  const path = join(folder, download.suggestedFilename());
  await download.saveAs(path);
  return path;
}

/** Whether nothing lies over the middle of an element. */
const isSeen = (page, selector) =>
  page.evaluate((selector) => {
    const element = document.querySelector(selector);
    const { left, width, top, height } = element.getBoundingClientRect();
    return width > 0 && element.contains(document.elementFromPoint(left + width / 2, top + height / 2));
  }, selector);

const program = (...words) => spawnSync(phex, words, { cwd: folder, encoding: "utf8" });

/** Task 1: from a file to its facts and to a verdict. */
async function aFileIsDropped() {
  const page = await visit();
  await drop(page, "roof.obj", readFileSync(roof));
  await page.waitForSelector(".surface-facts .name");
  const facts = await text(page, ".surface-facts");
  assert.match(facts, /roof\.obj/);
  assert.match(facts, /Faces/);
  assert.equal(await verdict(page), "pass");
  assert.match(await text(page, ".outcome .figures-list"), /Panels\s*\d{3}/);
  assert.equal(await page.locator('.checks-list [data-pass="false"]').count(), 0);
  assert.ok((await page.locator(".checks-list li").count()) > 8);
  await leave(page);
}

/** Task 2: a slider moves, the lattice follows, and on release the planar mesh and the verdict come. */
async function theSliderShowsALattice() {
  const page = await visit();
  await small(page);
  const slider = page.locator('[data-slider="rotate"]');
  const box = await slider.boundingBox();
  const before = await page.locator(".canvas canvas").first().screenshot();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.6, box.y + box.height / 2);
  const begun = Date.now();
  await page.waitForSelector(".preview-mark");
  await page.waitForFunction(() => window.phexStudio.studio.view.previewed > 40);
  const first = Date.now() - begun;
  assert.ok(!(await page.locator(".outcome [data-verdict]").count()), "a preview has no verdict");
  const during = await page.locator(".canvas canvas").first().screenshot();
  assert.notDeepEqual(before, during);
  await page.mouse.up();
  assert.equal(await verdict(page), "pass");
  assert.match(page.url(), /rotate/);
  const { lattice } = await studio(page, "(s) => s.times");
  console.log(`   the lattice is seen after ${first} ms, told after ${Math.round(lattice)} ms`);
  await leave(page);
}

/** Task 3: panels are looked at: picked, coloured, cut open, measured. */
async function panelsArePicked() {
  const page = await visit();
  await small(page);
  await clickSurface(page, 0.5, 0.5);
  await page.waitForSelector('.selection [data-field="id"]');
  assert.match(await text(page, ".selection"), /corners/);
  assert.ok((await page.locator(".sides tbody tr").count()) >= 5);
  await page.click('[data-map="planarity"]');
  assert.match(await text(page, ".legend"), /Planarity/);
  await page.selectOption('[data-section="axis"]', "x");
  const cut = await page.locator(".canvas canvas").first().screenshot();
  await page.selectOption('[data-section="axis"]', "");
  assert.notDeepEqual(cut, await page.locator(".canvas canvas").first().screenshot());
  await page.click('[data-tool="measure"]');
  await clickSurface(page, 0.45, 0.5);
  await clickSurface(page, 0.6, 0.5);
  assert.match(await text(page, ".measured"), /Distance: [\d.]+ m/);
  await leave(page);
}

/** Task 4: a guide is drawn on the surface, points are held; undo takes them back. */
async function aGuideIsDrawn() {
  const page = await visit();
  await small(page);
  await page.click('[data-tool="guide"]');
  await clickSurface(page, 0.42, 0.45);
  await clickSurface(page, 0.5, 0.5);
  await clickSurface(page, 0.58, 0.55);
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => location.hash.includes("lines"));
  assert.match(await text(page, ".placed"), /Guide 1/);
  assert.match(await verdict(page), /pass|outside/);
  const notes = await studio(page, "(s) => s.result.notes");
  assert.ok(notes.some((note) => /guide|line|row/i.test(note)), `something is said of the guide: ${notes}`);
  assert.match(await page.inputValue('[data-part="command"]'), /--config=roof-job\.toml/);
  await page.click('[data-tool="turn"]');
  await page.click('[data-act="undo"]');
  await page.waitForFunction(() => !location.hash.includes("lines"));
  await page.click('[data-act="redo"]');
  await page.waitForFunction(() => location.hash.includes("lines"));
  await page.click(".placed button");
  await page.waitForFunction(() => !location.hash.includes("lines"));
  assert.equal(await verdict(page), "pass");
  await leave(page);
}

/** Task 5: two runs are put side by side, and one is taken up again. */
async function runsAreCompared() {
  const page = await visit();
  await small(page);
  await set(page, "panels", "60");
  await page.waitForFunction(() => document.querySelectorAll(".runs li").length >= 2);
  const boxes = page.locator("[data-compare-run]");
  await boxes.nth(0).check();
  await page.locator("[data-compare-run]").nth(1).check();
  await page.waitForSelector(".others:not([hidden]) .pane canvas");
  assert.equal(await page.locator(".pane").count(), 2);
  await page.click('[data-act="one"]');
  await page.locator(".runs .run").nth(1).click();
  await page.waitForFunction(() => window.phexStudio.studio.state.wanted.job.panels === 80);
  assert.equal(await verdict(page), "pass");
  await leave(page);
}

/** Task 6: every file is taken home and read back; the job file gives the same mesh without the studio. */
async function filesAreTakenHome() {
  const page = await visit();
  await small(page);
  const panels = (await studio(page, "(s) => s.result.figures.panels"));
  for (const format of ["obj", "ply", "off", "stl"]) {
    const path = await saved(page, `[data-file="mesh.${format}"]`);
    const info = program("info", path, "--json");
    assert.ok(info.stdout.length > 100, info.stderr);
    if (format !== "stl") assert.equal(JSON.parse(info.stdout).faces, panels);
  }
  assert.equal(JSON.parse(readFileSync(await saved(page, '[data-file="mesh.json"]'))).dtype, "compas.datastructures/Mesh");
  assert.equal(readFileSync(await saved(page, '[data-file="mesh.glb"]')).subarray(0, 4).toString(), "glTF");
  assert.match(readFileSync(await saved(page, '[data-file="mesh.dxf"]'), "utf8"), /POLYLINE/);
  assert.equal(readFileSync(await saved(page, '[data-file="mesh.3mf"]')).subarray(0, 2).toString(), "PK");
  const report = readFileSync(await saved(page, '[data-file="report.html"]'), "utf8");
  assert.match(report, /phex-viewer/);
  assert.equal(JSON.parse(readFileSync(await saved(page, '[data-file="report.json"]'))).verdict, "pass");
  assert.equal(readFileSync(await saved(page, '[data-file="picture.png"]')).subarray(1, 4).toString(), "PNG");
  assert.match(readFileSync(await saved(page, '[data-file="picture.svg"]'), "utf8"), /<svg/);
  await page.fill('.workshop [name="thickness"]', "20mm");
  await page.fill('.workshop [name="gap"]', "");
  await page.fill('.workshop [name="sheet"]', "12x12m");
  const workshop = readFileSync(await saved(page, '[data-file="workshop.zip"]'));
  assert.ok(workshop.includes("roof-workshop/panels.csv") && workshop.includes("sheets/sheet-01.dxf"));
  // The same bytes from the command line, by the job file and by the words that are there to copy.
  const job = await saved(page, '[data-file="job.toml"]');
  writeFileSync(join(folder, "roof.obj"), readFileSync(roof));
  const own = readFileSync(join(folder, "roof-phex.obj"));
  const again = program("mesh", "roof.obj", "--config", job, "-o", "again.obj", "--quiet");
  assert.equal(again.status, 0, again.stderr);
  assert.deepEqual(readFileSync(join(folder, "again.obj")), own);
  const words = (await page.inputValue('[data-part="command"]')).split(" ").slice(1);
  assert.equal(program(...words, "--quiet").status, 0);
  assert.deepEqual(readFileSync(join(folder, "roof-phex.obj")), own);
  // A job file that is dropped sets what it says.
  await drop(page, "job.toml", "panels = 70\nrotate = 10\nunit = 'mm'\n");
  await page.waitForFunction(() => location.hash.includes("70") && location.hash.includes("rotate"));
  assert.equal(await verdict(page), "pass");
  // What was typed for the workshop stays, and the surface's facts have the unit that is set.
  const typed = () => page.$$eval(".workshop input", (fields) => fields.map((field) => field.value));
  assert.deepEqual(await typed(), ["20mm", "", "12x12m"]);
  await page.click('[data-act="language"]');
  assert.deepEqual(await typed(), ["20mm", "", "12x12m"]);
  assert.match(await text(page, ".surface-facts"), / mm/);
  // Formats in metres have them.
  const metres = readFileSync(await saved(page, '[data-file="mesh.glb"]'));
  assert.equal(program("mesh", "roof.obj", "-n", "70", "--rotate", "10", "--unit", "mm", "-o", "again.glb", "--quiet").status, 0);
  assert.deepEqual(readFileSync(join(folder, "again.glb")), metres);
  await leave(page);
}

/** A file that takes its time is said to be in the making until it is there, whatever a run tells meanwhile. */
async function aFileInTheMakingIsTold() {
  const page = await visit();
  await small(page);
  let release;
  const held = new Promise((resolve) => (release = resolve));
  await page.route(/mesh\.obj/, async (route) => {
    await held;
    await route.continue();
  });
  await page.click('[data-file="mesh.obj"]');
  assert.match(await text(page, ".making"), /Making the file/);
  await set(page, "panels", "70");
  assert.equal(await verdict(page), "pass");
  assert.ok(await page.isVisible(".making"));
  const saved = page.waitForEvent("download");
  release();
  await saved;
  await page.waitForSelector(".making", { state: "hidden" });
  await leave(page);
}

/** A surface and a job file that are dropped together are both taken, and what is not is told. */
async function filesAreDroppedTogether() {
  const page = await visit();
  const files = [["job.toml", "panels = 70\n"], ["roof.obj", readFileSync(roof)], ["more.obj", "v 0 0 0\n"]];
  await dropAll(page, files);
  await page.waitForFunction(() => location.hash.includes("70"));
  assert.equal(await verdict(page), "pass");
  const facts = await text(page, ".surface-facts");
  assert.match(facts, /roof\.obj/);
  assert.match(facts, /Not opened: more\.obj/);
  await leave(page);
}

/** Of two surfaces that are dropped one after the other the second one stays, though it is read first. */
async function theLastDropWins() {
  const page = await visit();
  let release;
  const held = new Promise((resolve) => (release = resolve));
  await page.route(/slow\.obj/, async (route) => {
    await held;
    await route.continue();
  });
  await drop(page, "slow.obj", readFileSync(roof));
  await drop(page, "quick.obj", readFileSync(roof));
  await page.waitForFunction(() => document.querySelector(".surface-facts .name")?.textContent === "quick.obj");
  const answered = page.waitForResponse(/slow\.obj/);
  release();
  await answered;
  await verdict(page);
  await page.waitForTimeout(500);
  assert.equal(await text(page, ".surface-facts .name"), "quick.obj");
  await leave(page);
}

async function aRunIsStopped() {
  const page = await visit();
  await small(page);
  await page.locator('[data-setting="panels"] input[type="text"]').fill("3000");
  await page.keyboard.press("Enter");
  // What is told while the button is pressed takes the press away from it no more.
  await page.hover('[data-act="stop"]');
  await page.mouse.down();
  const told = await text(page, ".status");
  await page.waitForFunction((told) => document.querySelector(".status").textContent !== told, told);
  await page.mouse.up();
  const begun = Date.now();
  assert.match(await text(page, ".status"), /Stopped/);
  while ((await runs(page)) > 0) assert.ok(Date.now() - begun < PATIENCE, "the run goes on");
  console.log(`   the run has ended ${Date.now() - begun} ms after it was stopped`);
  await page.click('[data-act="undo"]');
  assert.equal(await verdict(page), "pass");
  await leave(page);
}

/** What is wrong with a value is told by its field, and stays told while a file of the run before is saved. */
async function wrongValuesAreToldByTheirField() {
  const page = await visit();
  await drop(page, "Dach-Süd.obj", readFileSync(roof));
  await page.waitForSelector('[data-setting="panels"]');
  await set(page, "panels", "80");
  assert.equal(await verdict(page), "pass");
  assert.ok(!(await page.isVisible(".earlier")));
  await page.$$eval("details.group", (groups) => groups.forEach((group) => (group.open = true)));
  const staysTold = async (notice) => {
    assert.match(await text(page, ".status .text"), notice);
    assert.ok(await page.isVisible(".earlier"), "the files are said to be of the run before");
    const [download] = await Promise.all([page.waitForEvent("download"), page.click('[data-file="mesh.obj"]')]);
    assert.equal(download.suggestedFilename(), "Dach-Süd-phex.obj");
    assert.match(await text(page, ".status .text"), notice);
    assert.ok(await page.isVisible(".status"));
  };
  for (const [name, value, told] of [
    ["panels", "1,000", /^Number: `1,000` is not a whole number$/],
    ["panels", "-3", /^Number: a whole number that is not negative is expected, not the number `-3`$/],
    ["edge-length", "3,5", /^Edge length: `3,5` has a comma/],
    ["edge-length", "0", /^Edge length 0: the length must be positive$/],
    ["edge-length", "", null],
    ["seed", "12345678901234567890", /^Seed: `12345678901234567890` is too large/],
    ["seed", "", null],
    ["symmetry", "1", /^Symmetry is `auto`/],
    ["symmetry", "", null],
    ["limits.min-angle", "300", /^Sharpest corner can't be 300/],
    ["limits.min-angle", "", null],
    ["rotate", "abc", /^Rotation: `abc` is not a number$/],
  ]) {
    await set(page, name, value);
    if (told) await staysTold(told);
    else await verdict(page);
    const refused = await page.$$eval('[aria-invalid="true"]', (fields) => fields.map((field) => field.closest("[data-setting]").dataset.setting));
    assert.deepEqual(refused, told ? [name] : []);
  }
  await page.click('[data-act="language"]');
  assert.ok(await page.isVisible(".earlier"));
  await page.click('[data-act="language"]');
  await set(page, "rotate", "");
  assert.equal(await verdict(page), "pass");
  assert.ok(!(await page.isVisible(".earlier")));
  await studio(page, "(s) => { s.begin(); s.stop(); }");
  await staysTold(/Stopped/);
  await leave(page);
}

async function theAddressHoldsTheState() {
  const page = await visit();
  await small(page);
  await set(page, "rotate", "12");
  const panels = await studio(page, "(s) => s.result.figures.panels");
  await page.reload();
  assert.equal(await verdict(page), "pass");
  assert.equal(await studio(page, "(s) => s.result.figures.panels"), panels);
  assert.equal(await page.inputValue('[data-setting="rotate"] input[type="text"]'), "12");
  // Somebody else's address whose surface is not here says so.
  await page.goto("about:blank");
  await page.goto(`${serving.address}#lang=en&surface=0123456789abcdef${SMALL}`);
  await page.waitForSelector('.status[data-kind="problem"]');
  assert.match(await text(page, ".status"), /drop it again/);
  await leave(page);
}

async function twoPagesTakeTurns() {
  const [one, two] = [await visit(), await visit()];
  await small(one);
  await small(two);
  await one.locator('[data-setting="panels"] input[type="text"]').fill("3000");
  await one.keyboard.press("Enter");
  await one.waitForSelector('[data-act="stop"]');
  await set(two, "rotate", "5");
  assert.equal(await verdict(two), "pass");
  await one.waitForSelector('.status[data-kind="stopped"]');
  assert.match(await text(one, ".status"), /another page/);
  await leave(one);
  await leave(two);
}

async function badFilesAreRefused() {
  const page = await visit();
  const refused = async (name, content, wanted) => {
    await drop(page, name, content);
    await page.waitForFunction((name) => document.querySelector('.status[data-kind="problem"]')?.textContent.includes(name), wanted);
    assert.ok(await isSeen(page, ".status"), `what is said of ${name} is seen`);
  };
  await refused("a.obj", "v 0 0 zero\nf 1 2 3\n", "a.obj: line 1");
  await refused("a.xyz", "1 2 3\n", "a.xyz");
  await refused("b.stl", Buffer.alloc(100), "b.stl");
  await refused("c.ply", "ply\nformat ascii 1.0\nelement vertex 3\nend_header\n", "c.ply");
  await refused("d.off", "OFF\n1 1 0\n0 0 nan\n3 0 0 0\n", "d.off");
  await refused("e.obj", "", "e.obj");
  await refused("job.toml", "pannels = 3\n", "pannels");
  await refused("job2.toml", "[guides]\nguide = 'lines.obj'\n", "lines.obj");
  // Three triangles at an edge: it is shown, with the place.
  await drop(page, "fan.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\n");
  await page.waitForSelector(".surface-facts .problem");
  assert.match(await text(page, ".problem"), /more than two faces/);
  assert.equal(await runs(page), 0);
  // A good one afterwards is as good as ever; a limit that is nonsense is told.
  await small(page);
  await set(page, "max-deviation", "minus");
  assert.match(await text(page, ".status"), /minus/);
  await leave(page);
}

async function germanAndDark() {
  const page = await visit();
  await small(page);
  await page.click('[data-act="language"]');
  await page.click('[data-act="theme"]');
  assert.match(await text(page, ".wishes"), /Drehung/);
  assert.equal(await verdict(page), "pass");
  assert.match(await text(page, ".outcome"), /Bestanden/);
  await clickSurface(page, 0.5, 0.5);
  await page.waitForSelector('.selection [data-field="id"]');
  for (const map of await page.locator("[data-map]").all()) await map.click();
  await set(page, "rotate", "3");
  assert.equal(await verdict(page), "pass");
  assert.deepEqual(await page.evaluate(() => window.phexStudio.untranslated()), [], "everything is translated");
  assert.equal(await page.evaluate(() => document.documentElement.lang), "de");
  const paper = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  assert.ok(paper.match(/\d+/g).every((x) => x < 60), paper);
  await leave(page);
}

/** Everything but the view is reached by keys, and has a name for those who do not see it. */
async function theKeyboardIsEnough() {
  const page = await visit();
  await page.keyboard.press("Tab");
  const seen = new Set();
  for (let k = 0; k < 40; k++) {
    const name = await page.evaluate(() => document.activeElement.dataset.sample ?? document.activeElement.textContent);
    seen.add(name);
    assert.ok(await page.evaluate(() => !document.activeElement.closest(".tools, .views, .canvas")), `${name} lies below the welcome`);
    if (name === "roof") break;
    await page.keyboard.press("Tab");
  }
  assert.ok(seen.has("roof"), [...seen].join(", "));
  await page.keyboard.press("Enter");
  assert.equal(await verdict(page), "pass");
  await page.locator('[data-slider="rotate"]').focus();
  await page.keyboard.press("ArrowRight");
  await page.waitForFunction(() => location.hash.includes("rotate"));
  assert.equal(await verdict(page), "pass");
  const nameless = await page.evaluate(() => {
    const controls = [...document.querySelectorAll("button, input, select, textarea")].filter((c) => c.checkVisibility());
    const named = (c) => c.getAttribute("aria-label") || c.labels?.[0]?.textContent.trim() || c.textContent.trim();
    return controls.filter((c) => !named(c)).map((c) => c.outerHTML);
  });
  assert.deepEqual(nameless, []);
  assert.equal(await page.locator('[role="status"]').count(), 1);
  await leave(page);
}

/** A map and layers that were chosen stay through runs and languages, a problem can be closed, and advice names rows. */
async function whatIsChosenStays() {
  const page = await visit();
  await small(page);
  await page.click('[data-map="deviation"]');
  await page.click('[data-layer="ids"]');
  const seen = () =>
    page.evaluate(() => [document.querySelector('[data-map][aria-pressed="true"]').dataset.map, document.querySelector('[data-layer="ids"]').checked]);
  await set(page, "panels", "90");
  await verdict(page);
  assert.deepEqual(await seen(), ["deviation", true]);
  await page.click('[data-act="language"]');
  assert.deepEqual(await seen(), ["deviation", true]);
  await page.click('[data-act="language"]');
  await set(page, "max-deviation", "minus");
  await page.click('.status [data-act="close"]');
  assert.ok(!(await page.isVisible(".status")));
  await set(page, "max-deviation", "0.01%");
  await verdict(page);
  const advice = await text(page, ".advice");
  assert.match(advice, /“Adaptivity”/);
  assert.doesNotMatch(advice, /--/);
  // The number of panels follows from a limit where none is given.
  await page.locator(".group summary", { hasText: "Limits of a workshop" }).click();
  await set(page, "panels", "");
  await set(page, "limits.max-area", "5");
  assert.equal(await page.getAttribute('[data-setting="panels"] input[type="text"]', "placeholder"), "from the limits");
  await leave(page);
}

/** Whatever the window, nothing is wider than it, and nothing that is there to be clicked lies below something else. */
async function windowsOfAnySize() {
  const page = await visit();
  await small(page);
  await page.waitForSelector(".runs [data-compare-run]");
  for (const language of ["en", "de"]) {
    for (const [width, height] of [[360, 740], [390, 844], [844, 390], [768, 1024], [1024, 768], [1100, 700], [1280, 800]]) {
      await page.setViewportSize({ width, height });
      await page.evaluate(() => scrollTo(0, 0));
      // What went wrong may be long, and covers nothing either.
      await studio(page, `(s) => s.say("panel P0001 does not fit on the sheet, ".repeat(20), "problem")`);
      const found = await page.evaluate(() => {
        const covered = (element) => {
          const { left, width, top, height } = element.getBoundingClientRect();
          if (width === 0 || top < 0 || top + height > innerHeight) return false;
          const there = document.elementFromPoint(left + width / 2, top + height / 2);
          return !element.contains(there);
        };
        const buttons = [...document.querySelectorAll(".view button, .tools select")];
        const tick = document.querySelector("[data-compare-run]").getBoundingClientRect();
        const tight = [...document.querySelectorAll(".choices span")].filter((choice) => {
          const range = document.createRange();
          range.selectNodeContents(choice);
          return range.getBoundingClientRect().width + 5 > choice.getBoundingClientRect().width;
        });
        const [undo, redo] = ["undo", "redo"].map((act) => document.querySelector(`[data-act="${act}"]`).getBoundingClientRect().top);
        return {
          wide: document.documentElement.scrollWidth,
          covered: buttons.filter(covered).map((b) => b.textContent),
          tick: tick.right,
          tight: tight.map((choice) => choice.textContent),
          together: undo === redo,
        };
      });
      const told = `${language} ${width} x ${height}: ${JSON.stringify(found)}`;
      assert.ok(found.tight.length === 0 && found.together, told);
      assert.ok(found.wide <= width && found.tick <= width && found.covered.length === 0, told);
    }
    await page.click('[data-act="language"]');
  }
  await leave(page);
}

/** The last one, as it ends the program. */
async function theProgramIsKilled() {
  const own = await serve(roof);
  const page = await visit("", own).catch(() => null) ?? (await visit("", own));
  await small(page);
  await page.locator('[data-setting="panels"] input[type="text"]').fill("3000");
  await page.keyboard.press("Enter");
  await page.waitForSelector('[data-act="stop"]');
  own.child.kill("SIGKILL");
  await page.waitForSelector('.status[data-kind="gone"]');
  assert.match(await text(page, ".status"), /has ended/);
  await leave(page);
  // Ctrl-C ends it cleanly, in the middle of a run.
  const other = await serve(roof);
  const another = await visit("", other);
  await small(another);
  await another.locator('[data-setting="panels"] input[type="text"]').fill("3000");
  await another.keyboard.press("Enter");
  await another.waitForSelector('[data-act="stop"]');
  const begun = Date.now();
  other.child.kill("SIGINT");
  assert.equal(await other.ended, 0);
  console.log(`   the program has ended after ${Date.now() - begun} ms`);
  await another.context().close();
}

/** The program keeps the last surfaces alone: a step back to an older one is told, and what is shown stays wanted. */
async function aSurfaceThatIsGoneIsTold() {
  const page = await visit(SMALL);
  const content = readFileSync(roof, "utf8");
  const shown = (k) => page.waitForFunction((name) => document.querySelector('[data-part="file-name"]').textContent === name, `roof-${k}.obj`);
  for (const k of [0, 1, 2, 3]) {
    await drop(page, `roof-${k}.obj`, `# ${k}\n${content}`);
    await shown(k);
  }
  for (const k of [2, 1]) {
    await page.click('[data-act="undo"]');
    await shown(k);
  }
  await page.click('[data-act="undo"]');
  await page.waitForSelector('.status[data-kind="problem"]');
  await shown(1);
  await page.waitForFunction(() => ((s) => s.state.wanted.surface === s.surface.id)(window.phexStudio.studio));
  await set(page, "panels", "90");
  assert.equal(await verdict(page), "pass");
  await leave(page);
}

/** Views can be chosen of a surface without a result, in another language, too. */
async function viewsStayInAnotherLanguage() {
  const page = await visit();
  await drop(page, "roof.obj", readFileSync(roof));
  await page.waitForSelector(".surface-facts .name");
  await studio(page, "(s) => s.stop()");
  await page.click('[data-act="language"]');
  assert.equal(await studio(page, "(s) => s.result"), null);
  assert.equal(await page.locator('[data-part="views"] button').last().textContent(), "Einpassen");
  await leave(page);
}

const TESTS = [
  aFileIsDropped,
  theSliderShowsALattice,
  panelsArePicked,
  aGuideIsDrawn,
  runsAreCompared,
  filesAreTakenHome,
  aFileInTheMakingIsTold,
  filesAreDroppedTogether,
  theLastDropWins,
  aRunIsStopped,
  wrongValuesAreToldByTheirField,
  theAddressHoldsTheState,
  twoPagesTakeTurns,
  badFilesAreRefused,
  germanAndDark,
  theKeyboardIsEnough,
  whatIsChosenStays,
  aSurfaceThatIsGoneIsTold,
  viewsStayInAnotherLanguage,
  windowsOfAnySize,
  theProgramIsKilled,
];

try {
  serving = await serve();
  browser = await launch(browserPath);
  for (const test of TESTS.filter(({ name }) => only.length === 0 || only.includes(name))) {
    const begun = Date.now();
    await test();
    console.log(`ok ${test.name} (${((Date.now() - begun) / 1000).toFixed(1)} s)`);
  }
} finally {
  await browser?.close();
  serving?.child.kill("SIGINT");
  rmSync(folder, { recursive: true, force: true });
}
