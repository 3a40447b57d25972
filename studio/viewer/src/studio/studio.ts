/** The studio: a surface, what is wanted of it, and what came of it. */

import { Box3, BufferAttribute, Vector3 } from "three";
import { area, button, figure, h } from "../dom";
import { part, partsOf, sections, view, type Parts } from "../frame";
import { say, speak } from "../words";
import { GERMAN } from "./german";
import { checkList, figureList, figures, verdictMark } from "./outcome";
import { type Placed, type Theme, View } from "./scene";
import * as server from "./server";
import { Refusal, type Result, type RunFrame, type SurfaceFrame } from "./server";
import { inRows, Settings } from "./settings";
import { State, type Job } from "./state";

type Point = [number, number, number];
type Tool = "turn" | "guide" | "fix" | "pentagon" | "heptagon" | "measure";

/** A run that is remembered: what was wanted and what came of it. */
interface Remembered {
  run: number;
  surface: string;
  name: string;
  job: Job;
  picture: string;
  result: Result | null;
  verdict: Result["verdict"];
  rows: [string, string][];
}

/** Runs that are remembered, and those of them whose panels are, too: as many as the program keeps. */
const REMEMBERED = 24;
const WITH_PANELS = 4;
/** How often it is asked whether the program is still there, in milliseconds. */
const PULSE = 3000;

const TOOLS: [Tool, string, string][] = [
  ["turn", "Turn", "Turn the view, pick panels"],
  ["guide", "Guide", "Draw a line that rows of panels run along: click its points, Enter ends it"],
  ["fix", "Fixed point", "Click a point that a corner of a panel is to have"],
  ["pentagon", "Pentagon", "Click where a pentagon is to be"],
  ["heptagon", "Heptagon", "Click where a heptagon is to be"],
  ["measure", "Measure", "Click two points to measure their distance"],
];

const STAGES: Record<string, string> = {
  target: "Smoothing the surface",
  symmetry: "Looking for mirror planes",
  curvature: "Measuring curvature",
  directions: "Finding directions",
  layout: "Laying out panels",
  optimise: "Making panels planar",
  trim: "Trimming at the boundary",
  search: "Searching for better panels",
  repetition: "Making edges equal",
  validate: "Judging",
  subdivision: "Refining panels",
  koebe: "Packing circles",
  parallel: "Fitting a parallel mesh",
  angles: "Turning panels at corners",
};

/** Lengths of the units in metres. */
const METRES: Record<string, number> = { m: 1, cm: 1e-2, mm: 1e-3, ft: 0.3048, in: 0.0254 };

export class Studio {
  readonly view: View;
  readonly state: State;
  result: Result | null = null;
  private readonly parts: Parts;
  private readonly settings: Settings;
  private surface: SurfaceFrame | null = null;
  private samples: [string, string][] = [];
  private tool: Tool = "turn";
  private drawn: Point[] = [];
  private measured: Point[] = [];
  private history: Remembered[] = [];
  private beside: Remembered[] = [];
  private others: View[] = [];
  private running: AbortController | null = null;
  /** Whether something else is wanted by now than the result that is shown. */
  private stale = false;
  private previewing = false;
  private previewWanted = false;
  private theme: Theme = "light";
  /** Times in milliseconds, for tests: of the last change to a lattice, of its end to planar panels and to a verdict. */
  times: { released: number; lattice?: number; planar?: number; verdict?: number } = { released: 0 };
  private changedAt = 0;

