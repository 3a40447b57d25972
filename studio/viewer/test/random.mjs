/**
 * Random sequences of clicks, drops, keys and stops: no error in the page, no run that goes on, and memory that comes back.
 *
 * Usage: node test/random.mjs PHEX CHROMIUM [SEQUENCES] [SEED]
 */

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { launch, undisturbed, watched } from "./browser.mjs";

const [phex, browserPath, count = "20", seed = "1"] = process.argv.slice(2);
const roof = readFileSync(fileURLToPath(new URL("../../../data/roof.obj", import.meta.url)));
const BAD = ["v 0 0 zero\n", "", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\n"];
const ACTIONS = 4;
/** Memory that the allocator may keep, MB. */
const ALLOCATOR = 16;

let state = Number(seed) >>> 0;
/** Numbers from 0 to 1 that a seed repeats (xorshift). */
function random() {
  state ^= state << 13;
  state ^= state >>> 17;
  state ^= state << 5;
  return (state >>> 0) / 2 ** 32;
}
const one = (list) => list[Math.floor(random() * list.length)];

async function drop(page, name, content) {
  await page.evaluate(
    ([name, text]) => {
      const data = new DataTransfer();
      data.items.add(new File([text], name));
      document.body.dispatchEvent(new DragEvent("drop", { bubbles: true, dataTransfer: data }));
    },
    [name, String(content)],
  );
}

async function clickView(page) {
  const box = await page.locator(".stage-area > .view").boundingBox();
  await page.mouse.click(box.x + box.width * (0.3 + 0.4 * random()), box.y + box.height * (0.3 + 0.4 * random()));
}

/** Clicks one of what a selector finds, if it can be clicked now. */
async function press(page, selector) {
  await page.evaluate(
    ([selector, share]) => {
      const all = [...document.querySelectorAll(selector)].filter((e) => e.checkVisibility() && !e.disabled);
      all[Math.floor(share * all.length)]?.click();
    },
    [selector, random()],
  );
}

async function type(page, setting, value) {
  await page.evaluate(
    ([setting, value]) => {
      const field = document.querySelector(`[data-setting="${setting}"] input[type="text"]`);
      if (!field?.checkVisibility()) return;
      field.value = value;
      field.dispatchEvent(new Event("change"));
    },
    [setting, value],
  );
}

async function slide(page) {
  await page.evaluate((share) => {
    const slider = document.querySelector('[data-slider="rotate"]');
    if (!slider?.checkVisibility()) return;
    for (const k of [0, 0.1, 0.2]) {
      slider.value = String(-60 + 120 * share + 20 * k);
      slider.dispatchEvent(new Event("input"));
    }
    slider.dispatchEvent(new Event("change"));
  }, random());
}

const DEEDS = [
  (page) => drop(page, "roof.obj", roof),
  (page) => drop(page, "bad.obj", one(BAD)),
  (page) => drop(page, "job.toml", one(["panels = 40\nrotate = 9\n", "panels = 60\n[steering]\nfairness = 2\n", "pannels = 1\n"])),
  (page) => type(page, "panels", one(["40", "60", "90", "2000", "-3", "many"])),
  (page) => type(page, "max-deviation", one(["1%", "", "20mm", "x"])),
  slide,
  slide,
  (page) => press(page, ".toolbar button"),
  (page) => clickView(page),
  (page) => clickView(page),
  (page) => page.keyboard.press(one(["Enter", "Escape", "Control+z", "Control+Shift+z"])),
  (page) => press(page, '[data-act="stop"]'),
  (page) => press(page, '[data-act="undo"], [data-act="redo"], [data-act="language"], [data-act="theme"]'),
  (page) => press(page, ".maps button, .layers input, .views button, .runs .run, [data-compare-run], [data-act='one'], .placed button"),
  (page) => press(page, '.choices input, [data-setting="all-components"] input'),
];

// With one arena the allocator gives back what is freed: what is seen is what the program holds.
const env = { ...process.env, MALLOC_ARENA_MAX: "1" };
const child = spawn(phex, ["studio", "--no-open", "--quiet"], { stdio: ["ignore", "pipe", "pipe"], env });
const wrong = [];
child.stderr.on("data", (data) => wrong.push(String(data)));
const address = await new Promise((resolve) => child.stdout.on("data", (data) => resolve(/http:\S+/.exec(String(data))[0])));
/** Memory of the program, MB. */
const resident = () => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${child.pid}/status`, "utf8"))?.[1] ?? 0) / 1024;

const browser = await launch(browserPath);
try {
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 } });
  const page = await watched(context);
  await page.goto(`${address}#lang=en`);
  await page.waitForSelector("[data-sample]");
  const devtools = await context.newCDPSession(page);
  const heap = async () => {
    await devtools.send("HeapProfiler.collectGarbage");
    return (await devtools.send("Runtime.getHeapUsage")).usedSize / 2 ** 20;
  };
  /** The same state every time: the roof with few panels, and a verdict. */
  const settle = async () => {
    await page.keyboard.press("Escape");
    await page.evaluate(() => {
      const { studio } = window.phexStudio;
      studio.stop();
      studio.state.wanted = { ...studio.state.wanted, job: { panels: 60 } };
      studio.result = null;
    });
    await drop(page, "roof.obj", roof);
    await page.waitForFunction(() => window.phexStudio.studio.result?.verdict === "pass", null, { timeout: 60_000 });
    const quiet = () => page.evaluate(async () => (await (await fetch("status")).json()).runs === 0);
    while (!(await quiet()));
    const shapes = await page.evaluate(() => window.phexStudio.studio.view.stage.renderer.info.memory.geometries);
    return { program: resident(), page: await heap(), shapes };
  };
  const sequence = async () => {
    for (let k = 0; k < ACTIONS; k++) {
      await one(DEEDS)(page);
      if (random() < 0.3) await page.waitForTimeout(200 * random());
    }
  };
  // What is kept at most (surfaces, results, history) is filled before the yardstick is read.
  const warm = Math.max(10, Math.round(Number(count) / 4));
  for (let k = 0; k < warm; k++) await sequence();
  for (let k = 0; k < 4; k++) await settle();
  const before = await settle();
  for (let k = 0; k < Number(count); k++) {
    await sequence();
    if (k % 100 === 99) console.log(`   ${k + 1}: ${resident().toFixed(0)} MB`);
  }
  for (let k = 0; k < 4; k++) await settle();
  const after = await settle();
  const mb = ({ program, page, shapes }) => `program ${program.toFixed(0)} MB, page ${page.toFixed(1)} MB, ${shapes} shapes on the graphics card`;
  console.log(`ok ${count} random sequences: before ${mb(before)}; after ${mb(after)}`);
  undisturbed(page, (url) => url.startsWith(address));
  assert.deepEqual(wrong, [], "the program complains of nothing");
  if (Number(count) >= 500) {
    // The allocator of the program keeps some of what was freed.
    assert.ok(after.program < 1.1 * before.program + ALLOCATOR, "the program's memory comes back");
    assert.ok(after.page < 1.1 * before.page + 1, "the page's memory comes back");
    assert.equal(after.shapes, before.shapes, "and what the graphics card holds");
  }
} finally {
  await browser.close();
  child.kill("SIGINT");
}
