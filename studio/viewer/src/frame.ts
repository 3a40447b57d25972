/** The parts of the interactive view in a page. */

import { h } from "./dom";
import { say } from "./words";

export type Parts = (name: string) => HTMLElement;

export const part = (name: string, tag = "div"): HTMLElement => h(tag, { "data-part": name, class: name });

/** A named section with a part. */
export const section = (title: string, name: string): HTMLElement => h("section", {}, h("h2", {}, say(title)), part(name));

/** The view with what lies over it. */
export const view = (): HTMLElement =>
  h("div", { class: "view" }, part("canvas"), part("views"), part("compare"), part("legend"), part("tip"));

/** What stands beside the view. */
export const sections = (): HTMLElement[] => [
  section("Colours", "maps"),
  section("Layers", "layers"),
  section("Panel", "selection"),
  section("Offenders", "offenders"),
];

/** Finds parts below an element. */
export function partsOf(root: HTMLElement): Parts {
  return (name) => {
    const found = root.querySelector<HTMLElement>(`[data-part="${name}"]`);
    if (!found) throw new Error(`the page has no part ${name}`);
    return found;
  };
}
