/**
 * Opens the page of a study of 2,000 variants in a headless browser without a network: brushes axes, opens and compares
 * variants.
 *
 * Usage: node test/study.mjs PHEX CHROMIUM [PICTURE.png]
 */

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { cpSync, mkdtempSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const [phex, browserPath, picture] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), "phex-study-"));
const VARIANTS = 2000;
const MOST_BYTES = 12e6;
/** Milliseconds in which a brush has to answer; other work on the machine is allowed for. */
const ANSWER = 300;
const FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"];

function run(...words) {
  const ended = spawnSync(phex, words, { cwd: folder, encoding: "utf8" });
  assert.equal(ended.status, 0, `phex ${words.join(" ")}: ${ended.stderr}`);
  return ended.stdout;
}

/** A few variants that are solved, and copies of them with other figures. */
function study() {
  run("shape", "roof", "--triangles", "1000", "-o", "roof.obj", "-q");
  writeFileSync(join(folder, "study.toml"), `surfaces = ["roof.obj"]
[settings]
effort = "draft"
max-deviation = "5%"
[space]
panels = [40, 60]
rotate = [0, 30]
boundary = ["snap", "whole"]
`);
  run("sweep", "study.toml", "-o", "study", "-q");
  const solved = readdirSync(join(folder, "study"));
  assert.equal(solved.length, 8);
  let random = 1;
  const next = () => (random = (random * 16807) % 2147483647) / 2147483647;
  for (let k = solved.length; k < VARIANTS; k++) {
    const [from, key] = [solved[k % solved.length], k.toString(16).padStart(16, "0")];
    cpSync(join(folder, "study", from), join(folder, "study", key), { recursive: true });
    const file = join(folder, "study", key, "run.json");
    const record = JSON.parse(readFileSync(file, "utf8"));
    const row = record.row;
    row["in:rotate"] = Math.floor(60 * next());
    row["out:panels"] = Math.floor(200 + 400 * next());
    row["out:deviation"] = 60 / row["out:panels"] + 0.3 * next() ** 2;
    row["out:distinct-lengths"] = Math.floor(row["out:panels"] * (1 + next()));
    row["out:clearance"] = 0.1 + 0.4 * next();
    Object.assign(row, { key, img: `${key}/picture.png`, threeD: `${key}/mesh.obj` });
    writeFileSync(file, JSON.stringify(record));
  }
  run("sweep", "collect", "study", "--title", "roof <b>", "-q");
  return join(folder, "study", "index.html");
}

const count = async (page) => Number((await page.locator("#count").textContent()).split(" ")[0]);

/** Drags along an axis from one share of its height to another; gives the slowest answer in milliseconds. */
async function brush(page, name, from, to) {
  const box = await page.locator(`[data-axis="${name}"]`).boundingBox();
  const at = (share) => box.y + 6 + (1 - share) * (box.height - 12);
  await page.mouse.move(box.x + box.width / 2, at(from));
  await page.mouse.down();
  let slowest = 0;
  for (let step = 1; step <= 5; step++) {
    await page.evaluate(() => { window.moved = performance.now(); });
    const answer = page.evaluate(() => new Promise((done) => {
      new MutationObserver((_, self) => {
        self.disconnect();
        // After what was drawn has been laid out.
        requestAnimationFrame(() => setTimeout(() => done(performance.now() - window.moved)));
      }).observe(document.getElementById("count"), { childList: true, characterData: true, subtree: true });
    }));
    await page.mouse.move(box.x + box.width / 2, at(from + ((to - from) * step) / 5));
    slowest = Math.max(slowest, await answer);
  }
  await page.mouse.up();
  return slowest;
}

async function test(page) {
  assert.equal(await count(page), VARIANTS);
  assert.equal(await page.title(), "roof <b>");
  assert.equal(await page.locator("#pictures img").count(), 120, "pictures of the first are shown");
  const slowest = await brush(page, "out:deviation", 0, 0.4);
  console.log(`slowest answer of a brush: ${slowest.toFixed(0)} ms`);
  assert.ok(slowest < ANSWER, `${slowest} ms`);
  const few = await count(page);
  assert.ok(few > 0 && few < VARIANTS);
  // Rows and figures of what is kept agree with the range.
  const kept = await page.evaluate(() => {
    const study = JSON.parse(document.getElementById("study").textContent);
    const cells = study.rows.map((row) => row[study.columns.indexOf("out:deviation")]);
    const [low, high] = [Math.min(...cells), Math.max(...cells)];
    return cells.filter((c) => c <= low + 0.4 * (high - low)).length;
  });
  assert.ok(Math.abs(kept - few) <= 0.02 * VARIANTS, `${few} are shown, ${kept} lie in the range`);
  await brush(page, "in:boundary", 0.6, 1);
  const fewer = await count(page);
  assert.ok(fewer < few && fewer > 0, "two ranges hold together");
  if (picture) await page.screenshot({ path: picture, fullPage: false });
  await page.locator("#clear").click();
  await page.waitForFunction((n) => document.getElementById("count").textContent.startsWith(`${n} `), VARIANTS);
  await page.locator("#pictures button").nth(3).click();
  assert.equal(await page.locator("#one table").count(), 1);
  await page.locator("#one img").first().waitFor();
  assert.ok(await page.locator("#one img").first().evaluate((i) => i.decode().then(() => i.naturalWidth)) >= 400);
  await page.locator("#pictures button").nth(5).click({ modifiers: ["Shift"] });
  assert.equal(await page.locator("#one table").count(), 2);
  assert.ok(await page.locator("#one tr.differs").count() > 2, "what differs is marked");
  const front = Number((await page.locator("#front").textContent()).split(" ")[0]);
  assert.ok(front > 3 && front < 100, `${front} on the front`);
  const box = await page.locator("#scatter").boundingBox();
  const shown = () => page.locator("#one td").first().textContent();
  let clicked = false;
  for (let k = 1; k < 20 && !clicked; k++) {
    await page.mouse.click(box.x + 46 + (box.width - 60) * 0.5, box.y + 12 + ((box.height - 60) * k) / 20);
    clicked = (await page.locator("#one table").count()) === 1 && (await shown()) !== "";
  }
  assert.ok(clicked, "a point opens its variant");
  await page.locator("#more").click();
  assert.equal(await page.locator("#pictures button").count(), 600);
  if (picture) await page.screenshot({ path: picture.replace(".png", "-compare.png"), fullPage: false });
}

try {
  const file = study();
  const bytes = statSync(file).size;
  console.log(`page of ${VARIANTS} variants: ${(bytes / 1e6).toFixed(1)} MB`);
  assert.ok(bytes <= MOST_BYTES, `${bytes} bytes`);
  const browser = await chromium.launch({ executablePath: browserPath, args: FLAGS });
  try {
    const context = await browser.newContext({ viewport: { width: 1400, height: 1000 }, offline: true });
    const page = await context.newPage();
    const [requests, errors] = [[], []];
    page.on("request", (request) => requests.push(request.url()));
    page.on("pageerror", (error) => errors.push(error.message));
    await page.goto(pathToFileURL(file).href);
    await test(page);
    const inside = pathToFileURL(join(folder, "study")).href;
    assert.deepEqual(requests.filter((url) => !url.startsWith("data:") && !url.startsWith(inside)), []);
    assert.deepEqual(errors, []);
  } finally {
    await browser.close();
  }
} finally {
  rmSync(folder, { recursive: true, force: true });
}
