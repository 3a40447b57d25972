/** The interactive view: panels, maps, layers, selection and offenders. */

import { Box3, BufferAttribute, Group, type Material, Mesh as Surface, type Object3D, Sphere, Vector3 } from "three";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { colour } from "./colours";
import { faceCorners, faceCount, floats, mesh, numbers, panelName, type Packed, type PackedArray, type PackedMap } from "./data";
import { button, figure, h } from "./dom";
import type { Parts } from "./frame";
import { curvesLayer, GaussImage, Offset, Start, surfaceLayer } from "./layers";
import { counted, legend } from "./legend";
import { Picker } from "./picker";
import { faceCentre, faceNormal, faceRadius, lines, Polygons } from "./polygons";
import { card, neighbours, shown, type Facts } from "./selection";
import { type Stage, VIEWS } from "./stage";
import { Tags } from "./tags";
import { say } from "./words";

const SELECTED = 0x0050ff;
const LOUD = 0xd4006a;
/** A press that moves farther than this is a turn of the view, in pixels. */
const CLICK = 5;
/** As many offenders as a report lists. */
const MOST_OFFENDERS = 500;
/** How far lines on the surface are drawn before it, in mean edges. */
const LIFT = 0.3;
/** How far round a panel is seen that is zoomed to, in its radii. */
const CLOSE_UP = 5;

/** Names of the Gauss images: by what touches the unit sphere. */
const GAUSS_IMAGES = ["Gauss image: faces touch", "Gauss image: edges touch", "Gauss image: vertices on"];

/** What is chosen of what can be shown: a map, layers that were switched, and where the offset is. */
export interface Choice {
  map: string;
  layers: Map<string, boolean>;
  offset: string | null;
}

export class App {
  private readonly world = new Group();
  private readonly life = new AbortController();
  private readonly facts: Facts;
  private readonly polygons: Polygons;
  private readonly picker: Picker;
  private readonly tags: Tags;
  private readonly centres: Vector3[];
  private readonly radii: number[];
  private readonly model: Sphere;
  private readonly selection: LineSegments2;
  private readonly loud: LineSegments2;
  private readonly start: Start | null;
  private offset: Offset | null = null;
  private readonly gauss: GaussImage[] = [];
  private current: Facts["maps"][number];
  private shownMesh = "after";
  private readonly onSurface: Object3D[] = [];
  /** Layers that were switched, and the place of the offset. */
  private readonly switched = new Map<string, boolean>();
  private offsetAt: string | null = null;
  private restoring = false;
  /** The map that is wanted, which a result may not have. */
  private wished = "";

  /** Shows data in the parts of a page; the eye stays where it is if it is to. */
  constructor(
    private readonly packed: Packed,
    private readonly part: Parts,
    private readonly stage: Stage,
    keepsEye = false,
  ) {
    this.facts = unpack(packed);
    const { mesh: base } = this.facts;
    const faces = Array.from({ length: faceCount(base) }, (_, face) => face);
    this.centres = faces.map((face) => faceCentre(base, face));
    this.radii = faces.map((face) => faceRadius(base, face));
    for (const name of ["views", "compare", "maps", "layers", "offenders"]) this.part(name).replaceChildren();
    this.tip(null, 0, 0);
    this.polygons = new Polygons(base);
    this.picker = new Picker(this.stage.renderer, this.stage.camera, this.polygons.faces.geometry);
    const normals = faces.map((face) => faceNormal(base, base.positions, face));
    this.tags = new Tags(this.stage.camera, this.centres, this.radii, normals, (face) => panelName(packed, face));
    this.part("canvas").append(this.tags.canvas);
    const box = new Box3().setFromBufferAttribute(new BufferAttribute(base.positions, 3));
    this.model = box.getBoundingSphere(new Sphere());
    this.selection = overlay(3.6, SELECTED);
    this.loud = overlay(3, LOUD);
    this.outline(this.loud, [...new Set(packed.offenders.filter((o) => o.loud).flatMap((o) => o.faces))]);
    this.start = packed.start ? new Start(packed.start) : null;
    this.world.add(this.polygons.group, this.loud, this.selection);
    this.stage.scene.add(this.world);
    this.stage.setExtent(box);
    this.current = this.facts.maps[0];
    this.buildMaps();
    this.buildLayers();
    this.buildTools();
    this.buildOffenders();
    this.select(null);
    this.listen();
    this.show(this.current.map.name);
    if (!keepsEye) this.stage.look(this.points(), new Vector3(...VIEWS.Iso), false);
  }

