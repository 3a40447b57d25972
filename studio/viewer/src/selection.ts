/** What is known of the picked panel. */

import { NO_FACE, faceCorners, panelName, type Mesh, type Packed, type PackedMap } from "./data";
import { area, figure, h } from "./dom";
import { say } from "./words";

export interface Facts {
  packed: Packed;
  mesh: Mesh;
  area: Float32Array;
  planarity: Float32Array;
  angles: Float32Array;
  concave: Uint32Array;
  maps: { map: PackedMap; values: Float32Array }[];
  /** The face across each side of each face, in the order of its corners; null at the boundary. */
  neighbours: (number | null)[][];
}

/** Most faults that are told of one panel. */
const NOTES = 3;

/** The face across each side of each face, in the order of its corners. */
export function neighbours(mesh: Mesh, faces: number): (number | null)[][] {
  const key = (v: number, w: number) => `${Math.min(v, w)} ${Math.max(v, w)}`;
  const beside = new Map<string, [number, number]>();
  for (let e = 0; e < mesh.edges.length / 2; e++) {
    beside.set(key(mesh.edges[2 * e], mesh.edges[2 * e + 1]), [mesh.edgeFaces[2 * e], mesh.edgeFaces[2 * e + 1]]);
  }
  const across = (face: number, v: number, w: number): number | null => {
    const [a, b] = beside.get(key(v, w)) ?? [face, NO_FACE];
    const other = a === face ? b : a;
    return other === NO_FACE ? null : other;
  };
  return Array.from({ length: faces }, (_, face) => sides(mesh, face).map(([v, w]) => across(face, v, w)));
}

/** The vertices at the two ends of each side. */
function sides(mesh: Mesh, face: number): [number, number][] {
  const corners = Array.from(faceCorners(mesh, face));
  return corners.map((v, k) => [v, corners[(k + 1) % corners.length]]);
}

function length(mesh: Mesh, [v, w]: [number, number]): number {
  const difference = [0, 1, 2].map((axis) => mesh.positions[3 * v + axis] - mesh.positions[3 * w + axis]);
  return Math.hypot(...difference);
}

/** The card of a panel; `go` is called with a neighbour that is clicked. */
export function card(facts: Facts, face: number, go: (face: number) => void): HTMLElement {
  const { packed, mesh } = facts;
  const unit = packed.unit;
  const corners = faceCorners(mesh, face);
  const list = h("dl", {});
  const row = (name: string, field: string, ...value: (Node | string)[]): void => {
    list.append(h("dt", {}, say(name)), h("dd", { "data-field": field }, ...value));
  };
  row("Shape", "shape", say(facts.concave[face] ? "{} corners, concave" : "{} corners, convex", corners.length));
  row("Area", "area", area(facts.area[face], unit));
  row("Planarity", "planarity", `${figure(facts.planarity[face])} ${unit}`);
  for (const { map, values } of facts.maps) {
    if (map.element === "face" && map.name !== "planarity") row(map.title, map.name, shown(map, values[face]));
  }
  row("Face", "face", say("{} (counted from 0)", face));
  const said = packed.offenders.filter((o) => o.faces.includes(face));
  const notes = said.slice(0, NOTES).map((o) => h("p", { class: o.loud ? "loud" : "warn" }, o.text));
  if (said.length > NOTES) notes.push(h("p", { class: "none" }, say("and {} more, see the offenders", said.length - NOTES)));
  return h("div", {}, h("h3", {}, say("Panel {}", "").trimEnd() + " ", h("span", { "data-field": "id" }, panelName(packed, face))), ...notes, list, sideTable(facts, face, go));
}

/** Length, angle at its start and neighbour of each side. */
function sideTable(facts: Facts, face: number, go: (face: number) => void): HTMLElement {
  const { packed, mesh } = facts;
  const rows = sides(mesh, face).map((ends, k) => {
    const other = facts.neighbours[face][k];
    return h(
      "tr",
      {},
      h("td", {}, String(k + 1)),
      h("td", { "data-field": "length" }, figure(length(mesh, ends))),
      h("td", { "data-field": "angle" }, `${facts.angles[mesh.faceStart[face] + k].toFixed(1)}°`),
      h("td", { "data-field": "neighbour" }, other === null ? "–" : link(packed, other, go)),
    );
  });
  const head = [say("Side"), say("Length, {}", packed.unit), say("Angle"), say("Neighbour")].map((text) => h("th", {}, text));
  return h("table", { class: "sides" }, h("thead", {}, h("tr", {}, ...head)), h("tbody", {}, ...rows));
}

/** A value of a map in words. */
export function shown(map: PackedMap, value: number): string {
  if (Number.isNaN(value)) return "–";
  if ("classes" in map.scale) return say(map.scale.classes[value]?.label ?? "–");
  const unit = LIMITS.has(map.name) ? "of the limit used" : UNITS[map.name];
  return figure(value) + (unit === undefined ? "" : ` ${say(unit)}`);
}

/** Maps of how near a panel is to a limit of a workshop, 1 at it. */
const LIMITS = new Set(["max-panel", "min-edge", "max-edge", "min-angle", "max-area", "max-aspect", "min-dihedral", "max-dihedral"]);

/** What follows a value of other maps. */
const UNITS: Record<string, string> = { deviation: "% of diagonal", "panel-area": "mean areas" };

function link(packed: Packed, face: number, go: (face: number) => void): HTMLElement {
  const open = h("button", { type: "button", class: "link" }, panelName(packed, face));
  open.addEventListener("click", () => go(face));
  return open;
}
