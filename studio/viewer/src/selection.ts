/** What is known of the picked panel. */

import { NO_FACE, faceCorners, type Mesh, type Packed, type PackedMap } from "./data";
import { figure, h } from "./dom";

export interface Facts {
  packed: Packed;
  mesh: Mesh;
  area: Float32Array;
  planarity: Float32Array;
  angles: Float32Array;
  concave: Uint32Array;
  maps: { map: PackedMap; values: Float32Array }[];
  neighbours: number[][];
}

/** Most faults that are told of one panel. */
const NOTES = 3;

/** The faces across each face's edges, by face. */
export function neighbours(mesh: Mesh, faces: number): number[][] {
  const out: number[][] = Array.from({ length: faces }, () => []);
  for (let e = 0; e < mesh.edges.length / 2; e++) {
    const [a, b] = [mesh.edgeFaces[2 * e], mesh.edgeFaces[2 * e + 1]];
    if (b === NO_FACE) continue;
    out[a].push(b);
    out[b].push(a);
  }
  return out;
}

/** The card of a panel; `go` is called with a neighbour that is clicked. */
export function card(facts: Facts, face: number, go: (face: number) => void): HTMLElement {
  const { packed, mesh } = facts;
  const unit = packed.unit;
  const corners = faceCorners(mesh, face);
  const first = mesh.faceStart[face];
  const angles = Array.from(corners, (_, k) => `${facts.angles[first + k].toFixed(1)}°`);
  const list = h("dl", {});
  const row = (name: string, field: string, ...value: (Node | string)[]): void => {
    list.append(h("dt", {}, name), h("dd", { "data-field": field }, ...value));
  };
  row("Shape", "shape", `${corners.length} corners, ${facts.concave[face] ? "concave" : "convex"}`);
  row("Area", "area", `${figure(facts.area[face])} ${unit}²`);
  row("Planarity", "planarity", `${figure(facts.planarity[face])} ${unit}`);
  row("Angles", "angles", angles.join("  "));
  for (const { map, values } of facts.maps) {
    if (map.element === "face" && map.name !== "planarity") row(map.title, map.name, shown(map, values[face]));
  }
  row("Neighbours", "neighbours", ...links(facts.neighbours[face], go));
  const said = packed.offenders.filter((o) => o.faces.includes(face));
  const notes = said.slice(0, NOTES).map((o) => h("p", { class: o.loud ? "loud" : "warn" }, o.text));
  if (said.length > NOTES) notes.push(h("p", { class: "none" }, `and ${said.length - NOTES} more, see the offenders`));
  return h("div", {}, h("h3", {}, "Panel ", h("span", { "data-field": "id" }, String(face))), ...notes, list);
}

/** A value of a map in words. */
export function shown(map: PackedMap, value: number): string {
  if (Number.isNaN(value)) return "–";
  if ("classes" in map.scale) return map.scale.classes[value]?.label ?? "–";
  const percent = map.name === "deviation" ? " % of diagonal" : "";
  return figure(value) + percent;
}

function links(faces: number[], go: (face: number) => void): HTMLElement[] {
  return faces.map((face) => {
    const link = h("button", { type: "button", class: "link" }, String(face));
    link.addEventListener("click", () => go(face));
    return link;
  });
}