  /** Takes everything out of the view and the page. */
  dispose(): void {
    this.life.abort();
    this.stage.scene.remove(this.world);
    this.world.traverse((object) => {
      if (!(object instanceof Surface)) return;
      object.geometry.dispose();
      (object.material as Material).dispose();
    });
    this.picker.dispose();
    this.tags.canvas.remove();
    for (const name of ["views", "compare", "maps", "layers", "selection", "offenders", "legend"]) this.part(name).replaceChildren();
  }

  /** The mesh, and what is at a point of the page: a panel, or nothing. */
  get mesh(): Facts["mesh"] {
    return this.facts.mesh;
  }

  /** Goes to a panel. */
  visit(face: number): void {
    this.zoom(face);
  }

  /** The map, and the layers that were switched, by which another result can be shown. */
  get choice(): Choice {
    return { map: this.wished, layers: new Map(this.switched), offset: this.offsetAt };
  }

  /** Shows what was chosen for another result, as far as this one has it; the eye stays where it is. */
  restore(choice: Choice): void {
    this.restoring = true;
    this.show(choice.map);
    // What this result does not have may come back with the next.
    for (const [name, on] of choice.layers) this.switched.set(name, on);
    const slider = this.part("layers").querySelector<HTMLInputElement>("[data-offset]");
    if (slider && choice.offset !== null) {
      slider.value = choice.offset;
      slider.dispatchEvent(new Event("input"));
    }
    for (const [name, on] of choice.layers) {
      const box = this.part("layers").querySelector<HTMLInputElement>(`[data-layer="${name}"]`);
      if (box && !box.disabled && box.checked !== on) box.click();
    }
    this.restoring = false;
  }

  /** Place of a panel's centre in the page, for scripts and tests. */
  locate(face: number): { x: number; y: number } {
    const p = this.centres[face].clone().project(this.stage.camera);
    const box = this.stage.renderer.domElement.getBoundingClientRect();
    return { x: box.x + ((p.x + 1) / 2) * box.width, y: box.y + ((1 - p.y) / 2) * box.height };
  }

  private buildMaps(): void {
    const box = this.part("maps");
    for (const { map } of this.facts.maps) {
      const choose = button(say(map.title), say(map.caption), () => this.show(map.name));
      choose.dataset.map = map.name;
      box.append(choose);
    }
  }

  /** Colours the panels by a map. */
  private show(name: string): void {
    this.wished = name;
    this.current = this.facts.maps.find(({ map }) => map.name === name) ?? this.current;
    const { map, values } = this.current;
    const plain = map.element === "edge";
    const paint = (face: number) => (plain ? ([238, 236, 232] as [number, number, number]) : colour(map.scale, values[face]));
    this.polygons.colourFaces(paint);
    this.polygons.colourEdges(plain ? (edge) => colour(map.scale, values[edge]) : null);
    for (const image of this.gauss) image.polygons.colourFaces(paint);
    this.start?.colour(map.name === "planarity" ? (v) => colour(map.scale, v) : null);
    this.explain();
    for (const choose of this.part("maps").querySelectorAll<HTMLElement>("[data-map]")) {
      choose.setAttribute("aria-pressed", String(choose.dataset.map === map.name));
    }
    this.stage.draw();
  }

  /** Shows the legend of the map, with the histogram of the mesh that is seen. */
  private explain(): void {
    const { map } = this.current;
    const start = this.shownMesh === "before" ? this.start : null;
    const own = start !== null && map.name === "planarity";
    const plain = start !== null && !own;
    const note = plain ? say("The layout before is drawn plain; the figures are the result’s.") : null;
    this.part("legend").replaceChildren(legend(own ? counted(map, start.planarity) : map, note));
  }

