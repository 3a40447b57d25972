/** The browser that tests use, and a page in it that tells of every error and every request. */

import assert from "node:assert/strict";
import { chromium } from "playwright-core";

const QUIET = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"];
const QUIETER = ["--disable-component-update", "--disable-sync"];
export const SOFTWARE = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"];

export const launch = (path, flags = SOFTWARE) => chromium.launch({ executablePath: path, args: [...QUIET, ...QUIETER, ...flags] });

/** A page that notes what it asks for and what goes wrong in it. */
export async function watched(context) {
  const page = await context.newPage();
  page.requests = [];
  page.errors = [];
  page.on("request", (request) => page.requests.push(request.url()));
  page.on("pageerror", (error) => page.errors.push(error.message));
  return page;
}

/** Fails if something went wrong in a page, or if it asked for anything but what `own` names. */
export function undisturbed(page, own) {
  const outside = page.requests.filter((url) => !url.startsWith("data:") && !url.startsWith("blob:") && !own(url));
  assert.deepEqual(outside, [], "the page asks for nothing else");
  assert.deepEqual(page.errors, []);
}
