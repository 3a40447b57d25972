/** Names written on the panels that are seen and large enough. */

import type { PerspectiveCamera, Vector2, Vector3 } from "three";

/** Smallest size of a panel on the screen that has room for its name, in pixels. */
const ROOM = 22;
/** Height of a line of text in pixels. */
const LINE = 12;
const MOST = 1200;

export class Tags {
  readonly canvas = document.createElement("canvas");
  visible = false;

  constructor(
    private readonly camera: PerspectiveCamera,
    private readonly centres: Vector3[],
    private readonly radii: number[],
    private readonly normals: Vector3[],
    private readonly name: (face: number) => string,
  ) {
    this.canvas.className = "tags";
  }

  /** Writes the names; `seen` says which panel is at a place of the view. */
  draw(size: Vector2, seen: () => (u: number, v: number) => number | null): void {
    const scale = Math.min(window.devicePixelRatio, 2);
    this.canvas.width = size.x * scale;
    this.canvas.height = size.y * scale;
    const pen = this.canvas.getContext("2d");
    if (!pen || !this.visible) return;
    pen.scale(scale, scale);
    pen.font = "600 11px system-ui, sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.lineWidth = 3;
    pen.strokeStyle = "rgb(255 255 255 / 85%)";
    pen.fillStyle = "#14161b";
    const near = this.large(size);
    if (near.length === 0) return;
    const at = seen();
    const taken: { x: number; y: number; half: number }[] = [];
    for (const { face, x, y } of near) {
      const name = this.name(face);
      const half = pen.measureText(name).width / 2 + 2;
      const clear = taken.every((t) => Math.abs(t.x - x) > t.half + half || Math.abs(t.y - y) > LINE);
      if (!clear || at(x / size.x, y / size.y) !== face) continue;
      taken.push({ x, y, half });
      pen.strokeText(name, x, y);
      pen.fillText(name, x, y);
    }
  }

  private large(size: Vector2): { face: number; x: number; y: number }[] {
    const zoom = size.y / Math.tan((this.camera.fov * Math.PI) / 360) / 2;
    const found = this.centres.map((centre, face) => {
      const sight = this.camera.position.clone().sub(centre);
      // A panel that is seen from its edge is narrow.
      const facing = Math.abs(this.normals[face].dot(sight)) / sight.length();
      const pixels = (2 * this.radii[face] * zoom * facing) / sight.length();
      const p = centre.clone().project(this.camera);
      return { face, pixels, x: ((p.x + 1) / 2) * size.x, y: ((1 - p.y) / 2) * size.y, z: p.z };
    });
    const room = found.filter((f) => f.pixels > ROOM && f.z < 1 && f.x > 0 && f.y > 0 && f.x < size.x && f.y < size.y);
    return room.sort((a, b) => b.pixels - a.pixels).slice(0, MOST);
  }
}
