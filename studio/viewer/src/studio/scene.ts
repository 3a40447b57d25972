/** What is seen: the surface, panels on their way, the result, and what is set on the surface. */

import {
  Box3,
  BufferAttribute,
  BufferGeometry,
  Color,
  DoubleSide,
  Group,
  type Material,
  Mesh as Surface,
  MeshStandardMaterial,
  type Object3D,
  Plane,
  Points,
  PointsMaterial,
  Raycaster,
  Vector2,
  Vector3,
} from "three";
import { App, type Choice } from "../app";
import { floats, mesh, numbers, type Packed, type PackedMesh } from "../data";
import { button } from "../dom";
import type { Parts } from "../frame";
import { lines, Polygons } from "../polygons";
import { Stage, VIEWS } from "../stage";
import { say } from "../words";
import type { SurfaceFrame } from "./server";

const GUIDE = 0x0050ff;
const WRONG = 0xd4006a;
/** A press that moves farther than this is a turn of the view, in pixels. */
const CLICK = 5;
/** How large fixed points and cones are drawn, in pixels. */
const DOT = 11;
/** Colours of panels that nobody has judged. */
const UNJUDGED: [number, number, number] = [223, 228, 238];

export type Theme = "light" | "dark";

/** What is set on the surface, model units. */
export interface Placed {
  lines: [number, number, number][][];
  points: [number, number, number][];
  cones: { position: [number, number, number]; index: number }[];
}

export class View {
  readonly stage: Stage;
  app: App | null = null;
  /** What was chosen to be seen of the last result. */
  private choice: Choice | null = null;
  private readonly ground = new Group();
  private readonly panels = new Group();
  private readonly placed = new Group();
  private readonly draft = new Group();
  private solid: Surface | null = null;
  private preview: Polygons | null = null;
  private origin = new Vector3();
  private box = new Box3();
  private section: Plane | null = null;
  /** Called with a click on the surface, model units; whether it is one for a tool is for the caller. */
  onClick: ((at: [number, number, number]) => void) | null = null;

  constructor(private readonly parts: Parts) {
    this.stage = new Stage(parts("canvas"));
    this.stage.scene.add(this.ground, this.panels, this.placed, this.draft);
    this.stage.resized(() => this.stage.fitLines(this.stage.scene));
    this.listen();
  }

  setTheme(theme: Theme): void {
    this.stage.scene.background = new Color(theme === "dark" ? 0x1a1d23 : 0xf5f6f8);
    this.stage.draw();
  }

