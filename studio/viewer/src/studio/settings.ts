/** Every setting of a job, with its unit, its default and a sentence; and the controls that change it. */

import { figure, h } from "../dom";
import { say } from "../words";
import type { State } from "./state";

interface Setting {
  /** Its name in the job file; tables are separated by dots. */
  path: string;
  label: string;
  sentence: string;
  unit?: string;
  /** What holds where nothing is set. */
  fallback: string;
  /** What a slider stands at then. */
  rest?: number;
  slider?: { low: number; high: number; step: number; logarithmic?: boolean };
  choices?: [string, string][];
  toggle?: boolean;
  /** Whether a text is wanted, a length with a unit, say, and not a number. */
  text?: boolean;
  /** Whether a text may have commas, which elsewhere stand for decimals in one country and thousands in another. */
  commas?: boolean;
  whole?: boolean;
  /** What decides where nothing is set and something else is, in place of the fallback. */
  follows?: [string, string[]][];
}

interface Group {
  title: string;
  settings: Setting[];
  /** Whether it is closed at first. */
  closed?: boolean;
}

const dial = (path: string, label: string, sentence: string): Setting => ({
  path: `steering.${path}`,
  label,
  sentence,
  fallback: "1",
  rest: 1,
  slider: { low: 0.1, high: 10, step: 0.01, logarithmic: true },
});

const limit = (name: string, label: string, sentence: string, text = false, unit?: string): Setting => ({
  path: `limits.${name}`,
  label,
  sentence,
  fallback: "none",
  text,
  unit,
});

