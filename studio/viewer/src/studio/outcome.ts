/** What came of a run: verdict, figures, checks, files. */

import { numbers } from "../data";
import { area, button, figure, h } from "../dom";
import { say } from "../words";
import type { Check, Result } from "./server";
import { inRows } from "./settings";

const VERDICTS: Record<Result["verdict"], [string, string]> = {
  pass: ["pass", "Pass"],
  outside_tolerance: ["outside", "Outside tolerance"],
  invalid: ["invalid", "Invalid"],
};

/** What the checks are about. */
const CHECKS: Record<string, string> = {
  planarity: "Panels are planar",
  clearance: "Corners keep clear of edges",
  edge_length: "No edge has collapsed",
  finite: "All corners are somewhere",
  faces_not_simple: "No panel crosses itself",
  folded_corners: "No corner is folded",
  flipped_faces: "No panel is turned over",
  wrong_fans: "Panels lie round every corner",
  wrong_degree: "Three panels meet at a corner",
  crossings: "Panels do not cross one another",
  folds: "No sharp folds",
  same_topology: "Holes and handles are the surface’s",
  deviation: "Close to the surface",
  covered_area: "The surface is covered",
  coverage_inner: "No gap inside of the surface",
  boundary: "The boundary is kept",
  max_panel: "Panels fit on the sheet",
  min_edge: "Edges are long enough",
  max_edge: "Edges are short enough",
  min_angle: "Corners are blunt enough",
  max_area: "Panels are small enough",
  max_aspect: "Panels are wide enough",
  min_dihedral: "Joints are flat enough",
  max_dihedral: "Joints are sharp enough",
};

export const verdictMark = (verdict: Result["verdict"]): HTMLElement => {
  const [kind, word] = VERDICTS[verdict];
  return h("span", { class: `verdict ${kind}`, "data-verdict": verdict }, say(word));
};

/** The figures that are looked for first. */
export function figures(result: Result): [string, string][] {
  const { figures: f, unit } = result;
  const rows: [string, string][] = [
    ["Panels", String(f.panels)],
    ["Mean edge", `${figure(f.mean_edge)} ${unit}`],
    ["Planarity", `${figure(f.planarity)} ${unit}`],
  ];
  if (f.deviation !== null) rows.push(["Deviation", `${figure(f.deviation)} ${unit}`]);
  if (f.hexagons !== null) rows.push(["Hexagons inside", `${(100 * f.hexagons).toFixed(1)} %`]);
  rows.push(["Concave", String(f.concave)], ["Area", area(f.area, unit)], ["Time", `${result.seconds.toFixed(1)} s`]);
  return rows;
}

export const figureList = (rows: [string, string][]): HTMLElement =>
  h("dl", { class: "figures-list" }, ...rows.flatMap(([name, value]) => [h("dt", {}, say(name)), h("dd", {}, value)]));

/** The list of checks: those that fail, which lead to their panels, and those that hold where they are wanted. */
export function checkList(result: Result, visit: (face: number) => void): HTMLElement {
  const list = (pass: boolean): HTMLElement[] => result.checks.filter((c) => c.pass === pass).map((c) => entry(c, result.unit, visit));
  const [fail, hold] = [list(false), list(true)];
  const said = fail.length === 0 ? say("All {} hold", hold.length) : say("{} hold", hold.length);
  return h("div", { class: "checks-list" }, h("ul", {}, ...fail), h("details", {}, h("summary", {}, said), h("ul", {}, ...hold)));
}

function entry(check: Check, unit: string, visit: (face: number) => void): HTMLElement {
  const mark = h("span", { class: check.pass ? "tick" : check.decisive ? "cross loud" : "cross", "aria-hidden": "true" }, check.pass ? "✓" : "✕");
  const word = h("span", { class: "unseen" }, say(check.pass ? "holds:" : "fails:"));
  const line = h("li", { "data-check": check.name, "data-pass": String(check.pass) }, mark, word, h("span", {}, say(CHECKS[check.name] ?? check.name)), h("small", {}, reading(check, unit)));
  const faces = numbers(check.faces);
  if (!check.pass && faces.length > 0) {
    let next = 0;
    const go = button(faces.length === 1 ? say("one panel, show") : say("{} panels, show", faces.length), say("Go from one to the next"), () => visit(faces[next++ % faces.length]));
    go.className = "link";
    line.append(go);
  }
  if (!check.pass && check.advice) line.append(h("p", { class: "advice" }, inRows(check.advice)));
  return line;
}

/** A check's figure beside its limit. */
function reading(check: Check, unit: string): string {
  if (check.reading) {
    const { value, limit, unit: typed, across } = check.reading;
    // A sheet has two sides.
    const [most, least] = across ? across.map((side) => ` × ${figure(side)}`) : ["", ""];
    return `${figure(value)}${least} / ${figure(limit)}${most} ${typed}`;
  }
  if (check.value_length !== null && check.limit_length !== null) return `${figure(check.value_length)} / ${figure(check.limit_length)} ${unit}`;
  return `${figure(check.value)} / ${figure(check.limit)}`;
}
