/**
 * The data of a view: small things as JSON, large ones as little-endian arrays, in a report as base64, in the studio as
 * they are.
 */

export type PackedArray = string | ArrayBuffer;

export interface PackedMesh {
  positions: PackedArray;
  faceStart: PackedArray;
  corners: PackedArray;
  triangles: PackedArray;
  triangleFace: PackedArray;
  edges: PackedArray;
  edgeFaces: PackedArray;
}

export interface Continuous {
  low: number;
  high: number;
  logarithmic: boolean;
  ramp: [number, number, number][];
  limit: number | null;
  band: [number, [number, number, number]] | null;
}

export interface MapClass {
  label: string;
  colour: [number, number, number];
}

export type Scale = { continuous: Continuous } | { classes: MapClass[] };

export interface PackedMap {
  name: string;
  title: string;
  caption: string;
  element: "face" | "edge";
  values: PackedArray;
  scale: Scale;
  counts: number[];
  below: number;
  above: number;
  ticks: [number, string][];
}

export interface Offender {
  kind: string;
  loud: boolean;
  faces: number[];
  text: string;
}

export interface PackedCurves {
  name: string;
  points: PackedArray;
  starts: PackedArray;
}

export interface Packed {
  unit: string;
  meanEdge: number;
  mesh: PackedMesh;
  /** Names of the panels, as in the workshop files. */
  names: string[] | null;
  area: PackedArray;
  planarity: PackedArray;
  angles: PackedArray;
  concave: PackedArray;
  maps: PackedMap[];
  offenders: Offender[];
  gauss: { directions: PackedArray; inward: number; outward: number } | null;
  /** Gauss images of the other kinds, by the names of their layers. */
  spheres: Record<string, PackedArray>;
  surface: { positions: PackedArray; triangles: PackedArray } | null;
  curves: PackedCurves[];
  start: { mesh: PackedMesh; planarity: PackedArray } | null;
  /** Layers that the report has not, with the reason. */
  missing: Record<string, string>;
}

/** A polygon mesh in flat arrays. */
export interface Mesh {
  positions: Float32Array;
  faceStart: Uint32Array;
  corners: Uint32Array;
  triangles: Uint32Array;
  triangleFace: Uint32Array;
  edges: Uint32Array;
  edgeFaces: Uint32Array;
}

/** The face number of the free side of a boundary edge. */
export const NO_FACE = 0xffffffff;

function bytes(packed: PackedArray): ArrayBuffer {
  if (typeof packed !== "string") return packed;
  const raw = atob(packed);
  const out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
  return out.buffer;
}

export const floats = (packed: PackedArray): Float32Array => new Float32Array(bytes(packed));
export const numbers = (packed: PackedArray): Uint32Array => new Uint32Array(bytes(packed));

export function mesh(packed: PackedMesh): Mesh {
  return {
    positions: floats(packed.positions),
    faceStart: numbers(packed.faceStart),
    corners: numbers(packed.corners),
    triangles: numbers(packed.triangles),
    triangleFace: numbers(packed.triangleFace),
    edges: numbers(packed.edges),
    edgeFaces: numbers(packed.edgeFaces),
  };
}

export const faceCount = (mesh: Mesh): number => mesh.faceStart.length - 1;

/** Vertex numbers of a face. */
export const faceCorners = (mesh: Mesh, face: number): Uint32Array =>
  mesh.corners.subarray(mesh.faceStart[face], mesh.faceStart[face + 1]);

/** Name of a panel. */
export const panelName = (packed: Packed, face: number): string => packed.names?.[face] ?? String(face);

/** The data in the page, or nothing if there are none. */
export function readPage(): Packed | null {
  const element = document.getElementById("phex-data");
  return element?.textContent ? (JSON.parse(element.textContent) as Packed) : null;
}