  private buildLayers(): void {
    const { packed } = this;
    const { faces, edges } = this.polygons;
    this.layer("panels", "Panels", true, (on) => void (faces.visible = on));
    this.layer("edges", "Edges", true, (on) => void (edges.visible = on));
    this.layer("ids", "Panel ids", false, (on) => void (this.tags.visible = on));
    this.lazy("surface", "Surface", packed.surface, surfaceLayer);
    const sound = packed.missing.offset ? null : packed.gauss;
    this.lazy("offset", "Offset", sound, (gauss) => this.makeOffset(gauss));
    const none = { "gauss-edges": null, "gauss-vertices": null };
    const images: Record<string, PackedArray | null> = { gauss: packed.gauss?.directions ?? null, ...none, ...packed.spheres };
    Object.entries(images).forEach(([name, image], k) => {
      this.lazy(name, GAUSS_IMAGES[k], image, (directions) => this.makeGauss(directions, k), () => this.fit(true));
    });
    const families = packed.curves.length > 0 ? packed.curves : null;
    this.lazy("curves", families?.map((c) => c.name).join(", ") ?? "Conjugate curves", families, (packed) => this.lifted(curvesLayer(packed)));
  }

  /** A layer that is made when it is first switched on. */
  private lazy<T>(name: string, label: string, data: T | null, make: (data: T) => Object3D, after?: () => void): void {
    let object: Object3D | null = null;
    const reason = this.packed.missing[name] ?? (data === null ? say("not in this report") : null);
    const act = (on: boolean): void => {
      if (data !== null && object === null) {
        object = make(data);
        this.world.add(object);
        this.resize();
      }
      if (object) object.visible = on;
      this.part("layers").querySelector(`[data-more="${name}"]`)?.toggleAttribute("hidden", !on);
      if (!this.restoring) after?.();
    };
    this.layer(name, label, false, act, data === null, reason);
    if (name === "offset" && data !== null && this.packed.gauss) this.part("layers").append(this.offsetSlider(this.packed.gauss));
  }

  private layer(
    name: string,
    label: string,
    on: boolean,
    act: (on: boolean) => void,
    missing = false,
    reason: string | null = null,
  ): void {
    const box = h("input", { type: "checkbox", "data-layer": name }) as HTMLInputElement;
    box.checked = on;
    box.disabled = missing;
    box.addEventListener("change", () => {
      this.switched.set(name, box.checked);
      act(box.checked);
      this.stage.draw();
    });
    const line = h("label", missing ? { class: "off" } : {}, box, h("span", {}, say(label)));
    if (reason) line.append(h("small", {}, reason));
    this.part("layers").append(line);
  }

  private lifted<T extends Object3D>(object: T): T {
    this.onSurface.push(object);
    return object;
  }

  private makeOffset(gauss: NonNullable<Packed["gauss"]>): Object3D {
    this.offset = new Offset(this.facts.mesh, gauss);
    this.part("layers").querySelector<HTMLInputElement>("[data-offset]")?.dispatchEvent(new Event("input"));
    return this.offset.polygons.group;
  }

  private makeGauss(directions: PackedArray, side: number): Object3D {
    const image = new GaussImage(this.facts.mesh, directions, this.model, side);
    this.gauss.push(image);
    this.show(this.wished);
    return image.group;
  }

  private offsetSlider(gauss: NonNullable<Packed["gauss"]>): HTMLElement {
    const attributes = {
      type: "range",
      min: String(-gauss.inward),
      max: String(gauss.outward),
      step: "any",
      value: String(0.5 * gauss.outward),
      "data-offset": "",
      "aria-label": say("Distance of the offset"),
    };
    const slider = h("input", attributes) as HTMLInputElement;
    const said = h("output", {});
    slider.addEventListener("input", () => {
      const distance = Number(slider.value);
      this.offsetAt = slider.value;
      said.textContent = `${figure(distance)} ${this.packed.unit}`;
      this.offset?.setDistance(distance);
      this.stage.draw();
    });
    return h("div", { class: "more", "data-more": "offset", hidden: "" }, slider, said);
  }

