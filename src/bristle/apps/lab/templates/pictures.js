// A view as a file: drawn again on a separate canvas.

function near(value) { return Number(value.toFixed(2)); }

// A drawing context that also writes SVG. The real context keeps the styles, their history and the transformation.
function svgContext(width, height) {
  const own = document.createElement("canvas").getContext("2d"), parts = [], saved = [], font = 'font-family="system-ui, DejaVu Sans, sans-serif"';
  let path = "", clip = "", clips = 0;
  const put = (name, attributes, content = "") => {
    const { a, b, c, d, e, f, isIdentity } = own.getTransform(), moved = isIdentity ? "" : ` transform="matrix(${[a, b, c, d, e, f].map(near)})"`;
    const shape = `<${name} ${attributes}${moved}>${content}</${name}>`;
    parts.push(clip ? `<g ${clip}>${shape}</g>` : shape);
  };
  const drawn = {
    save() { own.save(); saved.push(clip); },
    restore() { own.restore(); clip = saved.pop(); },
    beginPath() { path = ""; },
    moveTo(x, y) { path += `M${near(x)} ${near(y)}`; },
    lineTo(x, y) { path += `${path ? "L" : "M"}${near(x)} ${near(y)}`; },
    rect(x, y, wide, high) { path += `M${near(x)} ${near(y)}h${near(wide)}v${near(high)}h${near(-wide)}z`; },
    arc(x, y, r) { path += `M${near(x - r)} ${near(y)}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`; },
    clip() {
      parts.push(`<clipPath id="c${clips}"><path d="${path}"/></clipPath>`);
      clip = `clip-path="url(#c${clips++})"`;
    },
    stroke() { put("path", `d="${path}" fill="none" stroke="${own.strokeStyle}" stroke-width="${own.lineWidth}" stroke-linejoin="${own.lineJoin}" stroke-dasharray="${own.getLineDash().join(" ") || "none"}"`); },
    fill() { put("path", `d="${path}" fill="${own.fillStyle}"`); },
    fillRect(x, y, wide, high) { put("rect", `x="${near(x)}" y="${near(y)}" width="${near(wide)}" height="${near(high)}" fill="${own.fillStyle}"`); },
    fillText(text, x, y) {
      const anchor = { center: "middle", right: "end" }[own.textAlign] ?? "start", size = parseFloat(own.font);
      const lower = { top: 0.8, middle: 0.35, bottom: -0.2 }[own.textBaseline] ?? 0, content = text.replaceAll("&", "&amp;").replaceAll("<", "&lt;");
      put("text", `x="${near(x)}" y="${near(y + lower * size)}" text-anchor="${anchor}" fill="${own.fillStyle}" font-size="${near(size)}" ${font}`, content);
    },
  };
  const context = new Proxy(own, { get: (_, name) => drawn[name] ?? own[name]?.bind?.(own) ?? own[name], set: (_, name, value) => Reflect.set(own, name, value) });
  // The namespace is an address, and this page contains no addresses: the browser knows it.
  const language = new DOMParser().parseFromString("<svg></svg>", "text/html").body.firstChild.namespaceURI;
  return { context, text: () => `<svg xmlns="${language}" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}">${parts.join("\n")}</svg>\n` };
}

// The drawing of a view on the background of the page.
function drawnBy(context, canvas, redraw) {
  context.fillStyle = getComputedStyle(document.body).backgroundColor;
  context.fillRect(0, 0, canvas.clientWidth, canvas.clientHeight);
  drawnOnto(canvas, context, redraw);
}

function asSvg(canvas, redraw) {
  const { context, text } = svgContext(canvas.clientWidth, canvas.clientHeight);
  drawnBy(context, canvas, redraw);
  return text();
}

// The view with three times as many pixels.
function asPng(canvas, redraw) {
  const big = element("canvas", { width: 3 * canvas.clientWidth, height: 3 * canvas.clientHeight }), context = big.getContext("2d");
  context.scale(3, 3);
  drawnBy(context, canvas, redraw);
  return new Promise((done) => big.toBlob(done, "image/png"));
}

async function download(canvas, kind, name, redraw) {
  const blob = kind === "PNG" ? await asPng(canvas, redraw) : new Blob([asSvg(canvas, redraw)], { type: "image/svg+xml" });
  const address = URL.createObjectURL(blob);
  element("a", { href: address, download: `${name}.${kind.toLowerCase()}` }).click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
}
