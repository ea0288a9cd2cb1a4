// Tables and lists of text.

function tableOf({ caption, heads, rows, numbers = [] }) {
  const side = (column) => (numbers[column] ? { class: "number" } : {});
  return element("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption },
    element("table", {},
      element("caption", { text: caption }),
      element("thead", {}, element("tr", {}, ...heads.map((head, i) => element("th", { scope: "col", text: head, ...side(i) })))),
      element("tbody", {}, ...rows.map((row) => element("tr", {},
        ...row.map((cell, i) => element(i ? "td" : "th", { text: cell, ...(i ? {} : { scope: "row" }), ...side(i) })))))));
}

function button(text, act, attributes = {}) { return element("button", { type: "button", text, onclick: act, ...attributes }); }

function labelled(word, input) { return element("label", {}, element("span", { text: word }), input); }

// A table with a button that copies it for a spreadsheet.
function copied(table) {
  const text = [table.heads, ...table.rows].map((row) => row.join("\t")).join("\n");
  const copy = button("Copy table", () => navigator.clipboard.writeText(text).then(() => { copy.textContent = "Copied"; }));
  return element("div", { class: "copied" }, tableOf(table), copy);
}

function listOf(lines, name = "told") {
  return lines?.length ? element("ul", { class: name }, ...lines.map((text) => element("li", {}, ...withCode(text)))) : null;
}

// Text with terminal commands between grave accents.
function withCode(text) { return text.split("`").map((part, i) => (i % 2 ? element("code", { text: part }) : part)); }

function sizeText(bytes) {
  const [factor, unit] = bytes >= 1e6 ? [1e6, "MB"] : [1e3, "kB"];
  return `${Number((bytes / factor).toPrecision(3))} ${unit}`;
}

function folded(summary, ...children) {
  return element("details", {}, element("summary", { text: summary }), ...children);
}

// A picture with its caption, which names the colour of each curve, drawn when it is on the page and again when its size changes.
const drawn = new Map();
const watch = new ResizeObserver((entries) => {
  for (const entry of entries) {
    resized(entry);
    drawn.get(entry.target)?.();
  }
});

function pictureOf(label, draw, ...curves) {
  const canvas = element("canvas", { role: "img", "aria-label": label });
  drawn.set(canvas, () => canvas.isConnected ? draw(canvas, colours()) : (drawn.delete(canvas), watch.unobserve(canvas)));
  watch.observe(canvas);
  return element("figure", {}, element("figcaption", {}, `${label} `, ...curves.map(([colour, text]) => element("span", { class: `key ${colour}`, text }))), canvas);
}

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => drawn.forEach((draw) => draw()));