  private buildTools(): void {
    const views = this.part("views");
    for (const [name, direction] of Object.entries(VIEWS)) {
      views.append(button(say(name), say(`${name} view`), () => this.stage.look(this.points(), new Vector3(...direction), true)));
    }
    views.append(button(say("Fit"), say("Fit everything into the view"), () => this.fit(true)));
    if (!this.start) return;
    const modes: [string, string][] = [
      ["before", "Before"],
      ["after", "After"],
      ["both", "Both"],
    ];
    for (const [mode, label] of modes) {
      const choose = button(say(label), say(COMPARE[mode]), () => this.compare(mode));
      choose.dataset.compare = mode;
      this.part("compare").append(choose);
    }
    this.world.add(this.start.polygons.group, this.lifted(this.start.wires));
    this.compare("after");
  }

  /** Shows the layout's start, the result, or the result with the start as lines. */
  private compare(mode: string): void {
    const { start } = this;
    if (!start) return;
    this.shownMesh = mode;
    this.explain();
    start.polygons.group.visible = mode === "before";
    start.wires.visible = mode === "both";
    this.polygons.group.visible = mode !== "before";
    this.loud.visible = mode !== "before";
    this.selection.visible = mode !== "before";
    for (const choose of this.part("compare").querySelectorAll<HTMLElement>("[data-compare]")) {
      choose.setAttribute("aria-pressed", String(choose.dataset.compare === mode));
    }
    this.stage.draw();
  }

  private buildOffenders(): void {
    const { offenders } = this.packed;
    const box = this.part("offenders");
    if (offenders.length === 0) {
      box.append(h("p", { class: "none" }, say("None: every check holds.")));
      return;
    }
    const entries = offenders.map((offender) => {
      const open = button("", say("Show the panel"), () => this.zoom(offender.faces[0]));
      open.className = offender.loud ? "loud" : "warn";
      open.append(h("b", {}, say("Panel {}", panelName(this.packed, offender.faces[0]))), h("span", {}, offender.text));
      return h("li", {}, open);
    });
    box.append(h("ol", {}, ...entries));
    if (offenders.length >= MOST_OFFENDERS) box.append(h("p", { class: "none" }, say("The first ones; the JSON report lists all.")));
  }

  private select(face: number | null): void {
    const box = this.part("selection");
    box.replaceChildren(
      face === null
        ? h("p", { class: "none" }, say("Click a panel to see its size, angles and neighbours."))
        : card(this.facts, face, (other) => this.zoom(other)),
    );
    this.outline(this.selection, face === null ? [] : [face]);
    this.stage.draw();
  }

  /** Selects a panel and brings it to the middle of the view. */
  private zoom(face: number): void {
    this.select(face);
    const normal = faceNormal(this.facts.mesh, this.facts.mesh.positions, face);
    const eye = this.stage.direction().normalize();
    if (normal.dot(eye) < 0) normal.negate();
    const direction = eye.multiplyScalar(0.35).add(normal);
    const reach = CLOSE_UP * this.radii[face];
    const ends = [-reach, reach].flatMap((d) => [0, 1, 2].flatMap((axis) => beside(this.centres[face], axis, d)));
    this.stage.look([new Float32Array(ends)], direction, true);
  }

  private outline(object: LineSegments2, faces: number[]): void {
    const { mesh: base } = this.facts;
    const points: number[] = [];
    for (const face of faces) {
      const corners = faceCorners(base, face);
      corners.forEach((v, k) => {
        for (const end of [v, corners[(k + 1) % corners.length]]) {
          points.push(...base.positions.subarray(3 * end, 3 * end + 3));
        }
      });
    }
    object.geometry.dispose();
    object.geometry = lines(points, 1, 0).geometry;
    object.visible = points.length > 0;
  }

  private fit(animated: boolean): void {
    this.stage.look(this.points(), this.stage.direction(), animated);
  }

