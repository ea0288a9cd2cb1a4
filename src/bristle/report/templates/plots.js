"use strict";
// The plots of a report. Pointing reads values, a drag enlarges a part, a double click shows all. Keys: arrows, + and -, Escape.

const NEAREST = 6, CLOSER = 1.5, WAY = { ArrowLeft: -1, ArrowRight: 1 }; // [points], zoom per key

// A position between the ends of an axis, from 0 to 1, and back: linear, logarithmic, or linear near zero and logarithmic beyond.
// `from` and `to` are the drawn places of the ends, `view` is the visible part.
function scaleOfSide({ ends, scale, linear = 1 }, from = 0, to = 1) {
  const symlog = (v) => (Math.abs(v) <= linear ? v / linear / 0.9 : Math.sign(v) * (1 / 0.9 + Math.log10(Math.abs(v) / linear)));
  const inverse = (s) => (Math.abs(s) <= 1 / 0.9 ? 0.9 * s * linear : Math.sign(s) * linear * 10 ** (Math.abs(s) - 1 / 0.9));
  const [forth, back] = { log: [Math.log10, (s) => 10 ** s], symlog: [symlog, inverse] }[scale] ?? [(v) => v, (s) => s];
  const least = forth(ends[0]), wide = forth(ends[1]) - least;
  const at = (value) => (forth(value) - least) / wide, value = (share) => back(least + share * wide), share = (place) => (place - from) / (to - from);
  return { at, value, share, view: [0, 1],
    place: (number) => from + at(number) * (to - from),
    moved(place) { const [low, high] = this.view; return from + (share(place) - low) / (high - low) * (to - from); },
    valueAt(place) { const [low, high] = this.view; return value(low + share(place) * (high - low)); } };
}

function stepFor(rough) {
  const power = 10 ** Math.floor(Math.log10(rough));
  return [1, 2, 5, 10].map((factor) => factor * power).find((step) => step >= 0.999 * rough);
}

function ticksBetween(low, high, most, isLinear) {
  if (isLinear) {
    const step = stepFor((high - low) / most), first = Math.ceil(low / step - 1e-9);
    return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, k) => Number(((first + k) * step).toPrecision(12)));
  }
  const powers = Array.from({ length: 25 }, (_, k) => 10 ** (k - 12));
  return [...powers.map((power) => -power).reverse(), 0, ...powers].filter((tick) => tick >= low && tick <= high);
}

function shortNumber(value, digits = 4) { return String(Number(value.toPrecision(digits))).replace("-", "−"); }

