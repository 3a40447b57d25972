/** Small helpers to build elements. Text is always set as text, never as markup. */

type Child = Node | string;

export function h(tag: string, attributes: Record<string, string> = {}, ...children: Child[]): HTMLElement {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

export function svg(tag: string, attributes: Record<string, string | number>, ...children: Child[]): SVGElement {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}

export function button(label: string, title: string, act: () => void): HTMLButtonElement {
  const element = h("button", { type: "button", title }, label) as HTMLButtonElement;
  element.addEventListener("click", act);
  return element;
}

/** A number with few digits; very small ones as powers of ten. */
export function figure(value: number): string {
  if (value === 0) return "0";
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size < 1e-3) return value.toExponential(1).replace("e-", "e−");
  if (size >= 1e6) return value.toExponential(3);
  return String(Number(value.toPrecision(4))).replace("-", "−");
}

/** Square metres from which areas of small units are told in them. */
const IN_METRES = 1e-3;

/** An area with its unit, in square metres where that reads better. */
export function area(value: number, unit: string): string {
  const metres = { mm: 1e-3, cm: 1e-2 }[unit];
  const inMetres = metres === undefined ? 0 : value * metres * metres;
  return inMetres >= IN_METRES ? `${figure(inMetres)} m²` : `${figure(value)} ${unit}²`;
}