export const GROUPS: Group[] = [
  {
    title: "Panels",
    settings: [
      {
        path: "panels",
        label: "Number",
        sentence: "How many panels, about.",
        fallback: "500",
        rest: 500,
        whole: true,
        follows: [
          ["from the edge length", ["edge-length"]],
          ["from the limits", ["limits.max-panel", "limits.max-edge", "limits.max-area"]],
        ],
        slider: { low: 20, high: 5000, step: 1, logarithmic: true },
      },
      {
        path: "edge-length",
        label: "Edge length",
        sentence: "Length of the panels’ edges, about: 1.2, 1.2m, or 2% of the diagonal. It takes the place of the number.",
        fallback: "from the number",
        text: true,
      },
      {
        path: "rotate",
        label: "Rotation",
        sentence: "Turns the pattern from the directions that curvature suggests.",
        unit: "°",
        fallback: "0°",
        rest: 0,
        slider: { low: -90, high: 90, step: 1 },
      },
      {
        path: "symmetry",
        label: "Symmetry",
        sentence: "Panels get the symmetries of the surface: none, auto, mirror, or a number of rotations such as 6.",
        fallback: "none",
        text: true,
      },
      {
        path: "regular",
        label: "Hexagons alone",
        sentence: "Panels differ in size where pairs of a pentagon and a heptagon would even them out.",
        fallback: "off",
        toggle: true,
      },
      {
        path: "adaptive",
        label: "Adaptivity",
        sentence: "Smaller panels where the surface is strongly curved: panel length times curvature stays below this. Fewer is more; 0.4 is a good start.",
        fallback: "even panels",
        rest: 1.5,
        slider: { low: 0.1, high: 1.5, step: 0.05 },
      },
    ],
  },
  {
    title: "At the surface",
    settings: [
      {
        path: "boundary",
        label: "Boundary",
        sentence: "A row of panels along the boundary with corners on it, panels clipped by it, or whole panels that go past it.",
        fallback: "snap",
        choices: [
          ["snap", "Snap"],
          ["clip", "Clip"],
          ["whole", "Whole"],
        ],
      },
      {
        path: "target",
        label: "Close to",
        sentence: "The smooth surface through the vertices, the triangles as they are, or half way.",
        fallback: "smooth",
        choices: [
          ["smooth", "Smooth"],
          ["half-way", "Half way"],
          ["facets", "Triangles"],
        ],
      },
      {
        path: "unit",
        label: "Model unit",
        sentence: "What one unit of the model’s coordinates is.",
        fallback: "m",
        choices: [
          ["m", "m"],
          ["cm", "cm"],
          ["mm", "mm"],
          ["ft", "ft"],
          ["in", "in"],
        ],
      },
      {
        path: "all-components",
        label: "All parts",
        sentence: "Panels on every connected part of the surface.",
        fallback: "off",
        toggle: true,
      },
    ],
  },
  {
    title: "Limits",
    settings: [
      {
        path: "max-deviation",
        label: "Deviation",
        sentence: "Largest distance from the surface: 20mm, or 0.5% of the diagonal. A mesh beyond it does not pass.",
        fallback: "0.5%",
        text: true,
      },
      {
        path: "planarity",
        label: "Planarity",
        sentence: "Largest distance of a corner from its panel’s plane: 0.1mm, or a number in mean edges.",
        fallback: "to rounding",
        text: true,
      },
    ],
  },
  {
    title: "Repetition",
    closed: true,
    settings: [
      {
        path: "repeat",
        label: "Equal edges",
        sentence: "As many edges as can be are made equal within this length, inside all limits: 5mm.",
        fallback: "off",
        text: true,
      },
    ],
  },
  {
    title: "Limits of a workshop",
    closed: true,
    settings: [
      limit("max-panel", "Sheet", "Sheet that each panel is cut from, however it lies on it: 1.5x3m.", true),
      limit("min-edge", "Shortest edge", "No edge is shorter: 20cm.", true),
      limit("max-edge", "Longest edge", "No edge is longer: 1.2m.", true),
      limit("max-area", "Largest area", "No panel is larger: 2.5m2.", true),
      limit("min-angle", "Sharpest corner", "No corner of a panel is sharper.", false, "°"),
      limit("max-aspect", "Aspect", "No panel is longer than this many times its width."),
      limit("min-dihedral", "Sharpest joint", "Least angle between neighbouring panels; 180 is flat.", false, "°"),
      limit("max-dihedral", "Flattest joint", "Largest angle between neighbouring panels.", false, "°"),
    ],
  },
  {
    title: "How it is made",
    settings: [
      {
        path: "effort",
        label: "Effort",
        sentence: "Draft: one lattice, no search. Normal: another where it may be better, and a search where something is wrong. Best: all ways, side by side.",
        fallback: "normal",
        choices: [
          ["draft", "Draft"],
          ["normal", "Normal"],
          ["best", "Best"],
        ],
      },
      {
        path: "method",
        label: "Method",
        sentence: "A hexagonal lattice goes on any surface; the classical methods need curvature of one sign, brick walls a network of curvature lines.",
        fallback: "lattice",
        choices: [
          ["lattice", "Lattice"],
          ["brick-wall", "Brick wall"],
          ["power-diagram", "Power diagram"],
          ["projective-dual", "Projective dual"],
          ["dual-subdivision", "Dual subdivision"],
          ["support-function", "Support function"],
          ["tangent-planes", "Tangent planes"],
          ["parallel", "Parallel mesh"],
          ["koebe", "Koebe mesh"],
        ],
      },
      {
        path: "seed",
        label: "Seed",
        sentence: "Seed of every random choice; the same seed gives the same mesh.",
        fallback: "0",
        whole: true,
      },
    ],
  },
  {
    title: "For some methods",
    closed: true,
    settings: [
      {
        path: "any-domain",
        label: "Anywhere",
        sentence: "Use the method where it is not made for the surface, to see what becomes of it.",
        fallback: "off",
        toggle: true,
      },
      {
        path: "minimal",
        label: "Minimal",
        sentence: "Give all panels the mean curvature 0, for minimal surfaces; for Koebe meshes.",
        fallback: "off",
        toggle: true,
      },
      {
        path: "regularise",
        label: "Hold back",
        sentence: "Hold back corners where tangent planes meet badly, 0.05 to 0.5; for tangent planes.",
        fallback: "off",
      },
      {
        path: "steering.solver",
        label: "Solver",
        sentence: "How panels are made planar: with a barrier that keeps them simple, or as in the paper, for comparison.",
        fallback: "barrier",
        choices: [
          ["barrier", "Barrier"],
          ["tetrahedra", "Tetrahedra"],
        ],
      },
    ],
  },
  {
    title: "Dials",
    closed: true,
    settings: [
      dial("fairness", "Evenness", "More than 1: more even panels; less: freer ones."),
      dial("closeness", "Closeness", "More than 1: nearer to surface and boundary."),
      dial("clearance", "Room", "More than 1: more room between the corners and edges of a panel."),
      {
        path: "steering.centres",
        label: "Centres",
        sentence: "Less than 1: corners nearer to the surface, centres of panels farther.",
        fallback: "1",
        rest: 1,
        slider: { low: 0, high: 2, step: 0.05 },
      },
      {
        path: "steering.ground",
        label: "Ground",
        sentence: "Keeps corners of the boundary in a level plane: lowest, or a height.",
        fallback: "none",
        text: true,
        commas: true,
      },
      {
        path: "steering.ground-reach",
        label: "Reach of it",
        sentence: "How far from the ground corners of the boundary may lie to be put in it, mean edges.",
        fallback: "0.5, or less: no farther than the largest deviation",
      },
      {
        path: "guides.crease",
        label: "Creases",
        sentence: "Rows run along edges whose triangles meet at more than this angle; 30 is a good start.",
        unit: "°",
        fallback: "none",
      },
    ],
  },
];

