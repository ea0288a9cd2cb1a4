// Curves on a canvas: axes with ticks and units, in the colours of the page.

const COLOURS = ["ink", "soft", "rule", "accent", "alert", "ghost", "shade", "measured", "with", "without", "third", "care", "card", "ground"];

function colours(root = document.documentElement) {
  const style = getComputedStyle(root);
  return { ...Object.fromEntries(COLOURS.map((name) => [name, style.getPropertyValue(`--${name}`).trim()])), size: parseFloat(style.fontSize) };
}

function roundStep(rough) {
  const power = 10 ** Math.floor(Math.log10(rough));
  return [1, 2, 2.5, 5, 10].map((factor) => factor * power).find((each) => each >= rough * 0.999);
}

// About `count` round numbers between two ends.
function ticks(low, high, most) {
  const step = roundStep((high - low) / Math.max(most, 1));
  const list = [];
  for (let i = Math.ceil(low / step - 1e-9); i <= high / step + 1e-9; i++) list.push(Number((i * step).toPrecision(12)));
  return list;
}

function tickText(value) {
  return withDigits(value, 6).replace("-", "−");
}

// An axis around values, with round ends. It stays during small changes, so that the curve visibly moves.
function axis(low, high, margin = 0.06) {
  const wide = high - low || Math.abs(high) || 1, a = low - margin * wide, b = high + margin * wide;
  const step = roundStep(wide / 12);
  return [Math.floor(a / step) * step, Math.ceil(b / step) * step];
}

// A frame for curves on a part of a canvas: `area` in pixels of the page, axes in SI with a word and a unit each.
class Frame {
  constructor(context, area, xAxis, yAxis, theme) {
    Object.assign(this, { context, theme, own: { x: xAxis, y: yAxis } });
    this.x = { ...xAxis, ...scaleOf(xAxis.unit, Math.max(Math.abs(xAxis.low), Math.abs(xAxis.high))) };
    this.y = { ...yAxis, ...scaleOf(yAxis.unit, Math.max(Math.abs(yAxis.low), Math.abs(yAxis.high))) };
    context.font = `${0.82 * theme.size}px system-ui, "DejaVu Sans", sans-serif`;
    const across = Math.max(2, Math.floor(area.width / (6 * theme.size)));
    this.yTicks = ticks(this.y.low * this.y.factor, this.y.high * this.y.factor, Math.max(2, Math.floor(area.height / (3.2 * theme.size))));
    this.xTicks = ticks(this.x.low * this.x.factor, this.x.high * this.x.factor, across);
    const widest = Math.max(...this.yTicks.map((tick) => context.measureText(tickText(tick)).width));
    this.left = area.left + widest + 2.1 * theme.size;
    this.right = area.left + area.width - 0.9 * theme.size;
    this.top = area.top + 0.7 * theme.size;
    this.bottom = area.top + area.height - 2.9 * theme.size;
  }

  across(value) { return this.left + (value - this.x.low) / (this.x.high - this.x.low) * (this.right - this.left); }
  up(value) { return this.bottom - (value - this.y.low) / (this.y.high - this.y.low) * (this.bottom - this.top); }
  valueAt(pixel) { return this.x.low + (pixel - this.left) / (this.right - this.left) * (this.x.high - this.x.low); }

  valueUp(pixel) { return this.y.low + (this.bottom - pixel) / (this.bottom - this.top) * (this.y.high - this.y.low); }

  axes() {
    const { context, theme, left, right, top, bottom } = this, small = 0.3 * theme.size;
    pen(context, { lineWidth: 1, strokeStyle: theme.rule, fillStyle: theme.soft, textAlign: "center", textBaseline: "top" });
    context.beginPath();
    for (const tick of this.xTicks) {
      const at = Math.round(this.across(tick / this.x.factor)) + 0.5;
      context.moveTo(at, top);
      context.lineTo(at, bottom + small);
      context.fillText(tickText(tick), at, bottom + 1.5 * small);
    }
    pen(context, { textAlign: "right", textBaseline: "middle" });
    for (const tick of this.yTicks) {
      const at = Math.round(this.up(tick / this.y.factor)) + 0.5;
      context.moveTo(left - small, at);
      context.lineTo(right, at);
      context.fillText(tickText(tick), left - 1.5 * small, at);
    }
    context.stroke();
    this.zeros();
    pen(context, { fillStyle: theme.ink, textAlign: "center", textBaseline: "bottom" });
    context.fillText(labelOf(this.x), (left + right) / 2, bottom + 2.8 * theme.size);
    context.save();
    context.translate(left - 1.1 * theme.size - Math.max(...this.yTicks.map((tick) => context.measureText(tickText(tick)).width)), (top + bottom) / 2);
    context.rotate(-Math.PI / 2);
    context.fillText(labelOf(this.y), 0, 0);
    context.restore();
  }

  zeros() {
    const { context, theme } = this, [x, y] = [this.across(0), this.up(0)].map((at) => Math.round(at) + 0.5);
    pen(context, { strokeStyle: theme.soft });
    if (this.x.low < 0 && this.x.high > 0) stroke(context, [[x, this.top], [x, this.bottom]]);
    if (this.y.low < 0 && this.y.high > 0) stroke(context, [[this.left, y], [this.right, y]]);
  }