  constructor(private readonly root: HTMLElement) {
    this.state = new State(() => this.refresh());
    this.language(this.state.manner.lang ?? (navigator.language.startsWith("de") ? "de" : "en"));
    this.settings = new Settings(
      this.state,
      { moving: () => this.moving(), done: () => this.done() },
      (text) => void (this.parts("hint").textContent = text),
    );
    this.root.replaceChildren(part("bar", "header"), part("main"), part("announce"));
    this.parts = partsOf(this.root);
    const announce = this.parts("announce");
    announce.className = "unseen";
    announce.setAttribute("role", "status");
    announce.setAttribute("aria-live", "polite");
    this.buildMain();
    this.view = new View(this.parts);
    this.view.stage.renderer.domElement.setAttribute("role", "img");
    this.chooseTheme((this.state.manner.theme as Theme | undefined) ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light"));
    this.fill();
    this.listen();
    void this.open();
  }

  // What is on the page.

  private buildMain(): void {
    const left = h("aside", { class: "wishes", "aria-label": say("Settings") }, part("surface-facts"), part("groups"), part("set-on-surface"), part("hint"));
    const middle = view();
    middle.append(part("tools"), part("welcome"), part("status"), part("measured"));
    const making = part("making", "p");
    making.hidden = true;
    const right = h("aside", { class: "results", "aria-label": say("Result") }, part("outcome"), part("view-sections"), making, part("files"), part("history"));
    const others = part("others");
    others.hidden = true;
    this.parts("main").replaceChildren(left, h("div", { class: "stage-area" }, middle, others), right);
    this.parts("view-sections").append(...sections());
  }

  /** Writes every text anew; the view and the result stay. */
  private fill(): void {
    this.buildBar();
    this.view.stage.renderer.domElement.setAttribute("aria-label", say("The model"));
    this.parts("groups").replaceChildren(...this.settings.build());
    this.showEmpty();
    this.buildTools();
    this.buildWelcome();
    this.showHint();
    this.refresh();
    this.showOutcome();
    this.showHistory();
  }

  private buildBar(): void {
    const tool = (label: string, title: string, name: string, act: () => void): HTMLElement => {
      const element = button(label, title, act);
      element.dataset.act = name;
      element.setAttribute("aria-label", title);
      return element;
    };
    const open = tool(say("Open …"), say("Open a surface or a job file"), "open", () => this.chooseFile());
    this.parts("bar").replaceChildren(
      h("span", { class: "brand" }, "phex", h("span", {}, " studio")),
      h("span", { class: "file", "data-part": "file-name" }),
      open,
      h("span", { class: "spring" }),
      tool("↶", say("Undo (Ctrl+Z)"), "undo", () => void this.step("undo")),
      tool("↷", say("Redo (Ctrl+Shift+Z)"), "redo", () => void this.step("redo")),
      tool(say("Deutsch"), say("Deutsch"), "language", () => this.changeLanguage()),
      tool(this.theme === "dark" ? "☀" : "☾", say(this.theme === "dark" ? "Light" : "Dark"), "theme", () => this.chooseTheme(this.theme === "dark" ? "light" : "dark", true)),
    );
  }

  private buildTools(): void {
    const tools = TOOLS.map(([tool, label, title]) => {
      const choose = button(say(label), say(title), () => this.choose(tool));
      choose.dataset.tool = tool;
      return choose;
    });
    const axis = h("select", { "aria-label": say("Section"), title: say("Cut the model open"), "data-section": "axis" }) as HTMLSelectElement;
    for (const [value, label] of [["", "No section"], ["x", "Section in x"], ["y", "Section in y"], ["z", "Section in z"]]) axis.append(h("option", { value }, say(label)));
    const share = h("input", { type: "range", min: "0", max: "1", step: "0.005", value: "0.5", "aria-label": say("Place of the section"), hidden: "" }) as HTMLInputElement;
    const cut = (): void => {
      share.hidden = axis.value === "";
      this.view?.cut((axis.value || null) as "x" | "y" | "z" | null, Number(share.value));
    };
    axis.addEventListener("change", cut);
    share.addEventListener("input", cut);
    this.parts("tools").replaceChildren(h("div", { class: "toolbar", role: "toolbar", "aria-label": say("Tools") }, ...tools), axis, share);
    this.choose(this.tool);
  }

  private buildWelcome(): void {
    const welcome = this.parts("welcome");
    const open = button(say("Choose a file"), say("Open a surface or a job file"), () => this.chooseFile());
    open.className = "primary";
    const list = this.samples.map(([name, summary]) => {
      const choose = button(name, summary, () => void this.openSample(name));
      choose.dataset.sample = name;
      choose.append(h("small", {}, summary));
      return choose;
    });
    welcome.replaceChildren(
      h("div", { class: "drop" }, h("h1", {}, say("Drop a surface here")), h("p", {}, say("OBJ, PLY, STL or OFF, up to 256 MB. It stays on this machine.")), open),
      h("h2", {}, say("Or begin with a sample")),
      h("div", { class: "samples" }, ...list),
    );
  }

  /** Before there is a surface there is nothing but the welcome. */
  private showEmpty(): void {
    const empty = this.surface === null;
    this.parts("main").toggleAttribute("data-empty", empty);
    this.parts("welcome").hidden = !empty;
    // What lies below the welcome is out of reach of the keyboard, too.
    for (const name of ["canvas", "views", "tools"]) this.parts(name).inert = empty;
  }

  private showHint(): void {
    this.parts("hint").textContent = this.surface ? say("Point at a setting to read what it does.") : "";
  }

  private showFacts(): void {
    const box = this.parts("surface-facts");
    const { surface } = this;
    if (!surface) return box.replaceChildren(h("h2", {}, say("Surface")), h("p", { class: "none" }, say("None yet: drop a file anywhere.")));
    const { info } = surface;
    const part = info.components[0];
    const unit = String(this.state.get("unit") ?? "m");
    const size = info.bounding_box[1].map((x, k) => figure(x - info.bounding_box[0][k])).join(" × ");
    const rows: [string, string][] = [
      ["Size", `${size} ${unit}`],
      ["Faces", String(info.faces)],
    ];
    if (info.area !== null) rows.push(["Area", area(info.area, unit)]);
    if (info.components.length > 1) rows.push(["Parts", String(info.components.length)]);
    else if (part) rows.push(["Boundary", part.boundary_loops === 0 ? say("closed") : part.boundary_loops === 1 ? say("one loop") : say("{} loops", part.boundary_loops)], ["Handles", String(part.genus)]);
    const metres = info.diagonal * METRES[unit];
    const doubt = metres > 0 && (metres < 0.01 || metres > 2000) ? [h("p", { class: "problem" }, say("The model is {} m across: is its unit right?", figure(metres)))] : [];
    const problem = info.problem === null ? [] : [h("p", { class: "problem", role: "alert" }, h("b", {}, say("This is no surface")), ` ${info.problem}`)];
    const notes = info.notes.map((note) => h("p", { class: "none" }, note));
    box.replaceChildren(h("h2", {}, say("Surface")), h("p", { class: "name" }, surface.name), figureList(rows), ...doubt, ...problem, ...notes);
  }

  /** Shows what is set, and what can be undone. */
  private refresh(): void {
    if (!this.view) return;
    this.settings.update();
    this.showFacts();
    this.showPlaced();
    this.act("undo").disabled = !this.state.canUndo;
    this.act("redo").disabled = !this.state.canRedo;
    this.parts("file-name").textContent = this.surface?.name ?? "";
  }

  private act(name: string): HTMLButtonElement {
    return this.root.querySelector<HTMLButtonElement>(`[data-act="${name}"]`)!;
  }

  // Surfaces.

  private async open(): Promise<void> {
    await this.attempt(async () => {
      this.samples = await server.samples();
      this.buildWelcome();
      const { surface } = this.state.wanted;
      if (surface) await this.openSurface(() => server.surface(surface));
    });
  }

  private chooseFile(): void {
    const input = h("input", { type: "file", multiple: "", accept: ".obj,.ply,.stl,.off,.toml" }) as HTMLInputElement;
    input.addEventListener("change", () => void this.openFiles([...(input.files ?? [])]));
    input.click();
  }

  /** Opens a surface, and then a job file for it; which of more files are left out is told. */
  async openFiles(files: File[]): Promise<void> {
    const isJob = (file: File): boolean => file.name.toLowerCase().endsWith(".toml");
    const [job, surface] = [files.find(isJob), files.find((file) => !isJob(file))];
    if (surface) {
      this.stop();
      this.say(say("Reading {} …", surface.name));
      if (!(await this.openSurface(() => server.dropFile(surface)))) return;
    }
    if (job) await this.openJob(job);
    const others = files.filter((file) => file !== surface && file !== job);
    if (others.length === 0) return;
    const told = say("Not opened: {}. One surface and one job file are opened at a time.", others.map((file) => file.name).join(", "));
    if (!this.surface) return this.say(told, "problem");
    this.surface.info.notes.push(told);
    this.showFacts();
  }

  /** Shows a surface once it is read, unless another one was asked for meanwhile; whether it did. */
  private async openSurface(read: () => Promise<SurfaceFrame>): Promise<boolean> {
    const opening = (this.opening = {});
    const isWanted = (): boolean => opening === this.opening;
    const open = async (): Promise<boolean> => {
      const frame = await read();
      if (isWanted()) this.shown(frame);
      return isWanted();
    };
    return (await this.attempt(open, isWanted)) ?? false;
  }

  /** What the last surface that was asked for is known by. */
  private opening = {};

  private async openJob(file: File): Promise<void> {
    await this.attempt(async () => {
      const job = await server.readJob(await file.text());
      this.state.wanted = { ...this.state.wanted, job };
      this.done();
    });
  }

  private async openSample(name: string): Promise<void> {
    await this.openSurface(() => server.dropSample(name));
  }

  private shown(frame: SurfaceFrame): void {
    this.surface = frame;
    this.result = null;
    this.drawn = [];
    this.showEmpty();
    this.view.showSurface(frame);
    this.state.take(frame.id);
    this.showHint();
    this.showOutcome();
    this.say(frame.info.problem === null ? "" : say("This is no surface"), "problem");
    if (frame.info.problem === null) this.done();
  }

  // Runs.

  /** A slider moves. */
  private moving(): void {
    this.change();
    this.outdate(true);
    this.running?.abort();
    this.running = null;
    this.previewWanted = true;
    if (!this.previewing) void this.previews();
  }

  /** Lays out one lattice after the other as long as something moves: always what is wanted last. */
  private async previews(): Promise<void> {
    this.previewing = true;
    while (this.previewWanted) {
      this.previewWanted = false;
      const stop = new AbortController();
      this.previewStop = stop;
      try {
        for await (const told of server.run(this.wish("layout"), stop.signal)) {
          if (stop.signal.aborted) break;
          if (told.kind === "mesh") this.preview(told);
          // Methods by planes have no lattice to show, and what is not yet right is told on release.
        }
      } catch (error) {
        if (error instanceof Refusal && error.isGone) this.failed(error);
      }
    }
    this.previewing = false;
  }

  private previewStop: AbortController | null = null;

  /** Something is about to be different. */
  private change(): void {
    if (this.changedAt !== 0) return;
    this.changedAt = performance.now();
    this.times = { released: this.changedAt };
  }

  /** A change is done. */
  private done(): void {
    this.change();
    this.state.commit();
    this.begin();
  }

  private wish(until: "layout" | null): object {
    const { surface, job } = this.state.wanted;
    // A lattice to look at is one, and not the best of several.
    return { surface, job: until ? { ...job, effort: "draft" } : job, until };
  }

  /** Begins a run of what is wanted. */
  private begin(): void {
    if (!this.surface || this.surface.info.problem !== null) return;
    this.previewWanted = false;
    this.previewStop?.abort();
    this.running?.abort();
    this.running = null;
    this.outdate(true);
    const problem = this.settings.problem();
    if (problem !== null) {
      this.changedAt = 0;
      return this.say(problem, "problem");
    }
    const stop = new AbortController();
    this.running = stop;
    this.times.released = performance.now();
    this.say(say("Beginning …"), "running");
    void this.attemptRun(stop);
  }

  /** Notes whether the result that is shown is of earlier wishes, and says so at its files. */
  private outdate(stale: boolean): void {
    this.stale = stale;
    for (const name of ["outcome", "files"]) this.parts(name).toggleAttribute("data-stale", stale && this.result !== null);
  }

  private async follow(stop: AbortController): Promise<void> {
    let ended = false;
    for await (const told of server.run(this.wish(null), stop.signal)) {
      if (stop.signal.aborted) return;
      ended = this.heard(told) || ended;
    }
    if (!ended && !stop.signal.aborted) throw new Refusal(0, "the program does not answer");
  }

  /** Takes what is told of the run; whether that was the last of it. */
  private heard(told: RunFrame): boolean {
    switch (told.kind) {
      case "begun":
        return false;
      case "progress":
        this.progress(told.stage, told.whole);
        return false;
      case "mesh":
        this.preview(told);
        return false;
      case "cancelled":
        this.running = null;
        this.say(say("Stopped: another page has begun a run."), "stopped");
        return true;
      case "failed":
        this.running = null;
        this.say(this.settings.named(told.message), "problem");
        return true;
      case "result":
        this.running = null;
        this.take(told);
        return true;
    }
  }

  private preview(told: Extract<RunFrame, { kind: "mesh" }>): void {
    const now = performance.now();
    if (told.stage === "layout") this.times.lattice ??= now - this.changedAt;
    else if (this.running) this.times.planar ??= now - this.times.released;
    this.result = null;
    this.view.showPanels(told.mesh);
    this.showOutcome();
    if (!this.running) this.say(say("not planar yet"), "preview");
  }

  private progress(stage: string, whole: { done: number; left_seconds: number }): void {
    const percent = Math.round(100 * whole.done);
    const left = say("about {} s left", Math.max(1, Math.round(whole.left_seconds)));
    this.tell(`${say(STAGES[stage] ?? stage)} · ${percent} % · ${left}`, "running", whole.done);
  }

  /** Tells of a run that goes well, unless there is a problem that nobody has closed yet. */
  private tell(text: string, kind: string, share: number | null = null): void {
    if (this.parts("status").dataset.kind !== "problem") this.say(text, kind, share);
  }

  private take(result: Result): void {
    this.times.verdict = performance.now() - this.times.released;
    this.changedAt = 0;
    this.result = result;
    this.stale = false;
    this.view.showResult(result.view);
    this.tell("", "");
    this.announce(say(result.verdict === "pass" ? "Pass" : result.verdict === "invalid" ? "Invalid" : "Outside tolerance"));
    this.showOutcome();
    requestAnimationFrame(() => requestAnimationFrame(() => this.remember(result)));
  }

  /** Ends the run there is. */
  stop(): void {
    this.previewWanted = false;
    this.previewStop?.abort();
    if (!this.running) return;
    this.running.abort();
    this.running = null;
    this.changedAt = 0;
    this.say(say("Stopped"), "stopped");
  }

  private async step(which: "undo" | "redo"): Promise<void> {
    const before = this.state.wanted.surface;
    if (!this.state[which]()) return;
    const { surface } = this.state.wanted;
    if (surface === null || surface === before) return this.begin();
    if (await this.openSurface(() => server.surface(surface))) return;
    // The program keeps the last few surfaces alone: what is shown stays what is wanted.
    if (this.state.wanted.surface === surface) this.state[which === "undo" ? "redo" : "undo"]();
  }

  /** Does something, and tells what goes wrong while somebody waits for it. */
  private async attempt<T>(act: () => Promise<T>, isWanted = (): boolean => true): Promise<T | null> {
    try {
      return await act();
    } catch (error) {
      if (isWanted()) this.failed(error);
      return null;
    }
  }

  private async attemptRun(stop: AbortController): Promise<void> {
    try {
      await this.follow(stop);
    } catch (error) {
      if (stop.signal.aborted) return;
      // What goes wrong beside a run does not end it.
      this.running = null;
      this.changedAt = 0;
      this.failed(error, true);
    }
  }

  private failed(error: unknown, ofRun = false): void {
    const gone = error instanceof Refusal && error.isGone;
    const text = gone ? say("The program has ended. Start phex studio again; what is shown stays.") : error instanceof Error ? error.message : String(error);
    this.say(ofRun && !gone ? this.settings.named(text) : text, gone ? "gone" : "problem");
  }

  /** The line over the view: what happens, what went wrong. */
  private say(text: string, kind = "", share: number | null = null): void {
    const box = this.parts("status");
    box.hidden = text === "";
    box.dataset.kind = kind;
    const line = h("span", { class: "text" }, text);
    const bar = h("span", { class: "progress", role: "progressbar", "aria-label": say("Progress") }, h("i", {}));
    if (share !== null) {
      bar.setAttribute("aria-valuenow", String(Math.round(100 * share)));
      (bar.firstElementChild as HTMLElement).style.width = `${100 * share}%`;
    }
    const cancel = button(say("Stop"), say("Stop the run (Escape)"), () => this.stop());
    cancel.dataset.act = "stop";
    const again = button(say("Run again"), say("Run again"), () => this.done());
    again.dataset.act = "again";
    const close = button("✕", say("Close"), () => this.say(""));
    close.setAttribute("aria-label", say("Close"));
    close.dataset.act = "close";
    const more = kind === "running" ? [bar, cancel] : kind === "stopped" ? [again] : kind === "problem" ? [close] : [];
    const mark = this.view && (kind === "running" || kind === "preview") && this.view.previewed > 0 ? [h("b", { class: "preview-mark" }, say("Preview, not checked"))] : [];
    // The button under the pointer stays in its place while the text beside it changes: a press on
    // one that is taken out and put back before the pointer is up is no click.
    const stays = kind === "running" ? box.querySelector<HTMLElement>('[data-act="stop"]') : null;
    if (stays) {
      for (const other of [...box.children]) if (other !== stays) other.remove();
      stays.before(...mark, line, bar);
    } else box.replaceChildren(...mark, line, ...more);
    if (kind === "problem" || kind === "gone") this.announce(text);
  }

  private announce(text: string): void {
    this.parts("announce").textContent = text;
  }

  // What came of it.

  private showOutcome(): void {
    const { result } = this;
    const box = this.parts("outcome");
    this.outdate(this.stale);
    this.parts("view-sections").hidden = result === null;
    this.parts("legend").hidden = result === null;
    this.parts("compare").hidden = result === null;
    this.showFiles();
    if (!result) {
      const shown = this.view && this.view.previewed > 0;
      const mark = h("span", { class: "verdict none-yet" }, say(shown ? "Preview, not checked" : "No result yet"));
      return box.replaceChildren(h("h2", {}, say("Result")), mark, ...(shown ? [figureList([["Panels", String(this.view.previewed)]])] : []));
    }
    const notes = result.notes.map((note) => h("p", {}, inRows(note)));
    const more = notes.length > 0 ? [h("details", { class: "notes" }, h("summary", {}, notes.length === 1 ? say("one note") : say("{} notes", notes.length)), ...notes)] : [];
    box.replaceChildren(
      h("h2", {}, say("Result")),
      verdictMark(result.verdict),
      figureList(figures(result)),
      h("h2", {}, say("Checks")),
      checkList(result, (face) => this.view.app?.visit(face)),
      ...more,
    );
  }

  private showFiles(): void {
    const box = this.parts("files");
    const { result } = this;
    if (!result) return box.replaceChildren();
    const address = (file: string): string => `result/${result.run}/${file}`;
    const save = (label: string, file: string, title = label): HTMLElement => {
      const element = button(label, title, () => void this.save(address(file)));
      element.dataset.file = file;
      return element;
    };
    const meshes = result.formats.map((format) => save(format.toUpperCase(), `mesh.${format}`, say("The mesh as {}", format.toUpperCase())));
    const files = [
      save(say("Report"), "report.html", say("The report as one HTML file")),
      save("PNG", "picture.png", say("A picture")),
      save("SVG", "picture.svg", say("A picture as vectors")),
      save(say("Figures"), "report.json", say("All figures as JSON")),
      save(say("Job file"), "job.toml", say("The settings, for phex mesh --config")),
    ];
    const command = h("textarea", { class: "command", readonly: "", rows: "3", "aria-label": say("Command line that repeats the run"), "data-part": "command" }) as HTMLTextAreaElement;
    command.value = result.command;
    const copy = button(say("Copy"), say("Copy the command line"), () => {
      command.select();
      void navigator.clipboard?.writeText(command.value).catch(() => document.execCommand("copy"));
    });
    copy.dataset.act = "copy";
    const block = (title: string, ...inside: Node[]): HTMLElement => h("section", {}, h("h2", {}, say(title)), ...inside);
    box.replaceChildren(
      h("p", { class: "earlier" }, say("These files are of the run before: what is set now has no result.")),
      block("Mesh files", h("div", { class: "files-row" }, ...meshes)),
      block("Other files", h("div", { class: "files-row" }, ...files)),
      block("Workshop", this.workshop(address("workshop.zip"))),
      block("Command line", command, copy),
    );
  }

  /** What was typed for the workshop, which every result and language asks for anew. */
  private readonly workshopWords: Record<string, string> = { thickness: "50mm", gap: "0mm", sheet: "1250x2500" };

  /** What the workshop needs to know. */
  private workshop(address: string): HTMLElement {
    const words = this.workshopWords;
    const field = (label: string, name: string): HTMLElement => {
      const input = h("input", { name, value: words[name], autocomplete: "off" }) as HTMLInputElement;
      input.addEventListener("input", () => void (words[name] = input.value));
      return h("label", {}, say(label), input);
    };
    const form = h("form", { class: "workshop" }, field("Thickness", "thickness"), field("Joint", "gap"), field("Sheet", "sheet")) as HTMLFormElement;
    const send = h("button", { type: "submit", class: "primary", "data-file": "workshop.zip" }, say("Workshop files (zip)"));
    form.append(send);
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      // An empty field says nothing, as an option that is left out.
      const said = Object.entries(words).filter(([, value]) => value.trim() !== "");
      void this.save(`${address}?${new URLSearchParams(said)}`);
    });
    return form;
  }

  /** Saves a file of a result; that it is being made stands beside the files, whatever a run tells meanwhile. */
  private async save(address: string): Promise<void> {
    this.making(1);
    await this.attempt(async () => {
      const { name, blob } = await server.download(address);
      const link = h("a", { href: URL.createObjectURL(blob), download: name }) as HTMLAnchorElement;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
    });
    this.making(-1);
  }

  /** Number of files that are being made. */
  private filesInMaking = 0;

  private making(more: number): void {
    this.filesInMaking += more;
    const line = this.parts("making");
    line.hidden = this.filesInMaking === 0;
    line.textContent = line.hidden ? "" : say("Making the file …");
    if (more > 0) this.announce(say("Making the file …"));
  }

  // Runs that were.

  private remember(result: Result): void {
    if (this.result !== result || !this.surface) return;
    const entry: Remembered = {
      run: result.run,
      surface: this.surface.id,
      name: this.surface.name,
      job: structuredClone(this.state.wanted.job),
      picture: this.view.thumbnail(144, 90),
      result,
      verdict: result.verdict,
      rows: figures(result),
    };
    this.history.unshift(entry);
    this.history.length = Math.min(this.history.length, REMEMBERED);
    this.history.slice(WITH_PANELS).forEach((old) => void (old.result = null));
    this.showHistory();
  }

  private showHistory(): void {
    const box = this.parts("history");
    if (this.history.length === 0) return box.replaceChildren();
    const entries = this.history.map((entry) => {
      const open = button("", say("Go back to this run"), () => this.recall(entry));
      open.className = "run";
      open.dataset.run = String(entry.run);
      open.append(h("img", { src: entry.picture, alt: "" }), h("span", {}, h("b", {}, `${entry.rows[0][1]} · ${entry.name}`), h("small", {}, this.brief(entry))));
      const mark = h("input", { type: "checkbox", "aria-label": say("Compare run {}", entry.run), "data-compare-run": String(entry.run) }) as HTMLInputElement;
      mark.checked = this.beside.includes(entry);
      mark.disabled = entry.result === null;
      mark.addEventListener("change", () => this.mark(entry, mark.checked));
      return h("li", { "data-verdict": entry.verdict }, open, h("label", { title: say("Compare") }, mark));
    });
    box.replaceChildren(h("section", {}, h("h2", {}, say("Runs")), h("p", { class: "none" }, say("Tick two to see them side by side.")), h("ol", { class: "runs" }, ...entries)));
  }

  /** What is set, in short. */
  private brief(entry: Remembered): string {
    const words = Object.entries(entry.job).filter(([, value]) => typeof value !== "object");
    const said = words.map(([name, value]) => `${name} ${value}`);
    const tables = Object.entries(entry.job).filter(([, value]) => typeof value === "object");
    said.push(...tables.map(([name]) => say(name === "stages" || name === "guides" ? "with lines and points" : name === "limits" ? "with limits" : "with dials")));
    return said.join(", ") || say("defaults");
  }

  private recall(entry: Remembered): void {
    this.stop();
    const back = async (): Promise<void> => {
      if (this.surface?.id !== entry.surface) {
        const frame = await server.surface(entry.surface);
        this.surface = frame;
        this.view.showSurface(frame);
      }
      this.state.wanted = { surface: entry.surface, job: structuredClone(entry.job) };
      this.state.commit();
      if (!entry.result) return this.begin();
      this.result = entry.result;
      this.stale = false;
      this.view.showResult(entry.result.view);
      this.say("");
      this.showOutcome();
    };
    void this.attempt(back);
  }

  private mark(entry: Remembered, on: boolean): void {
    this.beside = on ? [...this.beside, entry].slice(-2) : this.beside.filter((e) => e !== entry);
    this.showHistory();
    this.showBeside();
  }

  /** Two runs side by side, which turn together. */
  private showBeside(): void {
    const box = this.parts("others");
    for (const other of this.others) other.dispose();
    this.others = [];
    box.replaceChildren();
    const two = this.beside.filter((entry) => entry.result !== null);
    box.hidden = two.length < 2;
    if (two.length < 2) return;
    const panes = two.map((entry) => {
      const pane = h("div", { class: "pane" }, h("div", { class: "pane-view" }, view()), h("div", { class: "pane-facts" }, verdictMark(entry.verdict), h("small", {}, this.brief(entry)), figureList(entry.rows.slice(0, 5))));
      // A view wants parts that the panes do not show.
      pane.append(h("div", { hidden: "" }, ...sections()));
      return pane;
    });
    const close = button(say("Back to one"), say("Back to one"), () => {
      this.beside = [];
      this.showHistory();
      this.showBeside();
    });
    close.className = "close";
    close.dataset.act = "one";
    box.append(...panes, close);
    this.others = panes.map((pane) => new View(partsOf(pane)));
    this.others.forEach((other, k) => {
      other.setTheme(this.theme);
      const packed = two[k].result!.view;
      const app = other.showResult(packed);
      const extent = new Box3().setFromBufferAttribute(new BufferAttribute(app.mesh.positions, 3));
      other.stage.setExtent(extent);
      other.stage.look([app.mesh.positions], this.view.stage.direction(), false);
    });
    const [a, b] = this.others;
    a.stage.follow(b.stage);
    b.stage.follow(a.stage);
  }

  // What is set on the surface.

  private get placed(): Placed {
    return {
      lines: (this.state.get("stages.directions.guides.lines") as Point[][] | undefined) ?? [],
      cones: (this.state.get("stages.directions.guides.cones") as Placed["cones"] | undefined) ?? [],
      points: (this.state.get("stages.steering.fixed_points") as Point[] | undefined) ?? [],
    };
  }

  private place(path: string, list: unknown[]): void {
    this.state.set(path, list.length > 0 ? list : undefined);
    this.done();
  }

  private showPlaced(): void {
    const { placed } = this;
    this.view.showPlaced(placed, [...this.drawn, ...this.measured]);
    const kinds: [string, string, unknown[]][] = [
      ["stages.directions.guides.lines", "Guide", placed.lines],
      ["stages.steering.fixed_points", "Fixed point", placed.points],
      ["stages.directions.guides.cones", "Cone", placed.cones],
    ];
    const entries = kinds.flatMap(([path, label, list]) =>
      list.map((item, k) => {
        const cone = (item as { index?: number }).index;
        const name = cone === undefined ? label : cone > 0 ? "Pentagon" : "Heptagon";
        const remove = button("✕", say("Remove"), () => this.place(path, list.filter((_, i) => i !== k)));
        remove.setAttribute("aria-label", `${say("Remove")}: ${say(name)} ${k + 1}`);
        return h("li", {}, h("span", {}, `${say(name)} ${k + 1}`), remove);
      }),
    );
    const box = this.parts("set-on-surface");
    box.hidden = entries.length === 0;
    box.replaceChildren(h("h2", {}, say("Set on the surface")), h("ul", { class: "placed" }, ...entries));
  }

  private choose(tool: Tool): void {
    if (this.tool !== tool) this.finishLine(false);
    this.tool = tool;
    this.measured = [];
    for (const choose of this.parts("tools").querySelectorAll<HTMLElement>("[data-tool]")) {
      choose.setAttribute("aria-pressed", String(choose.dataset.tool === tool));
    }
    const said = this.parts("measured");
    said.hidden = tool === "turn";
    said.textContent = tool === "turn" ? "" : say(TOOLS.find(([name]) => name === tool)![2]);
    if (!this.view) return;
    this.view.onClick = tool === "turn" ? null : (at) => this.clicked(at);
    this.showPlaced();
  }

  private clicked(at: Point): void {
    const { placed } = this;
    switch (this.tool) {
      case "guide":
        this.drawn.push(at);
        return this.showPlaced();
      case "fix":
        return this.place("stages.steering.fixed_points", [...placed.points, at]);
      case "pentagon":
      case "heptagon":
        return this.place("stages.directions.guides.cones", [...placed.cones, { position: at, index: this.tool === "pentagon" ? 1 : -1 }]);
      case "measure": {
        this.measured = this.measured.length === 2 ? [at] : [...this.measured, at];
        const [a, b] = this.measured;
        if (b) this.parts("measured").textContent = say("Distance: {} {}", figure(new Vector3(...a).distanceTo(new Vector3(...b))), String(this.state.get("unit") ?? "m"));
        return this.showPlaced();
      }
    }
  }

  /** Ends the line that is being drawn: it counts with two points or more. */
  private finishLine(counts: boolean): void {
    const line = this.drawn;
    this.drawn = [];
    if (counts && line.length > 1) this.place("stages.directions.guides.lines", [...this.placed.lines, line]);
    else if (line.length > 0) this.showPlaced();
  }

  // The page's manners.

  private language(lang: string): void {
    this.state.manner.lang = lang;
    document.documentElement.lang = lang;
    speak(lang === "de" ? GERMAN : null);
  }

  private changeLanguage(): void {
    this.language(this.state.manner.lang === "de" ? "en" : "de");
    this.state.write();
    this.parts("view-sections").replaceChildren(...sections());
    this.parts("views").replaceChildren();
    this.fill();
    if (this.result) this.view.showResult(this.result.view);
    else if (this.surface) this.view.buildViews();
  }

  private chooseTheme(theme: Theme, told = false): void {
    this.theme = theme;
    document.documentElement.dataset.theme = theme;
    if (told) {
      this.state.manner.theme = theme;
      this.state.write();
      this.buildBar();
      this.refresh();
    }
    this.view.setTheme(theme);
    for (const other of this.others) other.setTheme(theme);
  }

  private listen(): void {
    document.addEventListener("dragover", (event) => {
      event.preventDefault();
      document.documentElement.dataset.dragging = "";
    });
    for (const name of ["dragleave", "drop"]) document.addEventListener(name, () => void delete document.documentElement.dataset.dragging);
    document.addEventListener("drop", (event) => {
      event.preventDefault();
      void this.openFiles([...(event.dataTransfer?.files ?? [])]);
    });
    document.addEventListener("keydown", (event) => this.key(event));
    window.addEventListener("pagehide", () => this.stop());
    setInterval(() => void this.pulse(), PULSE);
  }

  private key(event: KeyboardEvent): void {
    const typing = event.target instanceof HTMLInputElement && event.target.type === "text";
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z" && !typing) {
      event.preventDefault();
      void this.step(event.shiftKey ? "redo" : "undo");
    }
    if (event.key === "Escape") {
      if (this.drawn.length > 0) this.finishLine(false);
      else this.stop();
    }
    if (event.key === "Enter" && this.drawn.length > 0) this.finishLine(true);
  }

  /** Asks whether the program is still there; it is told once. */
  private async pulse(): Promise<void> {
    if (document.hidden || this.running) return;
    const gone = this.parts("status").dataset.kind === "gone";
    try {
      await server.status();
      if (gone) this.say("");
    } catch (error) {
      if (!gone) this.failed(error);
    }
  }
}