const SETTINGS = GROUPS.flatMap(({ settings }) => settings);

/** The last part of a setting's path, which is the name of its option. */
const option = ({ path }: Setting): string => path.slice(path.lastIndexOf(".") + 1);

/** A text of the program with the names of rows in place of options; a name without dashes stands for itself in sentences. */
export function inRows(text: string): string {
  return text.replace(/(?<![\w-])(--)?([a-z]+(?:-[a-z]+)*)(?![\w-])/g, (whole, dashes: string | undefined, name: string) => {
    const setting = dashes || name.includes("-") ? SETTINGS.find((s) => option(s) === name) : undefined;
    return setting ? `“${say(setting.label)}”` : whole;
  });
}

/** What happens when something is changed: while it is, and when it is done. */
export interface Listener {
  moving(): void;
  done(): void;
}

/** Position of a value on a slider, and back; a logarithmic one has a thousand places. */
const PLACES = 1000;

function toPlace({ low, high, logarithmic }: NonNullable<Setting["slider"]>, value: number): number {
  return logarithmic ? (PLACES * Math.log(value / low)) / Math.log(high / low) : value;
}

function fromPlace({ low, high, step, logarithmic }: NonNullable<Setting["slider"]>, place: number, whole = false): number {
  if (!logarithmic) return Number(place.toFixed(4));
  const value = low * (high / low) ** (place / PLACES);
  // Numbers that a person would have typed.
  return whole ? Number(value.toPrecision(2)) : Math.max(step, Number(value.toPrecision(2)));
}

/** What is wrong with a value that was typed, as far as the page can tell; null where nothing is. */
function wrong(setting: Setting, value: unknown): string | null {
  if (typeof value !== "string" || setting.choices || setting.toggle) return null;
  if (setting.whole && WHOLE.test(value)) return say("`{}` is too large: the studio keeps all digits up to {}", value, Number.MAX_SAFE_INTEGER);
  if (setting.whole) return say("`{}` is not a whole number", value);
  if (value.includes(",") && !setting.commas) return say("`{}` has a comma: write a point before decimals, and nothing between thousands", value);
  return setting.text ? null : say("`{}` is not a number", value);
}

const WHOLE = /^-?\d+$/;

