// A plot with pointer and zoom: drag to enlarge a part, Ctrl and wheel to zoom, double-click to show all. With `wheel` the
// wheel alone zooms; with `pull` a drag with Shift moves what is drawn.
// Keyboard: arrows move the pointer, + and - zoom, Escape shows all.

const SMALLEST = 6, TURNED = 1.0015, CLOSER = 1.5; // [pixels], zoom per wheel unit, zoom per key

// The visible range of linked plots: null for the full range.
function newView() { return { x: null, y: null, plots: [] }; }

class Pointed {
  // `draw` draws a view and returns the frame; `pick` returns the item at a position, `shift` the item a step
  // further, and `tell` marks it in the frame and describes it.
  constructor(canvas, reading, view, { draw, pick, shift, tell, both = false, wheel = false, pull = null }) {
    Object.assign(this, { canvas, reading, view, draw, pick, shift, tell, both, wheel, pull, at: null, from: null, to: null, pulled: null, waits: false });
    view.plots.push(this);
    this.listen();
  }

  get hint() { return "Point at the plot to read values. Drag to enlarge a part, double-click to show all."; }

  show() {
    this.waits = false;
    this.frame = this.draw(this.canvas, this.view);
    if (!this.frame) return;
    const text = this.at === null ? this.frame.words ?? this.hint : this.tell(this.frame, this.at);
    this.reading.classList.toggle("alert", this.at === null && Boolean(this.frame.alert));
    if (this.reading.textContent !== text) this.reading.textContent = text;
    if (this.from && this.to) this.shade();
  }

  later() {
    if (!this.waits) requestAnimationFrame(() => this.show());
    this.waits = true;
  }

  shade() {
    const { context, theme, left, right, top, bottom } = this.frame;
    const [x0, x1] = [this.from.x, this.to.x], [y0, y1] = this.both ? [this.from.y, this.to.y] : [top, bottom];
    context.save();
    context.globalAlpha = 0.25;
    context.fillStyle = theme.accent;
    context.fillRect(Math.max(left, Math.min(x0, x1)), Math.max(top, Math.min(y0, y1)),
      Math.min(right, Math.max(x0, x1)) - Math.max(left, Math.min(x0, x1)), Math.min(bottom, Math.max(y0, y1)) - Math.max(top, Math.min(y0, y1)));
    context.restore();
  }

  look(x, y = null) {
    Object.assign(this.view, { x, y });
    for (const plot of this.view.plots) plot.later();
  }

  // Zoom both axes, or the time axis, by a factor around a point.
  enlarge(factor, place) {
    if (!this.frame) return;
    const around = (axis, value) => [value - (value - axis.low) / factor, value + (axis.high - value) / factor];
    this.look(around(this.frame.x, this.frame.valueAt(place.x)), this.both ? around(this.frame.y, this.frame.valueUp(place.y)) : null);
  }

  chosen() {
    const { from, to, frame } = this, wide = Math.abs(to.x - from.x) >= SMALLEST, high = Math.abs(to.y - from.y) >= SMALLEST;
    if (!frame || !wide || this.both && !high) return;
    const sorted = (a, b) => [Math.min(a, b), Math.max(a, b)];
    this.look(sorted(frame.valueAt(from.x), frame.valueAt(to.x)), this.both ? sorted(frame.valueUp(from.y), frame.valueUp(to.y)) : null);
  }

  listen() {
    const { canvas } = this, place = (event) => ({ x: event.offsetX, y: event.offsetY });
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
      this.at = this.pick(this.frame, event.offsetX, event.offsetY);
      this.later();
    });
    canvas.addEventListener("pointerup", () => {
      if (this.from && this.to) this.chosen();
      if (this.pulled !== null) this.pull(null);
      this.from = this.to = this.pulled = null;
      this.later();
    });
    for (const name of ["pointerleave", "pointercancel", "blur"]) {
      canvas.addEventListener(name, () => {
        if (name !== "pointerleave" || !this.from) Object.assign(this, { at: null, from: null, to: null });
        this.later();
      });
    }
    canvas.addEventListener("dblclick", () => this.look(null));
    canvas.addEventListener("wheel", (event) => {
      if (!this.wheel && !event.ctrlKey && !event.metaKey) return;
      event.preventDefault();
      this.enlarge(TURNED ** -event.deltaY, place(event));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    if (!this.frame || event.ctrlKey || event.metaKey || event.altKey) return;
    const { left, right, top, bottom } = this.frame, middle = { x: (left + right) / 2, y: (top + bottom) / 2 };
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (way) this.at = this.at === null ? this.pick(this.frame, middle.x, middle.y) : this.shift(this.frame, this.at, way * (event.shiftKey ? 10 : 1));
    else if (event.key === "+") this.enlarge(CLOSER, middle);
    else if (event.key === "-") this.enlarge(1 / CLOSER, middle);
    else if (event.key === "Escape") this.look(null);
    else return;
    event.preventDefault();
    this.later();
  }
}

// The index in a rising list nearest to a value.
function nearest(list, value) {
  let low = 0, high = list.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (list[middle] <= value) low = middle;
    else high = middle;
  }
  return value - list[low] <= list[high] - value ? low : high;
}
