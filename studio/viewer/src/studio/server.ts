/** Talks with the program. Addresses are relative, so that each carries the token of the page's own. */

import type { Packed, PackedMesh } from "../data";

/** What is in a file, in the program's names. */
export interface FileInfo {
  vertices: number;
  faces: number;
  diagonal: number;
  bounding_box: [number[], number[]];
  edge_length_mean: number;
  area: number | null;
  components: { triangles: number; boundary_loops: number; genus: number }[];
  notes: string[];
  problem: string | null;
}

export interface SurfaceFrame {
  id: string;
  name: string;
  info: FileInfo;
  origin: [number, number, number];
  surface: NonNullable<Packed["surface"]> | null;
  broken: { mesh: PackedMesh; sides: ArrayBuffer; points: ArrayBuffer } | null;
}

export interface Check {
  name: string;
  pass: boolean;
  decisive: boolean;
  value: number;
  limit: number;
  scale: string;
  value_length: number | null;
  limit_length: number | null;
  /** Of a sheet, `limit` and `value` are the shorter sides, and `across` the longer ones. */
  reading: { unit: string; limit: number; value: number; across?: [number, number] } | null;
  advice: string | null;
  faces: ArrayBuffer;
}

export interface Result {
  kind: "result";
  run: number;
  seconds: number;
  verdict: "pass" | "outside_tolerance" | "invalid";
  checks: Check[];
  figures: {
    panels: number;
    hexagons: number | null;
    concave: number;
    planarity: number;
    mean_edge: number;
    deviation: number | null;
    area: number;
  };
  notes: string[];
  unit: string;
  formats: string[];
  job: string;
  command: string;
  view: Packed;
}

export type RunFrame =
  | { kind: "begun"; run: number; job: string; command: string }
  | { kind: "progress"; run: number; stage: string; whole: { done: number; left_seconds: number } }
  | { kind: "mesh"; run: number; stage: string; seconds: number; mesh: PackedMesh }
  | { kind: "cancelled"; run: number }
  | { kind: "failed"; run: number; message: string }
  | Result;

/** Why there is no answer: in the program's words, or because there is no program any more. */
export class Refusal extends Error {
  constructor(
    readonly status: number,
    message: string,
  ) {
    super(message);
  }

  get isGone(): boolean {
    return this.status === 0;
  }
}

async function ask(address: string, init: RequestInit = {}): Promise<Response> {
  let response: Response;
  try {
    response = await fetch(address, init);
  } catch (error) {
    if (init.signal?.aborted) throw error;
    throw new Refusal(0, "the program does not answer");
  }
  if (response.ok) return response;
  const said = await response.json().catch(() => null);
  throw new Refusal(response.status, said?.message ?? `${response.status} ${response.statusText}`);
}

/** A frame: JSON in which arrays are replaced by what stands behind it. */
function frame(json: Uint8Array, arrays: Uint8Array): unknown {
  const place = (_: string, value: unknown): unknown => {
    const at = (value as { $?: [number, number] } | null)?.$;
    return at ? arrays.slice(at[0], at[0] + at[1]).buffer : value;
  };
  return JSON.parse(new TextDecoder().decode(json), place);
}

const HEAD = 8;

/** The frames of an answer, one after the other. */
async function* frames(response: Response): AsyncGenerator<unknown> {
  const reader = response.body!.getReader();
  let parts: Uint8Array[] = [];
  let length = 0;
  const joined = (): Uint8Array => {
    if (parts.length === 1) return parts[0];
    const whole = new Uint8Array(length);
    let at = 0;
    for (const part of parts) {
      whole.set(part, at);
      at += part.length;
    }
    parts = [whole];
    return whole;
  };
  let needed = HEAD;
  for (;;) {
    const { done, value } = await reader.read();
    if (value) {
      parts.push(value);
      length += value.length;
    }
    while (length >= needed) {
      const bytes = joined();
      const head = new DataView(bytes.buffer, bytes.byteOffset, HEAD);
      const [json, arrays] = [head.getUint32(0, true), head.getUint32(4, true)];
      needed = HEAD + json + arrays;
      if (length < needed) break;
      yield frame(bytes.subarray(HEAD, HEAD + json), bytes.subarray(HEAD + json, needed));
      parts = length > needed ? [bytes.subarray(needed)] : [];
      length -= needed;
      needed = HEAD;
    }
    if (done) return;
  }
}

async function one(response: Response): Promise<SurfaceFrame> {
  for await (const value of frames(response)) return value as SurfaceFrame;
  throw new Refusal(0, "the program does not answer");
}

export const MOST_BYTES = 256 * 2 ** 20;

export async function dropFile(file: File): Promise<SurfaceFrame> {
  if (file.size > MOST_BYTES) throw new Refusal(413, "more than 256 MB are not taken");
  return one(await ask(`surface?name=${encodeURIComponent(file.name)}`, { method: "POST", body: file }));
}

export const dropSample = async (name: string): Promise<SurfaceFrame> =>
  one(await ask(`surface?sample=${encodeURIComponent(name)}`, { method: "POST" }));

export const surface = async (id: string): Promise<SurfaceFrame> => one(await ask(`surface/${encodeURIComponent(id)}`));

export const samples = async (): Promise<[string, string][]> => (await ask("samples")).json();

export const status = async (): Promise<{ runs: number; results: number }> => (await ask("status")).json();

/** What a job file sets. */
export const readJob = async (text: string): Promise<Record<string, unknown>> => (await ask("job", { method: "POST", body: text })).json();

/** This page's name, and how often it has asked for a run: a preview that is given up can reach the program after the run that took its place. */
const page = Array.from(crypto.getRandomValues(new Uint32Array(4)), (x) => x.toString(36)).join("-");
let asked = 0;

/** Begins a run; aborting the signal cancels it. */
export async function* run(wish: object, signal: AbortSignal): AsyncGenerator<RunFrame> {
  const body = JSON.stringify({ ...wish, asked: { page, before: asked++ } });
  const answer = await ask("run", { method: "POST", body, signal });
  try {
    for await (const value of frames(answer)) yield value as RunFrame;
  } catch (error) {
    if (signal.aborted) throw error;
    throw new Refusal(0, "the program does not answer");
  }
}

/** A file of a result. */
export async function download(address: string): Promise<{ name: string; blob: Blob }> {
  const response = await ask(address);
  const name = /filename\*=UTF-8''(\S+)/.exec(response.headers.get("content-disposition") ?? "")?.[1];
  return { name: decodeURIComponent(name ?? "file"), blob: await response.blob() };
}
