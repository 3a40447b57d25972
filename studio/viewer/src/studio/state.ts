/** What is wanted: a surface and a job, with undo and redo; kept in the page's address. */

export type Job = Record<string, unknown>;

export interface Wanted {
  surface: string | null;
  job: Job;
}

/** Steps that can be undone. */
const STEPS = 100;

const same = (a: unknown, b: unknown): boolean => JSON.stringify(a) === JSON.stringify(b);

export class State {
  wanted: Wanted = { surface: null, job: {} };
  private past: Wanted[] = [];
  private future: Wanted[] = [];
  private kept: Wanted = structuredClone(this.wanted);
  /** What else stands in the address. */
  manner: Record<string, string> = {};

  constructor(private readonly changed: () => void) {
    this.read();
  }

  /** The value at a path of the job, such as `steering.fairness`. */
  get(path: string): unknown {
    return path.split(".").reduce<unknown>((at, name) => (at as Job | undefined)?.[name], this.wanted.job);
  }

  /** Sets a value, or takes it out; tables that become empty go too. */
  set(path: string, value: unknown): void {
    const set = (table: Job, [name, ...rest]: string[]): Job => {
      const inner = rest.length > 0 ? set((table[name] as Job | undefined) ?? {}, rest) : value;
      const { [name]: _, ...others } = table;
      const empty = inner === undefined || (rest.length > 0 && Object.keys(inner as Job).length === 0);
      return empty ? others : { ...table, [name]: inner };
    };
    this.wanted = { ...this.wanted, job: set(this.wanted.job, path.split(".")) };
  }

  /** Another surface; what stands on the old one goes. */
  take(surface: string): void {
    if (this.wanted.surface !== null && this.wanted.surface !== surface) {
      this.set("stages.directions.guides", undefined);
      this.set("stages.steering", undefined);
    }
    this.wanted = { ...this.wanted, surface };
    this.commit();
  }

  /** Makes what is wanted a step that can be undone. */
  commit(): void {
    if (!same(this.wanted, this.kept)) {
      this.past.push(this.kept);
      if (this.past.length > STEPS) this.past.shift();
      this.future = [];
      this.kept = structuredClone(this.wanted);
    }
    this.write();
    this.changed();
  }

  get canUndo(): boolean {
    // A step back to no surface leads nowhere.
    return this.past.length > 0 && this.past[this.past.length - 1].surface !== null;
  }

  get canRedo(): boolean {
    return this.future.length > 0;
  }

  undo(): boolean {
    return this.canUndo && this.step(this.past, this.future);
  }

  redo(): boolean {
    return this.canRedo && this.step(this.future, this.past);
  }

  private step(from: Wanted[], to: Wanted[]): boolean {
    to.push(this.kept);
    this.kept = from.pop()!;
    this.wanted = structuredClone(this.kept);
    this.write();
    this.changed();
    return true;
  }

  write(): void {
    const { surface, job } = this.kept;
    const words = new URLSearchParams(this.manner);
    if (surface) words.set("surface", surface);
    if (Object.keys(job).length > 0) words.set("job", JSON.stringify(job));
    history.replaceState(null, "", `#${words}`);
  }

  private read(): void {
    const words = new URLSearchParams(location.hash.slice(1));
    for (const name of ["lang", "theme"]) if (words.has(name)) this.manner[name] = words.get(name)!;
    this.wanted.surface = words.get("surface");
    try {
      const job: unknown = JSON.parse(words.get("job") ?? "{}");
      if (typeof job === "object" && job !== null && !Array.isArray(job)) this.wanted.job = job as Job;
    } catch {
      // An address that was cut off: its surface is still worth something.
    }
    this.kept = structuredClone(this.wanted);
  }
}
