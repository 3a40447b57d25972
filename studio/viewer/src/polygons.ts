/** A polygon mesh as three.js draws it: coloured faces, and lines along the real edges only. */

import {
  BufferAttribute,
  BufferGeometry,
  DoubleSide,
  Group,
  Mesh as Surface,
  MeshStandardMaterial,
  Vector3,
} from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { linear, type Rgb } from "./colours";
import { faceCorners, faceCount, type Mesh } from "./data";

/** Area vector of a polygon (Newell): normal times twice the area. */
export function faceNormal(mesh: Mesh, positions: Float32Array, face: number): Vector3 {
  const corners = faceCorners(mesh, face);
  const normal = new Vector3();
  const at = (k: number) => new Vector3().fromArray(positions, 3 * corners[k % corners.length]);
  const origin = at(0);
  for (let k = 1; k + 1 < corners.length; k++) {
    normal.add(at(k).sub(origin).cross(at(k + 1).sub(origin)));
  }
  return normal.normalize();
}

/** Mean of a face's corners. */
export function faceCentre(mesh: Mesh, face: number): Vector3 {
  const corners = faceCorners(mesh, face);
  const sum = new Vector3();
  for (const v of corners) sum.add(new Vector3().fromArray(mesh.positions, 3 * v));
  return sum.divideScalar(corners.length);
}

/** Largest distance of a face's corners from its centre. */
export function faceRadius(mesh: Mesh, face: number): number {
  const centre = faceCentre(mesh, face);
  const reach = (v: number) => new Vector3().fromArray(mesh.positions, 3 * v).distanceTo(centre);
  return Math.max(...Array.from(faceCorners(mesh, face), reach));
}

/** Fat lines between pairs of points. */
export function lines(points: ArrayLike<number>, width: number, colour: number): LineSegments2 {
  const geometry = new LineSegmentsGeometry();
  if (points.length > 0) geometry.setPositions(points as Float32Array);
  const material = new LineMaterial({ color: colour, linewidth: width });
  const object = new LineSegments2(geometry, material);
  object.frustumCulled = false;
  return object;
}

const EDGE_WIDTH = 1.1;
const COLOURED_WIDTH = 3.2;
/** Length of an edge on the screen from which it is drawn in full ink, in pixels. */
const FULL_EDGE = 14;

export class Polygons {
  readonly group = new Group();
  readonly faces: Surface<BufferGeometry, MeshStandardMaterial>;
  readonly edges: LineSegments2;

  constructor(
    readonly mesh: Mesh,
    opacity = 1,
  ) {
    this.faces = new Surface(this.geometry(), faceMaterial(opacity));
    this.edges = lines(this.edgePoints(mesh.positions), EDGE_WIDTH, EDGE_COLOUR);
    this.group.add(this.faces, this.edges);
  }

  /** Moves the vertices. */
  move(positions: Float32Array): void {
    this.setPositions(this.faces.geometry, positions);
    this.edges.geometry.setPositions(this.edgePoints(positions));
  }

  colourFaces(colour: (face: number) => Rgb): void {
    const { mesh } = this;
    const byFace = Array.from({ length: faceCount(mesh) }, (_, face) => linear(colour(face)));
    const attribute = this.faces.geometry.getAttribute("color") as BufferAttribute;
    mesh.triangleFace.forEach((face, t) => {
      for (let k = 0; k < 3; k++) attribute.setXYZ(3 * t + k, ...byFace[face]);
    });
    attribute.needsUpdate = true;
  }

  /** Colours the edges, or gives them back their own colour. */
  colourEdges(colour: ((edge: number) => Rgb) | null): void {
    const material = this.edges.material;
    material.vertexColors = colour !== null;
    material.color.set(colour ? 0xffffff : EDGE_COLOUR);
    material.linewidth = colour ? COLOURED_WIDTH : EDGE_WIDTH;
    material.needsUpdate = true;
    if (!colour) return;
    const count = this.mesh.edges.length / 2;
    const colours = new Float32Array(6 * count);
    for (let e = 0; e < count; e++) {
      const rgb = linear(colour(e));
      colours.set(rgb, 6 * e);
      colours.set(rgb, 6 * e + 3);
    }
    this.edges.geometry.setColors(colours);
  }

  /** Makes plain edges paler where panels are small on the screen, so that they do not cover everything. */
  fade(pixels: number): void {
    const { material } = this.edges;
    material.transparent = true;
    material.opacity = material.vertexColors ? 1 : Math.min(1, Math.max(0.22, pixels / FULL_EDGE));
  }

  private edgePoints(positions: Float32Array): Float32Array {
    const { edges } = this.mesh;
    const out = new Float32Array(3 * edges.length);
    edges.forEach((v, k) => out.set(positions.subarray(3 * v, 3 * v + 3), 3 * k));
    return out;
  }

  private geometry(): BufferGeometry {
    const { mesh } = this;
    const count = mesh.triangles.length;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setAttribute("normal", new BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setAttribute("color", new BufferAttribute(new Float32Array(3 * count).fill(0.8), 3));
    const number = new Float32Array(count);
    for (let i = 0; i < count; i++) number[i] = mesh.triangleFace[Math.floor(i / 3)];
    geometry.setAttribute("face", new BufferAttribute(number, 1));
    this.setPositions(geometry, mesh.positions);
    return geometry;
  }

  private setPositions(geometry: BufferGeometry, positions: Float32Array): void {
    const { mesh } = this;
    const normals = Array.from({ length: faceCount(mesh) }, (_, face) => faceNormal(mesh, positions, face));
    const position = geometry.getAttribute("position") as BufferAttribute;
    const normal = geometry.getAttribute("normal") as BufferAttribute;
    mesh.triangles.forEach((v, i) => {
      position.setXYZ(i, positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]);
      const n = normals[mesh.triangleFace[Math.floor(i / 3)]];
      normal.setXYZ(i, n.x, n.y, n.z);
    });
    position.needsUpdate = true;
    normal.needsUpdate = true;
    geometry.computeBoundingSphere();
  }
}

const EDGE_COLOUR = 0x26282e;

function faceMaterial(opacity: number): MeshStandardMaterial {
  return new MeshStandardMaterial({
    vertexColors: true,
    side: DoubleSide,
    roughness: 0.95,
    metalness: 0,
    transparent: opacity < 1,
    opacity,
    depthWrite: opacity === 1,
    // Behind the lines along its own edges.
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
  });
}
