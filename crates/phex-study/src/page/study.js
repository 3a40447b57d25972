// @ts-check
// The page of a study. Data: columns, rows (a cell for each column), thumbnails (PNG, base64, or null), pages (whether a
// variant has its HTML report). Everything is drawn from `chosen`, the rows inside all ranges.
"use strict";
{
  /** @typedef {string | number | boolean | null} Cell */
  /** @type {{ columns: string[], rows: Cell[][], thumbnails: (string | null)[], pages: boolean[] }} */
  const study = JSON.parse(element("study").textContent ?? "");
  const SHOWN = 120;
  const KEY = study.columns.indexOf("key");
  const STATUS = study.columns.indexOf("out:status");
  const MARK = "#d5481f", FRONT = "#1f7ad5", REST = "#8883";
  /** Figures of which more is better; of all others less is. */
  const MORE = new Set(["out:clearance", "out:hexagons", "out:least-angle", "out:sheet-use"]);
  const UNIT = study.columns.indexOf("in:unit");
  const lengths = new Set(study.rows.map((row) => UNIT < 0 ? "m" : String(row[UNIT] ?? "m")));
  /** Units of figures; of lengths that of the models, if all have one. @type {Record<string, string>} */
  const UNITS = {
    "in:rotate": "°",
    "out:clearance": "mean edges",
    "out:deviation": "%",
    "out:hexagons": "%",
    "out:least-angle": "°",
    "out:mean-edge": lengths.size === 1 ? [...lengths][0] : "model units",
    "out:planarity": "mean edges",
    "out:sheet-use": "%",
  };
  /** Columns that are no axis. */
  const NO_AXIS = new Set(["img", "threeD", "key", "out:mesh", "out:reason", "out:exit"]);

  /** @param {string} id @returns {any} */
  function element(id) {
    return document.getElementById(id);
  }

  /** A column that varies: where each row lies on its axis, from 0 to 1, and what stands at its ends and steps.
   * @param {number} column */
  function axis(column) {
    const cells = study.rows.map((row) => row[column]);
    const there = cells.filter((c) => c !== null);
    const distinct = [...new Set(there)];
    if (distinct.length < 2) return null;
    const numeric = there.every((c) => typeof c === "number");
    const name = study.columns[column];
    if (numeric) {
      let low = Infinity, high = -Infinity;
      for (const c of /** @type {number[]} */ (there)) { low = Math.min(low, c); high = Math.max(high, c); }
      const at = Float64Array.from(cells, (c) => c === null ? NaN : (Number(c) - low) / (high - low));
      const ticks = [0, 0.25, 0.5, 0.75, 1].map((t) => ({ at: t, text: figure(low + t * (high - low)) }));
      return { column, name, numeric, at, ticks };
    }
    const words = distinct.map(String).sort();
    const last = Math.max(words.length - 1, 1);
    const place = new Map(words.map((word, k) => [word, k / last]));
    const at = Float64Array.from(cells, (c) => c === null ? NaN : place.get(String(c)) ?? NaN);
    const step = Math.ceil(words.length / 12);
    const ticks = words.map((text, k) => ({ at: k / last, text })).filter((_, k) => k % step === 0);
    return { column, name, numeric, at, ticks };
  }

  /** @param {Cell} value */
  function figure(value) {
    if (typeof value !== "number" || Number.isInteger(value)) return String(value ?? "");
    return String(Number(value.toPrecision(4)));
  }

  /** @param {string} name */
  const short = (name) => name.replace(/^in:/, "in ").replace(/^out:/, "") + (UNITS[name] ? `, ${UNITS[name]}` : "");
  const all = study.columns.map((name, k) => NO_AXIS.has(name) ? null : axis(k));
  const axes = all.filter((a) => a !== null);
  const numeric = axes.filter((a) => a.numeric);
  /** Ranges that are kept, by the number of their axis. @type {Map<number, [number, number]>} */
  const ranges = new Map();
  /** @type {number[]} */
  let chosen = study.rows.map((_, k) => k);
  /** The variants that are open, at most two. @type {number[]} */
  let open = [];
  let most = SHOWN;

  // Parallel axes: lines on two canvases (all of them once, the chosen ones again and again), rails above.
  const WIDTH = Math.max(96 * axes.length, 600), HEIGHT = 300, TOP = 46, BOTTOM = 284;
  const scale = Math.min(window.devicePixelRatio || 1, 2);
  const behind = layer(), before = layer();
  const svg = drawn("svg", { width: WIDTH, height: HEIGHT });
  element("axes").append(behind.canvas, before.canvas, svg);
  const across = axes.map((_, k) => 60 + k * ((WIDTH - 120) / Math.max(axes.length - 1, 1)));
  /** @param {number} t */
  const height = (t) => BOTTOM - t * (BOTTOM - TOP);

  function layer() {
    const canvas = document.createElement("canvas");
    canvas.width = WIDTH * scale;
    canvas.height = HEIGHT * scale;
    canvas.style.width = `${WIDTH}px`;
    canvas.style.height = `${HEIGHT}px`;
    const pen = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    pen.scale(scale, scale);
    return { canvas, pen };
  }

  /** @param {string} tag @param {Record<string, string | number>} attributes */
  function drawn(tag, attributes) {
    const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
    return made;
  }

  /** A line through a row's places; it is broken where there is none.
   * @param {CanvasRenderingContext2D} pen @param {number} row */
  function line(pen, row) {
    let down = false;
    for (let k = 0; k < axes.length; k++) {
      const t = axes[k].at[row];
      if (Number.isNaN(t)) { down = false; continue; }
      if (down) pen.lineTo(across[k], height(t)); else pen.moveTo(across[k], height(t));
      down = true;
    }
  }

  /** @param {number} t */
  const colour = (t) => Number.isNaN(t) ? "#888" : `hsl(${Math.round(250 - 220 * t)} 75% 48%)`;

  function colours() {
    const by = axes[Number(element("colour").value)];
    return Array.from(study.rows, (_, row) => by ? colour(by.at[row]) : MARK);
  }

  function drawLines() {
    const pen = before.pen;
    pen.clearRect(0, 0, WIDTH, HEIGHT);
    pen.globalAlpha = Math.max(0.12, Math.min(0.8, 60 / Math.sqrt(1 + 40 * chosen.length)));
    pen.lineWidth = 1;
    // Lines of one colour are one path, which is drawn at once.
    const by = colours();
    const groups = new Map();
    for (const row of chosen) {
      const group = groups.get(by[row]);
      if (group) group.push(row); else groups.set(by[row], [row]);
    }
    for (const [tone, rows] of groups) {
      pen.strokeStyle = tone;
      pen.beginPath();
      for (const row of rows) line(pen, row);
      pen.stroke();
    }
    pen.globalAlpha = 1;
    pen.lineWidth = 2.5;
    for (const row of open) {
      pen.strokeStyle = MARK;
      pen.beginPath();
      line(pen, row);
      pen.stroke();
    }
  }

  function drawRails() {
    behind.pen.strokeStyle = REST;
    behind.pen.beginPath();
    study.rows.forEach((_, row) => line(behind.pen, row));
    behind.pen.stroke();
    axes.forEach((a, k) => {
      const x = across[k];
      const name = drawn("text", { x, y: k % 2 ? 14 : 30, class: "name" });
      name.textContent = short(a.name);
      const rail = drawn("line", { x1: x, x2: x, y1: TOP, y2: BOTTOM, class: "rail" });
      const range = drawn("rect", { x: x - 7, width: 14, y: 0, height: 0, class: "range" });
      const grip = drawn("rect", { x: x - 16, width: 32, y: TOP - 6, height: BOTTOM - TOP + 12, class: "grip" });
      grip.setAttribute("data-axis", a.name);
      svg.append(name, rail, range, ...a.ticks.map((tick) => {
        const text = drawn("text", { x, y: height(tick.at) + 4, stroke: "var(--paper)", "stroke-width": 7, "stroke-linejoin": "round", "paint-order": "stroke" });
        text.textContent = tick.text.length > 14 ? `${tick.text.slice(0, 13)}…` : tick.text;
        return text;
      }), grip);
      brush(/** @type {SVGElement} */ (grip), range, k);
    });
  }

  /** @param {SVGElement} grip @param {Element} range @param {number} k */
  function brush(grip, range, k) {
    let from = 0;
    /** @param {PointerEvent} event */
    const place = (event) => {
      const y = event.clientY - svg.getBoundingClientRect().top;
      return Math.max(0, Math.min(1, (BOTTOM - y) / (BOTTOM - TOP)));
    };
    grip.addEventListener("pointerdown", (event) => {
      if (event.isTrusted) grip.setPointerCapture(event.pointerId);
      from = place(event);
      ranges.delete(k);
      mark(range, k);
      soon();
    });
    grip.addEventListener("pointermove", (event) => {
      if (event.buttons !== 1) return;
      const to = place(event);
      if (Math.abs(to - from) < 0.01) return;
      ranges.set(k, [Math.min(from, to), Math.max(from, to)]);
      mark(range, k);
      soon();
    });
  }

  /** @param {Element} range @param {number} k */
  function mark(range, k) {
    const [low, high] = ranges.get(k) ?? [0, 0];
    range.setAttribute("y", String(height(high)));
    range.setAttribute("height", String(height(low) - height(high)));
  }

  let waits = false;
  /** Draws once a frame, however many events there are. */
  function soon() {
    if (waits) return;
    waits = true;
    requestAnimationFrame(() => { waits = false; choose(); });
  }

  function choose() {
    const kept = [...ranges];
    const inside = (/** @type {number} */ row) =>
      kept.every(([k, [low, high]]) => axes[k].at[row] >= low - 1e-9 && axes[k].at[row] <= high + 1e-9);
    chosen = study.rows.map((_, row) => row).filter(inside);
    most = SHOWN;
    draw();
  }

  function draw() {
    element("count").textContent = `${chosen.length} of ${study.rows.length} variants`;
    drawLines();
    drawScatter();
    drawPictures();
  }

  // Two figures, and the best of both.
  const scatter = element("scatter");
  const pen = /** @type {CanvasRenderingContext2D} */ (scatter.getContext("2d"));
  const EDGE = 46;

  function figures() {
    return ["x", "y"].map((id) => ({ axis: numeric[Number(element(id).value)], more: element(`${id}-more`).checked }));
  }

  /** The rows that no other one beats in both figures. @param {number[]} rows */
  function best(rows) {
    const [x, y] = figures();
    if (!x.axis || !y.axis) return [];
    /** @param {typeof x} f @param {number} row */
    const cost = (f, row) => f.more ? -f.axis.at[row] : f.axis.at[row];
    const sound = rows.filter((row) => !Number.isNaN(cost(x, row)) && !Number.isNaN(cost(y, row)) && isMesh(row));
    sound.sort((a, b) => cost(x, a) - cost(x, b) || cost(y, a) - cost(y, b));
    let least = Infinity;
    return sound.filter((row) => {
      const wins = cost(y, row) < least;
      if (wins) least = cost(y, row);
      return wins;
    });
  }

  /** @param {number} row */
  const isMesh = (row) => STATUS < 0 || ["pass", "outside-tolerance"].includes(String(study.rows[row][STATUS]));

  /** @param {number} row @returns {[number, number]} */
  function spot(row) {
    const [x, y] = figures();
    const [w, h] = [scatter.clientWidth - EDGE - 12, scatter.clientHeight - EDGE - 12];
    return [EDGE + x.axis.at[row] * w, 12 + (1 - y.axis.at[row]) * h];
  }

  function drawScatter() {
    const [w, h] = [scatter.clientWidth, scatter.clientHeight];
    if (scatter.width !== w * scale) { scatter.width = w * scale; scatter.height = h * scale; }
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.clearRect(0, 0, w, h);
    const [x, y] = figures();
    if (!x.axis || !y.axis) return;
    const ink = getComputedStyle(document.body).color;
    pen.fillStyle = ink;
    pen.font = "11px system-ui, sans-serif";
    pen.textAlign = "center";
    for (const tick of x.axis.ticks) pen.fillText(tick.text, EDGE + tick.at * (w - EDGE - 12), h - 20);
    pen.fillText(short(x.axis.name), w / 2, h - 5);
    pen.textAlign = "right";
    for (const tick of y.axis.ticks) pen.fillText(tick.text, EDGE - 6, 16 + (1 - tick.at) * (h - EDGE - 12));
    const by = colours();
    pen.globalAlpha = 0.7;
    for (const row of chosen) {
      const [px, py] = spot(row);
      if (Number.isNaN(px + py)) continue;
      pen.fillStyle = by[row];
      pen.fillRect(px - 2, py - 2, 4, 4);
    }
    pen.globalAlpha = 1;
    const front = best(chosen);
    element("front").textContent = front.length ? `${front.length} best in one or both` : "";
    pen.strokeStyle = FRONT;
    pen.lineWidth = 1.5;
    pen.beginPath();
    front.forEach((row, k) => {
      const [px, py] = spot(row);
      if (k === 0) { pen.moveTo(px, py); return; }
      const [, before] = spot(front[k - 1]);
      pen.lineTo(px, before);
      pen.lineTo(px, py);
    });
    pen.stroke();
    for (const row of front) {
      const [px, py] = spot(row);
      pen.beginPath();
      pen.arc(px, py, 4.5, 0, 7);
      pen.stroke();
    }
    pen.strokeStyle = MARK;
    for (const row of open) {
      const [px, py] = spot(row);
      pen.strokeRect(px - 6, py - 6, 12, 12);
    }
  }

  scatter.addEventListener("click", (/** @type {MouseEvent} */ event) => {
    let near = -1, least = 15;
    for (const row of chosen) {
      const [px, py] = spot(row);
      const away = Math.hypot(px - event.offsetX, py - event.offsetY);
      if (away < least) { near = row; least = away; }
    }
    if (near >= 0) show(near, event.shiftKey);
  });

  // Thumbnails, made when they are first seen.
  /** @type {Map<number, HTMLButtonElement>} */
  const made = new Map();

  /** @param {number} row */
  function picture(row) {
    const found = made.get(row);
    if (found) return found;
    const button = document.createElement("button");
    button.type = "button";
    const data = study.thumbnails[row];
    if (data) {
      const image = document.createElement("img");
      image.src = `data:image/png;base64,${data}`;
      image.alt = "";
      image.decoding = "async";
      button.append(image);
    } else {
      const none = document.createElement("i");
      none.textContent = String(study.rows[row][STATUS] ?? "no mesh");
      button.append(none);
    }
    button.append(caption(row));
    button.addEventListener("click", (event) => show(row, event.shiftKey));
    made.set(row, button);
    return button;
  }

  /** @param {number} row */
  function caption(row) {
    const varied = axes.filter((a) => a.name.startsWith("in:")).slice(0, 3);
    return varied.map((a) => figure(study.rows[row][a.column])).join(" · ");
  }

  function ordered() {
    const by = axes[Number(element("order").value)];
    if (!by) return chosen;
    const sign = MORE.has(by.name) ? -1 : 1;
    const place = (/** @type {number} */ row) => Number.isNaN(by.at[row]) ? 2 : sign * by.at[row];
    return [...chosen].sort((a, b) => place(a) - place(b) || a - b);
  }

  function drawPictures() {
    const rows = ordered().slice(0, most);
    element("pictures").replaceChildren(...rows.map(picture));
    rows.forEach((row) => picture(row).setAttribute("aria-pressed", String(open.includes(row))));
    element("more").hidden = chosen.length <= most;
    element("more").textContent = `${chosen.length - most} more`;
  }

  // One variant, or two beside each other.
  /** @param {number} row @param {boolean} beside */
  function show(row, beside) {
    open = beside && open.length > 0 && open[0] !== row ? [open[0], row] : [row];
    const place = document.createElement("div");
    place.className = "both";
    place.append(...open.map(shown));
    element("one").replaceChildren(place);
    drawLines();
    drawScatter();
    for (const [k, button] of made) button.setAttribute("aria-pressed", String(open.includes(k)));
  }

  /** @param {number} row */
  function shown(row) {
    const place = document.createElement("div");
    const key = String(study.rows[row][KEY]);
    if (study.thumbnails[row]) {
      const image = document.createElement("img");
      image.src = `${key}/picture.png`;
      image.alt = `variant ${key}`;
      // Where the folders are elsewhere the thumbnail stays.
      image.onerror = () => { image.onerror = null; image.src = `data:image/png;base64,${study.thumbnails[row]}`; };
      place.append(image);
      const links = document.createElement("p");
      const files = [["mesh.obj", "mesh"], ["report.json", "report as JSON"]];
      if (study.pages[row]) files.unshift(["report.html", "report"]);
      links.append(...files.flatMap(([file, text]) => {
        const link = document.createElement("a");
        link.href = `${key}/${file}`;
        link.textContent = text;
        return [link, " "];
      }));
      place.append(links);
    }
    const table = document.createElement("table");
    study.columns.forEach((name, k) => {
      if (["img", "threeD"].includes(name)) return;
      const cells = open.map((other) => study.rows[other][k]);
      if (cells.every((c) => c === null || c === "")) return;
      const line = table.insertRow();
      line.insertCell().textContent = short(name);
      line.insertCell().textContent = figure(study.rows[row][k]);
      line.className = cells.length > 1 && cells[0] !== cells[1] && name !== "key" ? "differs" : "";
    });
    place.append(table);
    return place;
  }

  function save() {
    const cell = (/** @type {Cell} */ c) => {
      const text = String(c ?? "");
      return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
    };
    const lines = [study.columns, ...ordered().map((row) => study.rows[row])].map((row) => row.map(cell).join(","));
    const link = document.createElement("a");
    link.href = `data:text/csv;charset=utf-8,${encodeURIComponent(lines.join("\n"))}`;
    link.download = "designs.csv";
    link.click();
  }

  /** @param {string} id @param {{ name: string }[]} list @param {string | null} none @param {string} wanted */
  function choices(id, list, none, wanted) {
    const select = element(id);
    if (none !== null) select.add(new Option(none, "-1"));
    list.forEach((a, k) => select.add(new Option(short(a.name), String(k), false, a.name === wanted)));
    select.addEventListener("change", draw);
  }

  choices("colour", axes, "one", "out:deviation");
  choices("order", axes, "as in the table", "");
  choices("x", numeric, null, "out:distinct-lengths");
  choices("y", numeric, null, "out:deviation");
  for (const id of ["x", "y"]) {
    const box = element(`${id}-more`);
    const usual = () => { box.checked = MORE.has(numeric[Number(element(id).value)]?.name); };
    usual();
    element(id).addEventListener("change", () => { usual(); draw(); });
    box.addEventListener("change", draw);
  }
  element("clear").addEventListener("click", () => {
    ranges.clear();
    svg.querySelectorAll(".range").forEach((range) => range.setAttribute("height", "0"));
    choose();
  });
  element("more").addEventListener("click", () => { most += 4 * SHOWN; drawPictures(); });
  element("save").addEventListener("click", save);
  window.addEventListener("resize", soon);
  drawRails();
  draw();
}