  /** Shows a surface alone. */
  showSurface(frame: SurfaceFrame): void {
    this.stage.resize();
    this.clearPanels();
    clear(this.ground);
    this.origin.fromArray(frame.origin);
    if (frame.surface) {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(floats(frame.surface.positions), 3));
      geometry.setIndex(new BufferAttribute(numbers(frame.surface.triangles), 1));
      geometry.computeVertexNormals();
      const material = new MeshStandardMaterial({ color: 0xb9c4d6, side: DoubleSide, roughness: 0.9, polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2 });
      this.solid = new Surface(geometry, material);
      this.ground.add(this.solid);
    } else if (frame.broken) {
      const polygons = new Polygons(mesh(frame.broken.mesh));
      polygons.colourFaces(() => [224, 226, 232]);
      const sides = lines(floats(frame.broken.sides), 4, WRONG);
      sides.material.depthTest = false;
      this.solid = polygons.faces as unknown as Surface;
      this.ground.add(polygons.group, sides, dots(floats(frame.broken.points), WRONG, DOT + 3));
    }
    this.box = new Box3().setFromObject(this.solid!);
    if (this.box.isEmpty()) this.box.set(new Vector3(-1, -1, -1), new Vector3(1, 1, 1));
    this.stage.setExtent(this.box);
    this.buildViews();
    this.stage.fitLines(this.stage.scene);
    this.look(false);
  }

  /** Shows panels on their way; the last ones go. */
  showPanels(packed: PackedMesh): void {
    this.clearPanels();
    const polygons = new Polygons(mesh(packed));
    polygons.colourFaces(() => UNJUDGED);
    this.preview = polygons;
    this.panels.add(polygons.group);
    this.ground.visible = false;
    this.buildViews();
    this.stage.fitLines(this.panels);
    this.stage.draw();
  }

  /** Shows a result. */
  showResult(packed: Packed): App {
    this.clearPanels();
    this.ground.visible = false;
    this.app = new App(packed, this.parts, this.stage, true);
    if (this.choice) this.app.restore(this.choice);
    this.stage.fitLines(this.stage.scene);
    this.stage.draw();
    return this.app;
  }

  /** Shows lines, points and cones that are set, and the line that is being drawn. */
  showPlaced(placed: Placed, drawn: [number, number, number][]): void {
    clear(this.placed);
    clear(this.draft);
    const segments = (line: [number, number, number][]): number[] => line.slice(1).flatMap((p, k) => [...this.inner(line[k]), ...this.inner(p)]);
    const flat = (points: [number, number, number][]): Float32Array => new Float32Array(points.flatMap((p) => this.inner(p)));
    this.placed.add(overlay(lines(placed.lines.flatMap(segments), 3.4, GUIDE)));
    this.placed.add(dots(flat(placed.points), 0x17191f, DOT));
    this.placed.add(dots(flat(placed.cones.filter((c) => c.index > 0).map((c) => c.position)), 0xd55e00, DOT));
    this.placed.add(dots(flat(placed.cones.filter((c) => c.index < 0).map((c) => c.position)), 0x0072b2, DOT));
    this.draft.add(overlay(lines(segments(drawn), 3.4, GUIDE)), dots(flat(drawn), GUIDE, DOT - 3));
    this.stage.fitLines(this.placed);
    this.stage.fitLines(this.draft);
    this.stage.draw();
  }

  /** Cuts away what lies on one side; `share` goes from 0 to 1 across the model. */
  cut(axis: "x" | "y" | "z" | null, share: number): void {
    if (axis === null) this.section = null;
    else {
      const normal = new Vector3().setComponent("xyz".indexOf(axis), -1);
      const [low, high] = [this.box.min[axis], this.box.max[axis]];
      this.section = new Plane(normal, low + share * (high - low) * 1.002 + 1e-9);
    }
    this.stage.renderer.clippingPlanes = this.section ? [this.section] : [];
    this.stage.draw();
  }

  /** Brings everything into the view. */
  look(animated: boolean, direction = new Vector3(...VIEWS.Iso)): void {
    this.stage.look([this.solid!.geometry.getAttribute("position").array as Float32Array], direction, animated);
  }

  /** The picture as it is, small. */
  thumbnail(width: number, height: number): string {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [width, height];
    const source = this.stage.renderer.domElement;
    const pen = canvas.getContext("2d");
    const scale = Math.max(width / source.width, height / source.height);
    const [w, h] = [source.width * scale, source.height * scale];
    pen?.drawImage(source, (width - w) / 2, (height - h) / 2, w, h);
    return canvas.toDataURL("image/jpeg", 0.8);
  }

  /** Place in the page of a point of the model, for scripts and tests. */
  locate(point: [number, number, number]): { x: number; y: number } {
    const p = new Vector3(...this.inner(point)).project(this.stage.camera);
    const box = this.stage.renderer.domElement.getBoundingClientRect();
    return { x: box.x + ((p.x + 1) / 2) * box.width, y: box.y + ((1 - p.y) / 2) * box.height };
  }

  /** The point of the surface under a place of the page, model units. */
  pick(clientX: number, clientY: number): [number, number, number] | null {
    const box = this.stage.renderer.domElement.getBoundingClientRect();
    const at = new Vector2(((clientX - box.x) / box.width) * 2 - 1, 1 - ((clientY - box.y) / box.height) * 2);
    const ray = new Raycaster();
    ray.setFromCamera(at, this.stage.camera);
    const seen = this.solid ? ray.intersectObject(this.solid, false) : [];
    const hit = seen.find((s) => !this.section || this.section.distanceToPoint(s.point) >= 0);
    return hit ? (hit.point.add(this.origin).toArray() as [number, number, number]) : null;
  }

  private listen(): void {
    const canvas = this.stage.renderer.domElement;
    let down = { x: 0, y: 0 };
    canvas.addEventListener("pointerdown", (event) => void (down = { x: event.clientX, y: event.clientY }));
    canvas.addEventListener(
      "click",
      (event) => {
        if (!this.onClick || Math.hypot(event.clientX - down.x, event.clientY - down.y) > CLICK) return;
        event.stopImmediatePropagation();
        const at = this.pick(event.clientX, event.clientY);
        if (at) this.onClick(at);
      },
      { capture: true },
    );
  }

  /** Writes the buttons of the views, where there are none. */
  buildViews(): void {
    const views = this.parts("views");
    if (views.childElementCount > 0) return;
    for (const [name, direction] of Object.entries(VIEWS)) {
      views.append(button(say(name), say(`${name} view`), () => this.look(true, new Vector3(...direction))));
    }
    views.append(button(say("Fit"), say("Fit everything into the view"), () => this.look(true, this.stage.direction())));
  }

  private clearPanels(): void {
    if (this.app) this.choice = this.app.choice;
    this.app?.dispose();
    this.app = null;
    clear(this.panels);
    this.preview = null;
    this.ground.visible = true;
  }

  /** Gives everything back. */
  dispose(): void {
    this.clearPanels();
    clear(this.ground);
    this.stage.dispose();
  }

  /** Number of panels on their way that are shown. */
  get previewed(): number {
    return this.preview ? this.preview.mesh.faceStart.length - 1 : 0;
  }

  private inner(p: [number, number, number]): [number, number, number] {
    return [p[0] - this.origin.x, p[1] - this.origin.y, p[2] - this.origin.z];
  }

}

/** Takes everything out of a group, and gives back what the graphics card holds of it. */
function clear(group: Group): void {
  group.traverse((object: Object3D) => {
    if (!(object instanceof Surface || object instanceof Points)) return;
    object.geometry.dispose();
    (object.material as Material).dispose();
  });
  group.clear();
}

/** Points of a size on the screen, seen through everything. */
function dots(positions: Float32Array, colour: number, size: number): Points {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  const material = new PointsMaterial({ color: colour, size, sizeAttenuation: false, depthTest: false, transparent: true });
  const object = new Points(geometry, material);
  object.renderOrder = 12;
  object.frustumCulled = false;
  return object;
}

function overlay<T extends ReturnType<typeof lines>>(object: T): T {
  object.material.depthTest = false;
  object.material.transparent = true;
  object.renderOrder = 11;
  return object;
}