  clip(draw) {
    const { context } = this;
    context.save();
    context.beginPath();
    context.rect(this.left, this.top, this.right - this.left, this.bottom - this.top);
    context.clip();
    draw();
    context.restore();
  }

  curve(x, y, { colour, width = 2, dash = [], first = 0, last = x.length - 1 }) {
    const { context } = this, bold = Math.max(1, this.theme.size / 16); // larger letters, wider lines
    const a = (this.right - this.left) / (this.x.high - this.x.low), b = this.left - this.x.low * a;
    const c = (this.top - this.bottom) / (this.y.high - this.y.low), d = this.bottom - this.y.low * c;
    this.clip(() => {
      pen(context, { strokeStyle: colour, lineWidth: bold * width, lineJoin: "round", dash: dash.map((length) => bold * length) });
      context.beginPath();
      straightened(context, first, last, (k) => a * x[k] + b, (k) => c * y[k] + d);
      context.stroke();
    });
  }

  // A word at a point of a line.
  label(text, x, y, colour, align = "left") {
    const { context, theme } = this, left = this.across(x) + (align === "left" ? 6 : -6), top = this.up(y) - 3, wide = context.measureText(text).width;
    pen(context, { fillStyle: theme.ground, textAlign: align, textBaseline: "bottom" });
    context.fillRect(align === "left" ? left - 2 : left - wide - 2, top - theme.size, wide + 4, theme.size);
    pen(context, { fillStyle: colour });
    context.fillText(text, left, top);
  }

  // A vertical line at a value, or the band between two values.
  upright(x, colour) { this.curve([x, x], [this.y.low, this.y.high], { colour, width: 1 }); }

  dot(x, y, colour, size = 5) {
    const { context } = this;
    pen(context, { fillStyle: colour });
    context.beginPath();
    context.arc(this.across(x), this.up(y), size, 0, 2 * Math.PI);
    context.fill();
  }
}

const STRAYS = 0.2; // [px]

// A polyline with as few corners as the tolerance allows, because drawing corners is slow. From the last
// corner a cone of directions is within tolerance; a point outside it, or further back, makes the previous point a corner.
function straightened(context, first, last, across, up) {
  let atX = across(first), atY = up(first), beforeX = atX, beforeY = atY, reach = 0, lowX = 0, lowY = 0, highX = 0, highY = 0;
  context.moveTo(atX, atY);
  for (let k = first + 1; k <= last; k++) {
    const px = across(k), py = up(k);
    let dx = px - atX, dy = py - atY, r = Math.sqrt(dx * dx + dy * dy);
    const goesOn = r >= reach - STRAYS && (reach < STRAYS || (lowX * dy - lowY * dx >= 0 && dx * highY - dy * highX >= 0));
    if (!goesOn) {
      context.lineTo(beforeX, beforeY);
      atX = beforeX, atY = beforeY, reach = 0;
      dx = px - atX, dy = py - atY, r = Math.sqrt(dx * dx + dy * dy);
    }
    beforeX = px, beforeY = py;
    if (!(r >= STRAYS)) continue;
    // The directions within tolerance of this point, cut with the cone.
    const turn = STRAYS / r, rightX = dx + turn * dy, rightY = dy - turn * dx, leftX = dx - turn * dy, leftY = dy + turn * dx;
    if (reach < STRAYS || lowX * rightY - lowY * rightX > 0) lowX = rightX, lowY = rightY;
    if (reach < STRAYS || leftX * highY - leftY * highX > 0) highX = leftX, highY = leftY;
    if (r > reach) reach = r;
  }
  context.lineTo(beforeX, beforeY);
}

function pen(context, { dash = [], ...style }) {
  context.setLineDash(dash);
  Object.assign(context, style);
}

function stroke(context, points) {
  context.beginPath();
  for (const [x, y] of points) context.lineTo(x, y);
  context.stroke();
}

function labelOf({ word, unit }) { return unit ? `${word} [${unit}]` : word; }

const sizes = new WeakMap();

// Keep the size that the browser measured: to measure at each drawing would repeat the layout of the page.
function resized({ target, contentRect: { width, height } }) { sizes.set(target, [Math.round(width), Math.round(height)]); }

// Redirect the next drawing of a canvas.
let elsewhere = null;

function drawnOnto(canvas, context, draw) {
  elsewhere = { canvas, context };
  try { draw(); } finally { elsewhere = null; }
}

// A cleared context of a canvas, in its size on the page.
function wiped(canvas) {
  if (elsewhere?.canvas === canvas) {
    return { context: elsewhere.context, area: { left: 0, top: 0, width: canvas.clientWidth, height: canvas.clientHeight } };
  }
  const measured = sizes.get(canvas), ratio = window.devicePixelRatio || 1;
  const [width, height] = measured?.[0] ? measured : [canvas.clientWidth, canvas.clientHeight]; // before the first measurement
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, area: { left: 0, top: 0, width, height } };
}
