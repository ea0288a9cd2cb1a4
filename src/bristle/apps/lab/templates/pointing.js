// The plots of the page, with pointer and zoom: drag to enlarge a part, turn the wheel to zoom, double-click to show all.
// With `pull` a drag with Shift moves what is drawn. Keyboard: arrows move the pointer, + and - zoom, Escape shows all.

const SMALLEST = 6, TURNED = 1.0015, CLOSER = 1.5; // [pixels], zoom per wheel unit, zoom per key

class Pointed {
  constructor(name, draw, pull = null) {
    Object.assign(this, { name, canvas: byId(name), reading: byId(`${name}-reading`), draw, pull, view: {}, at: null, from: null, to: null, pulled: null, waits: false });
    this.listen();
  }

  show() {
    this.waits = false;
    this.frame = this.canvas.clientWidth ? this.draw(lab, this.canvas, this.view) : null;
    if (!this.frame) return;
    placeHandles(this.name, this.frame);
    tell(this.reading, this.at ? this.told() : this.frame.words, !this.at && Boolean(this.frame.alert));
    if (this.from && this.to) this.shade();
  }

  later() {
    if (!this.waits) requestAnimationFrame(() => this.show());
    this.waits = true;
  }

  shade() {
    const { frame, from, to } = this, { context, theme } = frame;
    frame.clip(() => {
      Object.assign(context, { globalAlpha: 0.25, fillStyle: theme.accent });
      context.fillRect(from.x, from.y, to.x - from.x, to.y - from.y);
    });
  }

  look(x = null, y = null) {
    this.view = { x, y };
    this.later();
  }

  // Zoom both axes by a factor around a point.
  enlarge(factor, { x, y }) {
    const around = (axis, value) => [value - (value - axis.low) / factor, value + (axis.high - value) / factor], { frame } = this;
    if (frame) this.look(around(frame.x, frame.valueAt(x)), around(frame.y, frame.valueUp(y)));
  }

  choose() {
    const { from, to, frame } = this, sorted = (a, b) => [Math.min(a, b), Math.max(a, b)];
    if (!frame || Math.min(Math.abs(to.x - from.x), Math.abs(to.y - from.y)) < SMALLEST) return;
    this.look(sorted(frame.valueAt(from.x), frame.valueAt(to.x)), sorted(frame.valueUp(from.y), frame.valueUp(to.y)));
  }

  // The share of the first curve at the pointer; without curves the place itself.
  pick({ x: px, y: py }) {
    const { frame } = this;
    if (!frame.curves) return { x: frame.valueAt(px), up: frame.valueUp(py) };
    const [x, y] = frame.curves[0], away = Array.from(x, (value, k) => (frame.across(value) - px) ** 2 + (frame.up(y[k]) - py) ** 2);
    return { share: away.reduce((best, value, k) => (value < away[best] ? k : best), 0) / (x.length - 1) };
  }

  shift(way) {
    const { frame, at } = this;
    if (frame.curves) return { share: Math.max(0, Math.min(1, at.share + way / 400)) };
    return { ...at, x: at.x + way * (frame.x.high - frame.x.low) / 100 };
  }

  // The values at the pointer, marked in the plot.
  told() {
    const { frame, at } = this, { x: { unit }, y: { unit: unitUp } } = frame.own;
    if (!frame.curves) return `${frame.x.word} ${told(at.x, unit)}, ${frame.y.word} ${told(at.up, unitUp)}.`;
    const found = frame.curves.map(([xs, ys, colour, name]) => {
      const k = Math.round(at.share * (xs.length - 1));
      frame.dot(xs[k], ys[k], colour, 4);
      return { x: xs[k], text: `${frame.curves.length > 1 ? `${name} ` : ""}${told(ys[k], unitUp)}` };
    });
    frame.upright(found[0].x, frame.theme.soft);
    return `At ${told(found[0].x, unit)}: ${found.map(({ text }) => text).join(", ")}.`;
  }

  listen() {
    const { canvas } = this, place = ({ offsetX: x, offsetY: y }) => ({ x, y });
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      if (this.pull && event.shiftKey) this.pulled = event.offsetX;
      else Object.assign(this, { from: place(event), to: null });
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!this.frame) return;
      if (this.pulled !== null) {
        this.pull(this.frame.valueAt(event.offsetX) - this.frame.valueAt(this.pulled));
        this.pulled = event.offsetX;
        return;
      }
      if (this.from) this.to = place(event);
      this.at = this.pick(place(event));
      this.later();
    });
    canvas.addEventListener("pointerup", () => {
      if (this.from && this.to) this.choose();
      if (this.pulled !== null) keep();
      this.from = this.to = this.pulled = null;
      this.later();
    });
    for (const name of ["pointerleave", "pointercancel", "blur"]) {
      canvas.addEventListener(name, () => {
        if (name !== "pointerleave" || !this.from) Object.assign(this, { at: null, from: null, to: null });
        this.later();
      });
    }
    canvas.addEventListener("dblclick", () => this.look());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.enlarge(TURNED ** -event.deltaY, place(event));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    if (!this.frame || event.ctrlKey || event.metaKey || event.altKey) return;
    const { left, right, top, bottom } = this.frame, middle = { x: (left + right) / 2, y: (top + bottom) / 2 };
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key], zoom = { "+": CLOSER, "-": 1 / CLOSER }[event.key];
    if (way) this.at = this.at ? this.shift(way * (event.shiftKey ? 10 : 1)) : this.pick(middle);
    else if (zoom) this.enlarge(zoom, middle);
    else if (event.key === "Escape") this.look();
    else return;
    event.preventDefault();
    this.later();
  }
}

// Drag a part of the page: `begin` returns the held part, `move` gets it with each event, and the history keeps the end.
function dragged(target, begin, move) {
  let held = null;
  target.addEventListener("pointerdown", (event) => {
    held = begin(event);
    if (held) target.setPointerCapture(event.pointerId);
  });
  target.addEventListener("pointermove", (event) => { if (held) move(event, held); });
  for (const name of ["pointerup", "pointercancel"]) target.addEventListener(name, () => { if (held) { held = null; keep(); } });
}

// The way and the size of an arrow key; the history keeps its release.
function steered(target, by, act) {
  target.addEventListener("keydown", (event) => {
    if (!event.key.startsWith("Arrow")) return;
    event.preventDefault();
    act(event, /Right|Up/.test(event.key) ? 1 : -1);
  });
  target.addEventListener("keyup", (event) => { if (event.key.startsWith("Arrow")) keep(by); });
}

function pullBlock(distance) {
  play(false);
  moveBy(distance);
}

function newPlots() {
  return {
    loop: new Pointed("loop", loopView, pullBlock), speed: new Pointed("speed", speedView), track: new Pointed("track", trackView),
    plane: new Pointed("plane", (...all) => (lab.model.stack ? planeView : elementsView)(...all)),
  };
}
