/**
 * Draws docs/book/src/pictures/report.png: a report with the sign of curvature and a picked panel.
 *
 * Usage: node test/picture.mjs REPORT.HTML CHROMIUM PICTURE.PNG [PANEL]
 */

import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const [report, browserPath, picture, panel = "0"] = process.argv.slice(2);
const args = ["--no-sandbox", "--disable-quic", "--no-first-run", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
const browser = await chromium.launch({ executablePath: browserPath, args });
try {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, offline: true });
  const page = await context.newPage();
  await page.goto(pathToFileURL(report).href);
  await page.waitForFunction(() => document.documentElement.dataset.viewer);
  await page.click('[data-map="curvature"]');
  const at = await page.evaluate((face) => window.phexReport.locate(face), Number(panel));
  await page.mouse.click(at.x, at.y);
  await page.waitForTimeout(500);
  await page.screenshot({ path: picture });
} finally {
  await browser.close();
}
