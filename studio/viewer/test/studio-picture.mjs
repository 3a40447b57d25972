/**
 * Draws docs/book/src/pictures/studio.png: the roof with a guide, its panels and its checks.
 *
 * Usage: node test/studio-picture.mjs PHEX CHROMIUM PICTURE.PNG
 */

import { spawn } from "node:child_process";
import { fileURLToPath } from "node:url";
import { launch, watched } from "./browser.mjs";

const [phex, browserPath, picture] = process.argv.slice(2);
const roof = fileURLToPath(new URL("../../../data/roof.obj", import.meta.url));
const GUIDE = [[0.4, 0.52], [0.5, 0.57], [0.6, 0.61]];

const child = spawn(phex, ["studio", "--no-open", "--quiet", roof], { stdio: ["ignore", "pipe", "inherit"] });
const address = await new Promise((resolve) => child.stdout.on("data", (data) => resolve(/http:\S+/.exec(String(data))[0])));
const browser = await launch(browserPath);
try {
  const context = await browser.newContext({ viewport: { width: 1440, height: 860 } });
  const page = await watched(context);
  await page.goto(`${address}&lang=en&theme=light`);
  const verdict = () => page.waitForSelector(".outcome:not([data-stale]) [data-verdict]", { timeout: 120_000 });
  await verdict();
  await page.click('[data-tool="guide"]');
  const box = await page.locator(".stage-area > .view").boundingBox();
  for (const [u, v] of GUIDE) await page.mouse.click(box.x + u * box.width, box.y + v * box.height);
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => location.hash.includes("lines"));
  await verdict();
  await page.click('[data-tool="turn"]');
  await page.waitForTimeout(500);
  await page.screenshot({ path: picture });
} finally {
  await browser.close();
  child.kill("SIGINT");
}