  /** Everything that has to be seen. */
  private points(): Float32Array[] {
    const panels = this.facts.mesh.positions;
    const seen = this.gauss.filter((image) => image.group.visible);
    return [panels, ...seen.flatMap((image) => [image.polygons.mesh.positions, image.extent])];
  }

  private listen(): void {
    const canvas = this.stage.renderer.domElement;
    const { signal } = this.life;
    let down = { x: 0, y: 0 };
    canvas.addEventListener("pointerdown", (event) => void (down = { x: event.clientX, y: event.clientY }), { signal });
    canvas.addEventListener("click", (event) => {
      if (Math.hypot(event.clientX - down.x, event.clientY - down.y) <= CLICK) this.select(this.pick(event));
    }, { signal });
    canvas.addEventListener("dblclick", (event) => {
      const face = this.pick(event);
      if (face !== null) this.zoom(face);
    }, { signal });
    canvas.addEventListener("pointermove", (event) => this.hover(event), { signal });
    canvas.addEventListener("pointerleave", () => this.tip(null, 0, 0), { signal });
    window.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.select(null);
    }, { signal });
    this.stage.before(() => this.lift(), signal);
    this.stage.before(() => this.polygons.fade(this.stage.pixels(this.packed.meanEdge)), signal);
    this.stage.resized(() => this.resize(), signal);
    this.stage.after(() => {
      const { x, y } = this.stage.size;
      this.tags.draw(this.stage.size, () => this.picker.map(x, y));
    }, signal);
    this.resize();
  }

  /** Lines on the surface are drawn a little nearer to the eye, so that panels that bulge over them do not hide them. */
  private lift(): void {
    const { camera } = this.stage;
    const share = Math.min(0.5, (LIFT * this.packed.meanEdge) / this.stage.direction().length());
    for (const object of this.onSurface) {
      // A motion towards the eye that changes depths only.
      object.scale.setScalar(1 - share);
      object.position.copy(camera.position).multiplyScalar(share);
    }
  }

  private pick(event: MouseEvent): number | null {
    if (this.shownMesh === "before") return null;
    const box = this.stage.renderer.domElement.getBoundingClientRect();
    return this.picker.at(event.clientX - box.x, event.clientY - box.y, box.width, box.height);
  }

  private hovering = false;

  private hover(event: PointerEvent): void {
    if (this.hovering || event.buttons !== 0) return;
    this.hovering = true;
    requestAnimationFrame(() => {
      this.hovering = false;
      const box = this.part("canvas").getBoundingClientRect();
      this.tip(this.pick(event), event.clientX - box.x, event.clientY - box.y);
    });
  }

  private tip(face: number | null, x: number, y: number): void {
    const tip = this.part("tip");
    tip.hidden = face === null;
    if (face === null) return;
    const { map, values } = this.current;
    const value = map.element === "face" ? ` · ${shown(map, values[face])}` : "";
    tip.textContent = `${say("Panel {}", panelName(this.packed, face))}${value}`;
    tip.style.transform = `translate(${x + 14}px, ${y + 14}px)`;
  }

  private resize(): void {
    this.stage.fitLines(this.world);
  }
}

const COMPARE: Record<string, string> = {
  before: "The layout that the optimiser started from",
  after: "The result",
  both: "The result, with the edges of the layout it started from",
};

/** A point at a distance from another along an axis. */
function beside(point: Vector3, axis: number, distance: number): number[] {
  return point.clone().setComponent(axis, point.getComponent(axis) + distance).toArray();
}

/** Lines that are seen through everything. */
function overlay(width: number, colour: number): LineSegments2 {
  const object = lines([], width, colour);
  object.material.depthTest = false;
  object.material.transparent = true;
  object.renderOrder = 10;
  object.visible = false;
  return object;
}

function unpack(packed: Packed): Facts {
  const base = mesh(packed.mesh);
  const maps = packed.maps.map((map: PackedMap) => ({ map, values: floats(map.values) }));
  return {
    packed,
    mesh: base,
    area: floats(packed.area),
    planarity: floats(packed.planarity),
    angles: floats(packed.angles),
    concave: numbers(packed.concave),
    maps,
    neighbours: neighbours(base, faceCount(base)),
  };
}
