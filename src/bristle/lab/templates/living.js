// The interactive report: the residual in the fitted rows, with changed values.

const byId = (id) => document.getElementById(id);
const data = JSON.parse(byId("alive-data").textContent);
const variables = [...data.plant, ...data.model.variables];
const timeView = newView(), speedView = newView();
const first = Object.fromEntries(variables.map(({ name, values }) => [name, numbersOf(values)]));
const alive = { contact: null, rows: null, values: {}, found: null, start: null, theme: null, shown: {}, plots: [], waits: false };

function computed(values) {
  for (const { name } of data.model.variables) alive.contact.set(name, values[name]);
  const friction = frictionInRows(alive.contact, alive.rows), mechanical = mechanicalInRows(alive.rows, values);
  const predicted = friction.map((force, k) => force + mechanical[k]), { measured } = alive.rows;
  return { friction, predicted, ...misfit(measured, predicted), residual: predicted.map((effort, k) => measured[k] - effort),
    taken: mechanical.map((effort, k) => measured[k] - effort) };
}

function isMoved() { return variables.some(({ name }) => alive.values[name].some((value, i) => value !== first[name][i])); }

// --- what is drawn ------------------------------------------------------------------------------------------------------

function partOf({ t }, view) {
  const [low, high] = view.x ?? [t[0], t[t.length - 1]];
  return { low, high, from: Math.max(0, nearest(t, low) - 1), to: Math.min(t.length - 1, nearest(t, high) + 1) };
}

function timeFrame(canvas, view, word, curves) {
  const { rows, theme } = alive, { low, high, from, to } = partOf(rows, view), { context, area } = wiped(canvas);
  const ends = curves.map(([values]) => extent(values.subarray(from, to + 1)));
  const [bottom, top] = axis(Math.min(...ends.map(([least]) => least)), Math.max(...ends.map(([, most]) => most)));
  const frame = new Frame(context, area, { word: "time", unit: "s", low, high }, { word, unit: data.effort, low: bottom, high: top }, theme);
  frame.axes();
  for (const [values, look] of curves) {
    for (const [begin, end] of rows.runs) {
      if (end >= from && begin <= to) frame.curve(rows.t, values, { ...look, first: Math.max(begin, from), last: Math.min(end, to) });
    }
  }
  return frame;
}

function effortPlot(canvas, view) {
  const { theme, found, rows } = alive;
  return timeFrame(canvas, view, data.word, [[rows.measured, { colour: theme.measured, width: 3 }], [found.predicted, { colour: theme.accent, width: 1.2 }]]);
}

function residualPlot(canvas, view) {
  const { theme, found, start } = alive, before = isMoved() ? [[start.residual, { colour: theme.ghost, width: 2.4 }]] : [];
  return timeFrame(canvas, view, "residual", [...before, [found.residual, { colour: theme.accent, width: 1 }]]);
}

function rowAt(frame, x) { return nearest(alive.rows.t, frame.valueAt(x)); }

function rowFurther(frame, row, way) {
  const step = Math.max(1, Math.round((frame.x.high - frame.x.low) / 300 / (alive.rows.t[1] - alive.rows.t[0])));
  return Math.max(0, Math.min(alive.rows.t.length - 1, row + way * step));
}

function rowTold(row) {
  const { rows, found } = alive, say = (value) => told(value, data.effort);
  return `At ${told(rows.t[row], "s", 6)}: measured ${say(rows.measured[row])}, predicted ${say(found.predicted[row])}, residual ${say(found.residual[row])}; velocity ${told(rows.velocity[row], data.model.units.velocity)}.`;
}

function markRow(frame, row, values) {
  frame.upright(alive.rows.t[row], alive.theme.soft);
  for (const [value, colour] of values) frame.dot(alive.rows.t[row], value, colour, 4);
  return rowTold(row);
}

function frictionPlot(canvas, view) {
  const { rows, found, theme } = alive, { velocity } = rows, { context, area } = wiped(canvas), { units } = data.model;
  const [left, right] = view.x ?? axis(...extent(velocity)), [low, high] = extent(found.taken), [least, most] = extent(found.friction);
  const [bottom, top] = view.y ?? axis(Math.min(low, least), Math.max(high, most));
  const frame = new Frame(context, area, { word: "velocity", unit: units.velocity, low: left, high: right },
    { word: "friction", unit: data.effort, low: bottom, high: top }, theme);
  frame.axes();
  frame.points(velocity, found.taken, { colour: theme.measured, size: 3.4 });
  frame.points(velocity, found.friction, { colour: theme.accent, size: 1.8 });
  return frame;
}

function pointAt(frame, x, y) {
  const { rows, found } = alive;
  let best = 0, least = Infinity;
  rows.velocity.forEach((velocity, k) => {
    const away = (frame.across(velocity) - x) ** 2 + (frame.up(found.taken[k]) - y) ** 2;
    if (away < least) [best, least] = [k, away];
  });
  return best;
}

