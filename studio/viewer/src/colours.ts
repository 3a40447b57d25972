/** From values to colours, as the program's pictures do it. */

import { Color, SRGBColorSpace } from "three";
import type { Continuous, Scale } from "./data";

export type Rgb = [number, number, number];

const NO_VALUE: Rgb = [200, 200, 202];

/** Place of a value along the colours, 0 to 1. */
export function place(scale: Continuous, value: number): number {
  const { low, high } = scale;
  const t = scale.logarithmic ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return Number.isNaN(t) ? 0 : Math.min(1, Math.max(0, t));
}

/** The value at a place from 0 to 1. */
export function valueAt(scale: Continuous, t: number): number {
  const { low, high } = scale;
  return scale.logarithmic ? low * (high / low) ** t : low + (high - low) * t;
}

/** Number of values along a range, in bins of equal width; the first and last hold what is outside. */
export function histogram(scale: Continuous, values: Float32Array, bins: number): number[] {
  const counts = new Array<number>(bins).fill(0);
  for (const value of values) {
    if (!Number.isNaN(value)) counts[Math.min(bins - 1, Math.floor(place(scale, value) * bins))] += 1;
  }
  return counts;
}

function along(ramp: Rgb[], t: number): Rgb {
  const x = t * (ramp.length - 1);
  const first = Math.min(Math.floor(x), ramp.length - 2);
  const [a, b] = [ramp[first], ramp[first + 1]];
  return [0, 1, 2].map((k) => a[k] + (b[k] - a[k]) * (x - first)) as Rgb;
}

/** Colour of a value, sRGB from 0 to 255. */
export function colour(scale: Scale, value: number): Rgb {
  if (Number.isNaN(value)) return NO_VALUE;
  if ("classes" in scale) return scale.classes[value]?.colour ?? NO_VALUE;
  const { band, ramp } = scale.continuous;
  if (band && Math.abs(value) < band[0]) return band[1];
  return along(ramp, place(scale.continuous, value));
}

export const css = (rgb: Rgb): string => `rgb(${rgb.map(Math.round).join(" ")})`;

const converter = new Color();

/** Linear light of an sRGB colour, as shaders want it. */
export function linear(rgb: Rgb): Rgb {
  converter.setRGB(rgb[0] / 255, rgb[1] / 255, rgb[2] / 255, SRGBColorSpace);
  return [converter.r, converter.g, converter.b];
}