function part(svg, name, attributes, text = "") {
  const made = document.createElementNS(svg.namespaceURI, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.textContent = text;
  return made;
}

const PAIRS = /(-?[\d.]+(?:e-?\d+)?) (-?[\d.]+(?:e-?\d+)?)/g;
const near = (value) => value.toFixed(2);

class Panel {
  constructor(plot, group, facts) {
    const [left, top, right, bottom] = facts.box;
    Object.assign(this, { plot, group, facts, left, top, right, bottom, x: scaleOfSide(facts.x, left, right), y: scaleOfSide(facts.y, bottom, top), added: [] });
    this.artists = [...group.querySelectorAll("[clip-path]")].map((node) => this.artist(node));
    // Texts at a point of the panel, such as a marked distance; names of lines stand outside.
    this.inside = [...group.querySelectorAll("text")].filter((text) => !text.closest("[data-tick]") && this.has(Number(text.getAttribute("x")), Number(text.getAttribute("y"))));
    this.curves = facts.names.map((name, k) => ({ name, node: group.querySelector(`[data-curve="${k}"]`) })).filter(({ node }) => node);
  }

  artist(node) {
    const uses = node.matches("use") ? [node] : [...node.querySelectorAll("use")];
    return { node, d: node.getAttribute("d"), uses: uses.map((use) => ({ use, x: Number(use.getAttribute("x") ?? 0), y: Number(use.getAttribute("y") ?? 0) })) };
  }

  has(x, y) { return x >= this.left && x <= this.right && y >= this.top && y <= this.bottom; }

  pointsOf({ node }) {
    const path = node.querySelector("path[clip-path]"), own = this.artists.find((artist) => artist.node === path);
    if (own?.d) return [...own.d.matchAll(PAIRS)].map(([, x, y]) => [Number(x), Number(y)]);
    return this.artists.filter((artist) => node.contains(artist.node)).flatMap(({ uses }) => uses.map(({ x, y }) => [x, y]));
  }

  look(x, y = [0, 1]) {
    [this.x.view, this.y.view] = [x, y];
    this.redraw();
  }

  redraw() {
    for (const { node, d, uses } of this.artists) {
      if (d) node.setAttribute("d", d.replace(PAIRS, (_, x, y) => `${near(this.x.moved(Number(x)))} ${near(this.y.moved(Number(y)))}`));
      for (const { use, x, y } of uses) {
        use.setAttribute("x", near(this.x.moved(x)));
        use.setAttribute("y", near(this.y.moved(y)));
      }
    }
    const isWhole = [this.x.view, this.y.view].every(([low, high]) => low === 0 && high === 1);
    for (const text of this.group.querySelectorAll(":scope > [data-tick], :scope > g > [data-tick]")) text.style.display = isWhole ? "" : "none";
    for (const text of this.inside) text.style.display = isWhole ? "" : "none";
    this.added.forEach((node) => node.remove());
    this.added = isWhole ? [] : this.ticks();
  }

  ticks() {
    const { plot: { svg }, group, facts, left, right, top, bottom } = this, made = [];
    const add = (name, attributes, text) => { const node = part(svg, name, attributes, text); group.append(node); made.push(node); };
    const style = "font:8px system-ui, DejaVu Sans, sans-serif;fill:var(--ink)", line = "stroke:var(--rule);stroke-width:.6";
    for (const [side, from, to, room] of [["x", left, right, 60], ["y", bottom, top, 30]]) {
      const isX = side === "x", scale = this[side];
      for (const tick of ticksBetween(scale.valueAt(from), scale.valueAt(to), Math.abs(to - from) / room, facts[side].scale === "linear")) {
        const at = near(scale.moved(scale.place(tick)));
        add("path", { d: isX ? `M ${at} ${top} L ${at} ${bottom}` : `M ${left} ${at} L ${right} ${at}`, style: line });
        add("text", isX ? { x: at, y: bottom + 11, "text-anchor": "middle", style } : { x: left - 5, y: Number(at) + 3, "text-anchor": "end", style }, shortNumber(tick, 6));
      }
    }
    return made;
  }

  // The point of each curve nearest to a place, and its words.
  read(x, y) {
    const found = [];
    for (const curve of this.curves) {
      const points = this.pointsOf(curve).map(([px, py]) => [this.x.moved(px), this.y.moved(py)]);
      let best = null, least = Infinity;
      for (const [px, py] of points) {
        const away = Math.abs(px - x) + 0.15 * Math.abs(py - y);
        if (away < least && this.has(px, py)) [best, least] = [[px, py], away];
      }
      if (best && !curve.name.startsWith("_") && least < 10 * NEAREST) found.push({ name: curve.name, at: best });
    }
    return found;
  }

  words(found) {
    const [, xWord, xUnit = ""] = this.facts.x.word.match(/^(.*?)(?: \[(.*)\])?$/), yUnit = this.facts.y.word.match(/\[(.*)\]$/)?.[1] ?? "";
    const values = found.map(({ name, at }) => `${name} ${shortNumber(this.y.valueAt(at[1]))} ${yUnit}`);
    return found.length ? `${xWord} ${shortNumber(this.x.valueAt(found[0].at[0]))} ${xUnit}: ${values.join(", ")}` : "";
  }

  // Other values for a curve; a value that is not a number interrupts it.
  setCurve(name, xs, ys) {
    const curve = this.curves.find((each) => each.name === name), path = curve?.node.querySelector("path[clip-path]");
    const own = path && this.artists.find((artist) => artist.node === path);
    if (!own) return;
    own.original ??= own.d;
    let pen = "M";
    own.d = xs ? Array.from(xs, (x, k) => {
      if (!Number.isFinite(ys[k])) { pen = "M"; return ""; }
      const text = `${pen} ${near(this.x.place(x))} ${near(this.y.place(ys[k]))} `;
      pen = "L";
      return text;
    }).join("") : own.original;
    this.redraw();
  }
}

class Plot {
  constructor(figure, svg) {
    Object.assign(this, { figure, svg, from: null, at: null });
    const groups = [...svg.querySelectorAll("[data-panel]")];
    this.panels = JSON.parse(svg.dataset.panels).map((facts, k) => new Panel(this, groups.find((group) => group.dataset.panel === String(k)), facts));
    this.reading = document.createElement("span");
    this.reading.className = "reading";
    figure.querySelector("figcaption").append(this.reading);
    this.marks = part(svg, "g", {});
    svg.append(this.marks);
    svg.tabIndex = 0;
    this.listen();
  }

  place(event) {
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM().inverse());
    return { x, y, panel: this.panels.find((panel) => panel.has(x, y)) };
  }

  show(panel, x, y) {
    this.at = { panel, x, y };
    const found = panel.read(x, y);
    this.marks.replaceChildren(...found.map(({ at }) => part(this.svg, "circle", { class: "mark", cx: near(at[0]), cy: near(at[1]), r: 2.6 })));
    const text = panel.words(found);
    if (this.reading.textContent !== text) this.reading.textContent = text;
    this.figure.dispatchEvent(new CustomEvent("read", { detail: panel.x.valueAt(x) }));
  }

  // Mark a point of another plot.
  mark(x, y) {
    const [panel] = this.panels, cx = panel.x.moved(panel.x.place(x)), cy = panel.y.moved(panel.y.place(y));
    this.marks.replaceChildren(...(panel.has(cx, cy) ? [part(this.svg, "circle", { class: "mark", cx: near(cx), cy: near(cy), r: 4 })] : []));
  }

  clear() {
    this.marks.replaceChildren();
    this.reading.textContent = "";
  }

  // A strip under the large picture chooses the part that the large picture shows.
  enlarge(panel, low, high, y = [0, 1]) {
    const strip = this.panels.length === 2 && panel === this.panels[1] && this.figure.closest(".hero") ? this.panels[0] : null;
    if (!strip) return panel.look([low, high], y);
    const share = (place) => strip.x.at(panel.x.value(place));
    return strip.look([share(low), share(high)]);
  }

  listen() {
    const { svg } = this;
    svg.addEventListener("pointerdown", (event) => {
      const place = this.place(event);
      if (event.button || !place.panel) return;
      this.from = place;
      svg.setPointerCapture(event.pointerId);
    });
    svg.addEventListener("pointermove", (event) => {
      const { x, y, panel } = this.place(event);
      if (this.from) return this.shade(x, y);
      return panel ? this.show(panel, x, y) : this.clear();
    });
    svg.addEventListener("pointerup", (event) => {
      const { from } = this, { x, y } = this.place(event);
      this.from = null;
      this.clear();
      if (from && Math.abs(x - from.x) > NEAREST) this.choose(from, x, y);
    });
    svg.addEventListener("pointerleave", () => { if (!this.from) this.clear(); });
    svg.addEventListener("dblclick", () => this.all());
    svg.addEventListener("wheel", (event) => {
      const { x, panel } = this.place(event);
      if (!panel || !(event.ctrlKey || event.metaKey)) return;
      event.preventDefault();
      this.closer(panel, x, 1.0015 ** -event.deltaY);
    }, { passive: false });
    svg.addEventListener("keydown", (event) => this.key(event));
  }

  shade(x, y) {
    const { panel } = this.from, [a, b] = [this.from.x, x].sort((p, q) => p - q), [c, d] = [this.from.y, y].sort((p, q) => p - q), isBoth = d - c > 3 * NEAREST;
    this.marks.replaceChildren(part(this.svg, "rect", { class: "drag", x: near(Math.max(a, panel.left)), width: near(Math.max(0, Math.min(b, panel.right) - Math.max(a, panel.left))),
      y: near(isBoth ? Math.max(c, panel.top) : panel.top), height: near(isBoth ? Math.max(0, Math.min(d, panel.bottom) - Math.max(c, panel.top)) : panel.bottom - panel.top) }));
  }

  choose({ panel, x: fromX, y: fromY }, x, y) {
    const share = (low, high, ends) => { const [a, b] = [Math.max(0, Math.min(low, high)), Math.min(1, Math.max(low, high))]; return ends.map((_, k) => ends[0] + (k ? b : a) * (ends[1] - ends[0])); };
    const isBoth = Math.abs(y - fromY) > 3 * NEAREST, { x: across, y: up } = panel;
    this.enlarge(panel, ...share(across.share(fromX), across.share(x), across.view), isBoth ? share(up.share(fromY), up.share(y), up.view) : up.view);
  }

  closer(panel, x, factor) {
    const [low, high] = panel.x.view, around = low + panel.x.share(x) * (high - low);
    panel.look([around - (around - low) / factor, around + (high - around) / factor], panel.y.view);
  }

  all() { this.panels.forEach((panel) => panel.look([0, 1])); }

  key(event) {
    const panel = this.at?.panel ?? this.panels[0], x = this.at?.x ?? (panel.left + panel.right) / 2;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (WAY[event.key]) this.show(panel, Math.max(panel.left, Math.min(panel.right, x + WAY[event.key] * (event.shiftKey ? 20 : 2))), this.at?.y ?? (panel.top + panel.bottom) / 2);
    else if (event.key === "+" || event.key === "-") this.closer(panel, x, event.key === "+" ? CLOSER : 1 / CLOSER);
    else if (event.key === "Escape") { this.all(); this.clear(); } else return;
    event.preventDefault();
  }
}

const plots = new Map([...document.querySelectorAll("figure svg[data-panels]")].map((svg) => {
  const figure = svg.closest("figure");
  return [figure.id.replace("figure-", ""), new Plot(figure, svg)];
}));

// --- buttons, and links into tabs -----------------------------------------------------------------------------------------

for (const button of document.querySelectorAll("[data-copy], [data-print]")) {
  button.hidden = false;
  button.addEventListener("click", async () => {
    if (!("copy" in button.dataset)) return window.print();
    const area = document.createElement("textarea");
    area.value = button.dataset.copy;
    document.body.append(area);
    area.select();
    const copied = document.execCommand("copy");
    area.remove();
    const word = button.textContent;
    button.textContent = copied ? "Copied" : "Copying is not allowed here";
    setTimeout(() => { button.textContent = word; }, 1500);
    return null;
  });
}

function openTab() {
  const section = document.getElementById(location.hash.slice(1))?.closest(".tabs > section");
  if (!section) return;
  const sections = [...section.parentElement.children].filter((node) => node.matches("section"));
  section.parentElement.querySelectorAll(":scope > input")[sections.indexOf(section)].checked = true;
  section.scrollIntoView();
}
window.addEventListener("hashchange", openTab);
openTab();