function markPoint(frame, row) {
  const { rows, found, theme } = alive, at = rows.velocity[row];
  frame.clip(() => {
    frame.dot(at, found.taken[row], theme.ink, 4);
    frame.dot(at, found.friction[row], theme.accent, 4);
  });
  return `At ${told(at, data.model.units.velocity)}: friction measured ${told(found.taken[row], data.effort)}, model ${told(found.friction[row], data.effort)}; ${told(rows.t[row], "s", 6)} into the log.`;
}

function buildPlots() {
  const time = { pick: rowAt, shift: rowFurther };
  const of = (name, view, parts) => new Pointed(byId(`alive-${name}`), byId(`alive-${name}-reading`), view, parts);
  alive.plots = [
    of("effort", timeView, { ...time, draw: effortPlot,
      tell: (frame, row) => markRow(frame, row, [[alive.rows.measured[row], alive.theme.measured], [alive.found.predicted[row], alive.theme.accent]]) }),
    of("residual", timeView, { ...time, draw: residualPlot, tell: (frame, row) => markRow(frame, row, [[alive.found.residual[row], alive.theme.accent]]) }),
    of("friction", speedView, { draw: frictionPlot, pick: pointAt, shift: (frame, row, way) => Math.max(0, Math.min(alive.rows.t.length - 1, row + way)), tell: markPoint, both: true }),
  ];
  if (data.loop) alive.plots.push(...followingPlots(of));
}

// --- values ---------------------------------------------------------------------------------------------------------------

function summed() {
  const { found, start, rows } = alive, say = ({ rms, share }) => `${told(rms, data.effort)} rms, ${withDigits(100 * share, 3)} % of the effort`;
  const fit = `in the report: ${told(rows.rms, data.effort)}`;
  return isMoved() ? `Residual: ${say(found)}. With the identified values: ${told(start.rms, data.effort)}; ${fit}.` : `Residual: ${say(found)}; ${fit}.`;
}

function update() {
  alive.waits = false;
  alive.found = isMoved() ? computed(alive.values) : alive.start;
  byId("alive-told").textContent = summed();
  byId("alive-reset").disabled = !isMoved();
  const lines = brokenLines(data.model, alive.values);
  if (byId("alive-broken").innerHTML !== lines) byId("alive-broken").innerHTML = lines;
  for (const plot of alive.plots) plot.show();
  if (data.loop) follow();
}

function later() {
  if (!alive.waits) requestAnimationFrame(update);
  alive.waits = true;
}

function setValue({ name }, index, value, from) {
  const moved = alive.values[name].map((old, i) => (i === index ? value : old));
  alive.values[name] = data.model.shares.includes(name) && moved.length > 1 ? shared(moved, index) : moved;
  alive.shown[name].forEach((each, i) => each.show(alive.values[name][i], i === index ? from : "field"));
  later();
}

function cardsFor(variable) {
  const handlers = (i) => ({ input: (value, from) => setValue(variable, i, value, from), change: () => {},
    start: () => first[variable.name][i], text: (value) => (Number.isFinite(value) ? Number(value.toPrecision(5)) : value) });
  if (variable.choices.length) return [choice(variable, handlers(0))];
  return first[variable.name].map((_, i) => control(variable, i, handlers(i)));
}

function buildCards() {
  const others = element("details", {}, element("summary", { text: "Not identified from this log, or held constant" }));
  for (const variable of variables) {
    const made = alive.shown[variable.name] = cardsFor(variable), roots = made.map(({ root }) => root);
    (variable.status === "identified" ? byId("alive-cards") : others).append(...roots);
  }
  if (others.children.length > 1) byId("alive-cards").append(others);
}

function reset() {
  for (const { name } of variables) {
    alive.values[name] = [...first[name]];
    alive.shown[name].forEach((each, i) => each.show(first[name][i]));
  }
  later();
}

async function begin() {
  alive.contact = await loaded(data.model);
  alive.rows = rowsOf(data.rows);
  alive.values = Object.fromEntries(Object.entries(first).map(([name, values]) => [name, [...values]]));
  alive.start = alive.found = computed(alive.values);
  byId("alive").hidden = false;
  alive.theme = colours(byId("alive"));
  buildCards();
  buildPlots();
  reset();
  byId("alive-reset").addEventListener("click", reset);
  byId("alive-whole").addEventListener("click", () => { for (const plot of alive.plots) plot.look(null); });
  const observer = new ResizeObserver((entries) => {
    for (const { target } of entries) resized(target);
    alive.theme = colours(byId("alive"));
    for (const plot of alive.plots) plot.later();
  });
  for (const { canvas } of alive.plots) observer.observe(canvas);
}

begin();
