/** The legend: what the colours mean, with the number of elements at each value. */

import { colour, css, histogram, place, valueAt } from "./colours";
import type { Continuous, PackedMap } from "./data";
import { figure, h, svg } from "./dom";
import { say } from "./words";

const WIDTH = 292;
const HISTOGRAM = 58;
const STRIP = 12;

export function legend(map: PackedMap, note: string | null): HTMLElement {
  const body = "classes" in map.scale ? classes(map) : strip(map, map.scale.continuous);
  const notes = note === null ? [] : [h("p", { class: "aside" }, note)];
  return h("div", { class: "legend-body" }, h("h3", {}, say(map.title)), h("p", {}, say(map.caption)), body, ...notes);
}

/** A map with the histogram of other values. */
export function counted(map: PackedMap, values: Float32Array): PackedMap {
  if ("classes" in map.scale) return map;
  const scale = map.scale.continuous;
  const counts = histogram(scale, values, map.counts.length);
  const outside = (is: (v: number) => boolean) => values.filter(is).length;
  return { ...map, counts, below: outside((v) => v < scale.low), above: outside((v) => v > scale.high) };
}

function classes(map: PackedMap): HTMLElement {
  const list = h("ul", { class: "classes" });
  if (!("classes" in map.scale)) return list;
  const most = Math.max(1, ...map.counts);
  map.scale.classes.forEach((entry, k) => {
    const count = map.counts[k];
    if (count === 0) return;
    const swatch = h("span", { class: "swatch" });
    swatch.style.background = css(entry.colour);
    const bar = h("span", { class: "bar", "data-count": String(count), "data-label": entry.label });
    bar.style.width = `${Math.max(2, (64 * count) / most)}px`;
    bar.style.background = css(entry.colour);
    list.append(h("li", {}, swatch, h("span", { class: "label" }, say(entry.label)), bar, h("b", {}, String(count))));
  });
  return list;
}

function strip(map: PackedMap, scale: Continuous): Node {
  const height = HISTOGRAM + STRIP + 22;
  const picture = svg("svg", { width: WIDTH, height, viewBox: `-8 0 ${WIDTH + 16} ${height}`, class: "strip" });
  picture.append(...bars(map, scale), ...cells(map), ...marks(map, scale));
  return picture;
}

function bars(map: PackedMap, scale: Continuous): Node[] {
  const { counts } = map;
  const most = Math.max(1, ...counts);
  const width = WIDTH / counts.length;
  return counts.map((count, k) => {
    const tall = count === 0 ? 0 : Math.max(2, (HISTOGRAM * count) / most);
    const [low, high] = [valueAt(scale, k / counts.length), valueAt(scale, (k + 1) / counts.length)];
    const from = k === 0 && map.below > 0 ? say("at most") : `${figure(low)} –`;
    const to = k === counts.length - 1 && map.above > 0 ? say("and more") : figure(high);
    const fill = css(colour(map.scale, valueAt(scale, (k + 0.5) / counts.length)));
    return svg(
      "rect",
      {
        x: k * width + 0.5,
        y: HISTOGRAM - tall,
        width: width - 1,
        height: tall,
        fill,
        class: "bar",
        "data-count": count,
      },
      svg("title", {}, `${from} ${to}: ${count}`),
    );
  });
}

function cells(map: PackedMap): Node[] {
  if ("classes" in map.scale) return [];
  const scale = map.scale.continuous;
  const steps = 73;
  return Array.from({ length: steps }, (_, k) => {
    const fill = css(colour(map.scale, valueAt(scale, (k + 0.5) / steps)));
    const x = (k * WIDTH) / steps;
    return svg("rect", { x, y: HISTOGRAM + 1, width: WIDTH / steps + 0.6, height: STRIP, fill });
  });
}

function marks(map: PackedMap, scale: Continuous): Node[] {
  const foot = HISTOGRAM + 1 + STRIP;
  const out: Node[] = map.ticks.flatMap(([t, label]) => {
    const x = t * WIDTH;
    const anchor = t < 0.02 ? "start" : t > 0.98 ? "end" : "middle";
    return [
      svg("line", { x1: x, x2: x, y1: foot, y2: foot + 4, class: "tick" }),
      svg("text", { x, y: foot + 16, "text-anchor": anchor }, label.replace("-", "−")),
    ];
  });
  const limit = scale.limit === null ? 0 : place(scale, scale.limit);
  if (limit > 0 && limit < 1) {
    const x = limit * WIDTH;
    out.push(svg("line", { x1: x, x2: x, y1: 4, y2: foot, class: "limit" }));
    const left = limit > 0.8;
    out.push(svg("text", { x: left ? x - 4 : x + 4, y: 11, "text-anchor": left ? "end" : "start" }, say("limit")));
  }
  return out;
}
