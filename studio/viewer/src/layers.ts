/** What can be shown besides the panels: each layer is made when it is first switched on. */

import {
  BufferAttribute,
  BufferGeometry,
  DoubleSide,
  Group,
  Mesh as Surface,
  MeshStandardMaterial,
  type Object3D,
  SphereGeometry,
  type Sphere,
  Vector3,
} from "three";
import type { Rgb } from "./colours";
import { faceCorners, faceCount, floats, mesh, numbers, type Mesh, type Packed, type PackedArray, type PackedCurves } from "./data";
import { faceNormal, lines, Polygons } from "./polygons";

export const START_COLOURS = 0x8a4fd0;
const CURVE_COLOURS = [0x0072b2, 0xd55e00];

export function surfaceLayer(packed: NonNullable<Packed["surface"]>): Object3D {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(floats(packed.positions), 3));
  geometry.setIndex(new BufferAttribute(numbers(packed.triangles), 1));
  geometry.computeVertexNormals();
  const material = new MeshStandardMaterial({
    color: 0x7f9fc4,
    side: DoubleSide,
    transparent: true,
    opacity: 0.42,
    roughness: 0.8,
    depthWrite: false,
  });
  return new Surface(geometry, material);
}

export function curvesLayer(families: PackedCurves[]): Group {
  const group = new Group();
  families.forEach((family, k) => {
    const points = floats(family.points);
    const starts = numbers(family.starts);
    const segments: number[] = [];
    for (let c = 0; c + 1 < starts.length; c++) {
      for (let i = starts[c]; i + 1 < starts[c + 1]; i++) segments.push(...points.subarray(3 * i, 3 * i + 6));
    }
    group.add(lines(segments, 2.2, CURVE_COLOURS[k % CURVE_COLOURS.length]));
  });
  return group;
}

/** The panels at a distance: every vertex moves along its vector of the Gauss image. */
export class Offset {
  readonly polygons: Polygons;
  private readonly directions: Float32Array;

  constructor(base: Mesh, gauss: NonNullable<Packed["gauss"]>) {
    this.directions = floats(gauss.directions);
    this.polygons = new Polygons(base, 0.5);
    this.polygons.colourFaces(() => [120, 160, 200]);
  }

  setDistance(distance: number): void {
    const base = this.polygons.mesh.positions;
    this.polygons.move(base.map((x, i) => x + distance * this.directions[i]));
  }
}

/** Farthest that a vertex of the Gauss image is drawn from the centre; flat places have none that is near. */
const REACH = 2.5;

/** Half the side of a cube whose corners are a little outside of the unit sphere. */
const BOX = 0.62;

/** How far inside of the sphere panels are drawn where curvature is negative: they cover it a second time, the other way round. */
const SECOND_SHEET = 0.14;

/** Share of the panels at each vertex whose Gauss image has the opposite orientation. */
function reversed(base: Mesh, directions: Float32Array): Float32Array {
  const [all, turned] = [0, 0].map(() => new Float32Array(directions.length / 3));
  for (let face = 0; face < faceCount(base); face++) {
    const opposite = faceNormal(base, base.positions, face).dot(faceNormal(base, directions, face)) < 0;
    for (const v of faceCorners(base, face)) {
      all[v]++;
      if (opposite) turned[v]++;
    }
  }
  return turned.map((count, v) => count / Math.max(all[v], 1));
}

/** Where the Gauss images of the kinds are, seen from the model. */
const SIDES = [
  [1.7, 1, 0],
  [1.7, -1, 0],
  [-1.7, 1, 0],
] as const;

/** A Gauss image beside the model, with the unit sphere. */
export class GaussImage {
  readonly group = new Group();
  readonly polygons: Polygons;
  /** Corners of a box round the unit sphere. */
  readonly extent: Float32Array;

  constructor(base: Mesh, packed: PackedArray, model: Sphere, side: number) {
    const radius = 0.55 * model.radius;
    const centre = new Vector3(...SIDES[side]).setLength(model.radius + 1.35 * radius).add(model.center);
    const directions = floats(packed);
    const positions = new Float32Array(directions.length);
    const turned = reversed(base, directions);
    for (let i = 0; i < directions.length; i += 3) {
      const n = new Vector3().fromArray(directions, i).clampLength(0, REACH);
      n.multiplyScalar(radius * (1 - SECOND_SHEET * turned[i / 3])).add(centre).toArray(positions, i);
    }
    this.polygons = new Polygons({ ...base, positions });
    this.polygons.edges.material.linewidth = 0.7;
    const corner = (k: number) => [1, 2, 4].map((bit, axis) => centre.getComponent(axis) + (k & bit ? 1 : -1) * BOX * radius);
    this.extent = new Float32Array(Array.from({ length: 8 }, (_, k) => corner(k)).flat());
    const material = new MeshStandardMaterial({ color: 0xffffff, transparent: true, opacity: 0.25, depthWrite: false });
    // Inside of both sheets, where there are two.
    const inner = 0.985 * (turned.some((share) => share > 0) ? 1 - SECOND_SHEET : 1);
    const sphere = new Surface(new SphereGeometry(inner * radius, 64, 40), material);
    sphere.position.copy(centre);
    this.group.add(this.polygons.group, sphere);
  }
}

/** The mesh before the optimiser. */
export class Start {
  readonly polygons: Polygons;
  readonly wires: Group = new Group();
  readonly planarity: Float32Array;

  constructor(packed: NonNullable<Packed["start"]>) {
    const base = mesh(packed.mesh);
    this.planarity = floats(packed.planarity);
    this.polygons = new Polygons(base);
    const points = Array.from(base.edges, (v) => Array.from(base.positions.subarray(3 * v, 3 * v + 3))).flat();
    this.wires.add(lines(points, 1.8, START_COLOURS));
  }

  colour(byPlanarity: ((value: number) => Rgb) | null): void {
    const plain: Rgb = [226, 222, 235];
    this.polygons.colourFaces((face) => (byPlanarity ? byPlanarity(this.planarity[face]) : plain));
  }
}
