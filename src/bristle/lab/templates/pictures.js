// A view as a file: drawn again on a separate canvas.

// The canvas functions used by the views, as SVG. Each clip and each rotation opens a group until the state is restored.
class Paper {
  constructor(width, height, ground) {
    Object.assign(this, { width, height, parts: [`<rect width="${width}" height="${height}" fill="${ground}"/>`], clips: 0, open: 0, saved: [], path: "",
      strokeStyle: "#000", fillStyle: "#000", lineWidth: 1, lineJoin: "miter", font: "10px sans-serif", textAlign: "start", textBaseline: "alphabetic", dash: [] });
    this.measure = document.createElement("canvas").getContext("2d");
  }

  save() { this.saved.push({ open: this.open, state: Object.fromEntries(["strokeStyle", "fillStyle", "lineWidth", "lineJoin", "font", "textAlign", "textBaseline", "dash"].map((name) => [name, this[name]])) }); }
  restore() {
    const { open, state } = this.saved.pop();
    this.parts.push("</g>".repeat(this.open - open));
    Object.assign(this, state, { open });
  }
  group(attribute) {
    this.parts.push(`<g ${attribute}>`);
    this.open++;
  }
  translate(x, y) { this.group(`transform="translate(${near(x)} ${near(y)})"`); }
  rotate(angle) { this.group(`transform="rotate(${near(angle * 180 / Math.PI)})"`); }
  clip() {
    this.parts.push(`<clipPath id="c${this.clips}"><path d="${this.path}"/></clipPath>`);
    this.group(`clip-path="url(#c${this.clips++})"`);
  }
  beginPath() { this.path = ""; }
  moveTo(x, y) { this.path += `M${near(x)} ${near(y)}`; }
  lineTo(x, y) { this.path += `${this.path ? "L" : "M"}${near(x)} ${near(y)}`; }
  rect(x, y, width, height) { this.path += `M${near(x)} ${near(y)}h${near(width)}v${near(height)}h${near(-width)}z`; }
  arc(x, y, r) { this.path += `M${near(x - r)} ${near(y)}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`; }
  setLineDash(dash) { this.dash = dash; }
  stroke() {
    const dash = this.dash.length ? ` stroke-dasharray="${this.dash.join(" ")}"` : "";
    this.parts.push(`<path d="${this.path}" fill="none" stroke="${this.strokeStyle}" stroke-width="${this.lineWidth}" stroke-linejoin="${this.lineJoin}"${dash}/>`);
  }
  fill() { this.parts.push(`<path d="${this.path}" fill="${this.fillStyle}"/>`); }
  fillRect(x, y, width, height) { this.parts.push(`<rect x="${near(x)}" y="${near(y)}" width="${near(width)}" height="${near(height)}" fill="${this.fillStyle}"/>`); }
  measureText(text) {
    this.measure.font = this.font;
    return this.measure.measureText(text);
  }
  fillText(text, x, y) {
    const anchor = { center: "middle", right: "end" }[this.textAlign] ?? "start", size = parseFloat(this.font);
    const lower = { top: 0.8, middle: 0.35, bottom: -0.2 }[this.textBaseline] ?? 0;
    const plain = text.replaceAll("&", "&amp;").replaceAll("<", "&lt;");
    this.parts.push(`<text x="${near(x)}" y="${near(y + lower * size)}" text-anchor="${anchor}" fill="${this.fillStyle}" font-size="${near(size)}" font-family="system-ui, DejaVu Sans, sans-serif">${plain}</text>`);
  }
  text() {
    // The namespace is an address, and this page contains no addresses: the browser knows it.
    const language = new DOMParser().parseFromString("<svg></svg>", "text/html").body.firstChild.namespaceURI;
    return `<svg xmlns="${language}" width="${this.width}" height="${this.height}" viewBox="0 0 ${this.width} ${this.height}">${this.parts.join("\n")}</svg>\n`;
  }
}

function near(value) { return Number(value.toFixed(2)); }

// The drawing of a view, as SVG.
function asSvg(canvas, redraw) {
  const ground = getComputedStyle(document.body).backgroundColor;
  const paper = new Paper(canvas.clientWidth, canvas.clientHeight, ground);
  drawnOnto(canvas, paper, redraw);
  return paper.text();
}

// The view with three times as many pixels, on the background of the page.
function asPng(canvas, redraw) {
  const big = document.createElement("canvas"), context = big.getContext("2d"), times = 3;
  Object.assign(big, { width: times * canvas.clientWidth, height: times * canvas.clientHeight });
  context.scale(times, times);
  context.fillStyle = getComputedStyle(document.body).backgroundColor;
  context.fillRect(0, 0, big.width, big.height);
  drawnOnto(canvas, context, redraw);
  return new Promise((done) => big.toBlob(done, "image/png"));
}

async function download(canvas, kind, name, redraw) {
  const blob = kind === "PNG" ? await asPng(canvas, redraw) : new Blob([asSvg(canvas, redraw)], { type: "image/svg+xml" });
  const address = URL.createObjectURL(blob);
  element("a", { href: address, download: `${name}.${kind.toLowerCase()}` }).click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
}