/** Where a message of the program begins with a setting: in a job file, as an option, or before a colon. */
const NAMED = /^(?:line \d+: |--|(?=[\w.-]+(?:: | can't be )))([\w.-]+)/;

export class Settings {
  private updates: (() => void)[] = [];
  private refused: Setting | null = null;

  constructor(
    private readonly state: State,
    private readonly listener: Listener,
    private readonly hint: (text: string) => void,
  ) {}

  /** All groups, anew; those that were built before are forgotten. */
  build(): HTMLElement[] {
    this.updates = [];
    return GROUPS.map((group) => {
      const attributes: Record<string, string> = group.closed ? { class: "group" } : { class: "group", open: "" };
      const box = h("details", attributes, h("summary", {}, say(group.title)));
      box.append(...group.settings.map((setting) => this.row(setting)));
      return box;
    });
  }

  /** Shows what is set. */
  update(): void {
    for (const act of this.updates) act();
  }

  /** What is wrong with what is typed, by its field; null where nothing is. */
  problem(): string | null {
    this.refuse(null);
    for (const setting of SETTINGS) {
      const cause = wrong(setting, this.state.get(setting.path));
      if (cause !== null) return `${say(setting.label)}: ${cause}`;
    }
    return null;
  }

  /** A message of the program, with the field's name in place of the setting's. */
  named(message: string): string {
    return message.replace(NAMED, (whole, name: string) => {
      const setting = SETTINGS.find(({ path }) => path === name || path.endsWith(`.${name}`));
      if (setting) this.refuse(setting);
      return setting ? say(setting.label) : whole;
    });
  }

  /** Notes the setting that the program has refused, whose field is marked. */
  private refuse(setting: Setting | null): void {
    this.refused = setting;
    this.update();
  }

  private row(setting: Setting): HTMLElement {
    const id = `set-${setting.path.replace(/\./g, "-")}`;
    const about = `${say(setting.sentence)} ${say("Default: {}.", say(setting.fallback))}`;
    const row = h("div", { class: "setting", "data-setting": setting.path });
    const described = h("span", { id: `${id}-about`, class: "unseen" }, about);
    const reset = h("button", { type: "button", class: "reset", title: say("Back to the default"), "aria-label": `${say(setting.label)}: ${say("Back to the default")}` }, "↺");
    reset.addEventListener("click", () => this.put(setting, undefined));
    row.append(this.control(setting, id), reset, described);
    for (const event of ["focusin", "pointerenter"]) row.addEventListener(event, () => this.hint(about));
    this.updates.push(() => row.classList.toggle("is-set", this.state.get(setting.path) !== undefined));
    return row;
  }

  private put(setting: Setting, value: unknown, moving = false): void {
    if (setting.path === "edge-length" && value !== undefined) this.state.set("panels", undefined);
    if (setting.path === "panels" && value !== undefined) this.state.set("edge-length", undefined);
    this.state.set(setting.path, value);
    this.update();
    if (moving) this.listener.moving();
    else this.listener.done();
  }

  private control(setting: Setting, id: string): HTMLElement {
    if (setting.choices) return this.choice(setting, setting.choices, id);
    if (setting.toggle) return this.toggle(setting, id);
    return this.number(setting, id);
  }

  private number(setting: Setting, id: string): HTMLElement {
    const box = h("div", { class: "control" });
    const field = h("input", {
      id,
      type: "text",
      inputmode: setting.text ? "text" : "decimal",
      placeholder: say(setting.fallback),
      "aria-describedby": `${id}-about`,
      autocomplete: "off",
      spellcheck: "false",
    }) as HTMLInputElement;
    field.addEventListener("change", () => this.put(setting, this.typed(setting, field.value)));
    const label = h("label", { for: id }, say(setting.label));
    const unit = h("span", { class: "unit" }, setting.unit ?? "");
    box.append(label, h("span", { class: "field" }, field, unit));
    this.updates.push(() => {
      const value = this.state.get(setting.path);
      field.placeholder = say(this.fallback(setting));
      if (document.activeElement !== field || value === undefined) field.value = value === undefined ? "" : String(value);
      field.setAttribute("aria-invalid", String(this.refused === setting || wrong(setting, value) !== null));
    });
    if (setting.slider) box.append(this.slider(setting, setting.slider));
    return box;
  }

  /** A number where one is typed that keeps all its digits; else the text as it is, and what is wrong is told of it. */
  private typed(setting: Setting, text: string): unknown {
    const clean = text.trim().replace("−", "-");
    if (clean === "") return undefined;
    const number = Number(clean);
    const kept = setting.whole ? WHOLE.test(clean) && Number.isSafeInteger(number) : Number.isFinite(number);
    return kept && !setting.text ? number : clean;
  }

  /** What holds where nothing is set. */
  private fallback(setting: Setting): string {
    const decides = setting.follows?.find(([, paths]) => paths.some((path) => this.state.get(path) !== undefined));
    return decides?.[0] ?? setting.fallback;
  }

  private slider(setting: Setting, range: NonNullable<Setting["slider"]>): HTMLElement {
    const [low, high, step] = range.logarithmic ? [0, PLACES, 1] : [range.low, range.high, range.step];
    const slider = h("input", {
      type: "range",
      min: String(low),
      max: String(high),
      step: String(step),
      "aria-label": say(setting.label),
      "data-slider": setting.path,
    }) as HTMLInputElement;
    const value = (): number => fromPlace(range, Number(slider.value), setting.whole);
    slider.addEventListener("input", () => this.put(setting, value(), true));
    slider.addEventListener("change", () => this.put(setting, value()));
    this.updates.push(() => {
      const set = this.state.get(setting.path);
      const at = typeof set === "number" ? set : (setting.rest ?? range.low);
      slider.classList.toggle("idle", set === undefined && this.fallback(setting) !== setting.fallback);
      slider.setAttribute("aria-valuetext", set === undefined ? say(this.fallback(setting)) : `${figure(at)}${setting.unit ?? ""}`);
      if (document.activeElement !== slider || set === undefined) slider.value = String(toPlace(range, at));
    });
    return slider;
  }

  private choice(setting: Setting, choices: [string, string][], id: string): HTMLElement {
    const few = choices.length <= 3;
    const label = h("label", { for: id }, say(setting.label));
    if (few) return this.buttons(setting, choices, id);
    const list = h("select", { id, "aria-describedby": `${id}-about` }) as HTMLSelectElement;
    for (const [value, name] of choices) list.append(h("option", { value }, say(name)));
    list.addEventListener("change", () => this.put(setting, list.value === setting.fallback ? undefined : list.value));
    this.updates.push(() => void (list.value = String(this.state.get(setting.path) ?? setting.fallback)));
    return h("div", { class: "control" }, label, list);
  }

  private buttons(setting: Setting, choices: [string, string][], id: string): HTMLElement {
    const group = h("div", { class: "choices", role: "radiogroup", "aria-labelledby": `${id}-label`, "aria-describedby": `${id}-about` });
    for (const [value, name] of choices) {
      const input = h("input", { type: "radio", name: id, value }) as HTMLInputElement;
      input.addEventListener("change", () => this.put(setting, value === setting.fallback ? undefined : value));
      this.updates.push(() => void (input.checked = (this.state.get(setting.path) ?? setting.fallback) === value));
      group.append(h("label", {}, input, h("span", {}, say(name))));
    }
    return h("div", { class: "control" }, h("span", { id: `${id}-label`, class: "label" }, say(setting.label)), group);
  }

  private toggle(setting: Setting, id: string): HTMLElement {
    const box = h("input", { id, type: "checkbox", "aria-describedby": `${id}-about` }) as HTMLInputElement;
    box.addEventListener("change", () => this.put(setting, box.checked ? true : undefined));
    this.updates.push(() => void (box.checked = this.state.get(setting.path) === true));
    return h("div", { class: "control" }, h("label", { for: id }, say(setting.label)), box);
  }
}
