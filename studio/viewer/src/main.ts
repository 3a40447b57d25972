/** Turns the static report into an interactive one, where the browser can draw in three dimensions. */

import { App } from "./app";
import { readPage } from "./data";
import { h } from "./dom";
import { partsOf, sections, view } from "./frame";
import { Stage } from "./stage";

declare global {
  interface Window {
    /** For scripts in the browser's console, and for tests. */
    phexReport?: App;
  }
}

function start(): void {
  const root = document.getElementById("phex-viewer");
  const packed = readPage();
  if (!root || !packed) return;
  // The view must have its size while it is made.
  document.documentElement.dataset.viewer = "ready";
  try {
    root.replaceChildren(view(), h("aside", {}, ...sections()));
    const parts = partsOf(root);
    window.phexReport = new App(packed, parts, new Stage(parts("canvas")));
  } catch (error) {
    // No WebGL, say: the page's pictures and tables stand for the view.
    console.warn("no interactive view:", error);
    root.replaceChildren();
    document.getElementById("pictures")?.setAttribute("open", "");
    document.documentElement.dataset.viewer = "failed";
  }
}

start();
