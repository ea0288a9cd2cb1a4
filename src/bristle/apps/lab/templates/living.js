// The sliders of a report: they compute the model along the log with changed values, and move its pictures.

const byId = (id) => document.getElementById(id);
const data = JSON.parse(byId("alive-data").textContent);
const variables = [...data.plant, ...data.model.variables];
const first = Object.fromEntries(variables.map(({ name, values }) => [name, numbersOf(values)]));
const alive = { contact: null, rows: null, values: {}, found: null, start: null, shown: {}, waits: false };
const BINS = 60, LINEAR = 0.01; // of velocity or displacement; share of the largest velocity

function computed(values) {
  for (const { name } of data.model.variables) alive.contact.set(name, values[name]);
  const forces = alive.rows.stretches.map((stretch) => forcesIn(alive.contact, stretch, alive.rows.sampleTime));
  const friction = weighed(alive.rows, forces), mechanical = mechanicalInRows(alive.rows, values);
  const predicted = friction.map((force, k) => force + mechanical[k]), { measured } = alive.rows;
  return { forces, friction, predicted, ...misfit(measured, predicted), taken: mechanical.map((effort, k) => measured[k] - effort) };
}

function isMoved() { return variables.some(({ name }) => alive.values[name].some((value, i) => value !== first[name][i])); }

// --- the pictures ---------------------------------------------------------------------------------------------------------

// Factor from an SI unit to the unit of an axis: a prefix of it.
function factorOf(word, unit) {
  const shown = word.match(/\[(.*)\]$/)?.[1] ?? unit, prefix = shown === unit ? "" : shown[0];
  return PREFIXES.find(([, , name]) => name === prefix)?.[1] ?? 1;
}

function isSeen(name) { return plots.get(name)?.svg.getClientRects().length > 0; }

// Shift the drawn lines of a model, in SI along x and y of their panel.
function shiftLines(panel, names, xUnit, shift) {
  const across = factorOf(panel.facts.x.word, xUnit), up = factorOf(panel.facts.y.word, data.effort), { left, right, top, bottom } = panel;
  const perUnit = (bottom - top) / (panel.facts.y.ends[1] - panel.facts.y.ends[0]) * up;
  for (const { name, node } of panel.curves) {
    const own = names.includes(name) && panel.artists.find((artist) => artist.node === node.querySelector("path[clip-path]"));
    if (!own) continue;
    own.original ??= own.d;
    own.d = !shift ? own.original : own.original.replace(PAIRS, (_, x, y) => `${x} ${near(Number(y) - perUnit * shift(panel.x.value((Number(x) - left) / (right - left)) / across))}`);
  }
  panel.redraw();
}

// The mean of values in bins; an empty bin has that of the nearest filled bin on its side of `middle`.
function meanInBins(count, middle, add) {
  const sums = new Float64Array(count), counts = new Float64Array(count), sideOf = (bin) => Math.sign(bin - middle);
  add((bin, value) => { sums[bin] += value; counts[bin]++; });
  return (bin) => {
    for (let away = 0; away < count; away++) for (const at of [bin + away, bin - away]) if (counts[at] && sideOf(at) * sideOf(bin) >= 0) return sums[at] / counts[at];
    return 0;
  };
}

function moveVelocity() {
  const panel = plots.get("velocity").panels[0], { velocity } = alive.rows, top = Math.max(...extent(velocity).map(Math.abs));
  const binOf = (v) => BINS + Math.max(-BINS, Math.min(BINS, Math.round(BINS * Math.asinh(v / (LINEAR * top)) / Math.asinh(1 / LINEAR))));
  const mean = meanInBins(2 * BINS + 1, BINS, (add) => velocity.forEach((v, k) => add(binOf(v), alive.found.friction[k] - alive.start.friction[k])));
  shiftLines(panel, ["model", "_same"], data.model.units.velocity, isMoved() ? (v) => mean(binOf(v)) : null);
}

function moveReversals() {
  const panel = plots.get("reversals").panels[0], end = panel.facts.x.ends[1] / factorOf(panel.facts.x.word, data.model.units.position);
  const binOf = (place) => Math.min(BINS, Math.floor(BINS * place / end));
  const mean = meanInBins(BINS + 1, -1, (add) => alive.rows.stretches.forEach(({ places, origin }, i) => {
    let way = 0, since = Infinity, last = origin;
    places.forEach((place, k) => {
      const step = place - last, turned = Math.sign(step);
      last = place;
      if (!turned) return;
      since = turned === way ? since + Math.abs(step) : way ? Math.abs(step) : Infinity;
      way = turned;
      if (since <= end) add(binOf(since), way * (alive.found.forces[i][k] - alive.start.forces[i][k]));
    });
  }));
  shiftLines(panel, ["model"], data.model.units.position, isMoved() ? (place) => mean(binOf(place)) : null);
}

// The effort of the model over time: extremes of each piece, and a gap where the log has one.
function moveEffort(name, curve) {
  for (const panel of plots.get(name).panels) {
    if (!isMoved()) { panel.setCurve(curve, null); continue; }
    const across = factorOf(panel.facts.x.word, "s"), up = factorOf(panel.facts.y.word, data.effort), { t, runs } = alive.rows, xs = [], ys = [];
    const [low, high] = panel.facts.x.ends.map((end) => end / across), step = Math.max(1, Math.floor(t.filter((time) => time >= low && time <= high).length / 1000));
    for (const [begin, end] of runs) {
      for (let k = begin; k <= end; k += step) {
        const piece = alive.found.predicted.subarray(k, Math.min(k + step, end + 1));
        if (t[k] >= low - 1 && t[k] <= high + 1) for (const value of step > 1 ? extent(piece) : piece) { xs.push(t[k] * across); ys.push(value * up); }
      }
      xs.push(NaN); ys.push(NaN);
    }
    panel.setCurve(curve, xs, ys);
  }
}

function movePictures() {
  if (isSeen("velocity")) moveVelocity();
  if (isSeen("reversals")) moveReversals();
  if (isSeen("effort")) moveEffort("effort", "model");
  if (isSeen("time")) moveEffort("time", "predicted");
}

// The instant of the large picture, marked in the small pictures: over velocity, and over displacement since the last reversal.
function markInstant(time) {
  const { t, velocity, stretches } = alive.rows, isLoop = plots.has("gain"), at = time + (isLoop ? stretches[0].time : 0), dt = t[1] - t[0];
  const k = t.findIndex((each) => each >= at), way = Math.sign(velocity[k]);
  if (k < 0 || isLoop && stretches.length > 1) return;
  let place = 0;
  for (let i = k; i >= 0 && Math.sign(velocity[i]) === way; i--) place += Math.abs(velocity[i]) * dt;
  const { units } = data.model;
  for (const [name, x, y, unit] of [["velocity", velocity[k], alive.found.taken[k], units.velocity], ["reversals", place, way * alive.found.taken[k], units.position]]) {
    const plot = plots.get(name), facts = plot?.panels[0].facts;
    plot?.mark(x * factorOf(facts.x.word, unit), y * factorOf(facts.y.word, data.effort));
  }
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
  movePictures();
  if (data.loop) follow();
}

function later() {
  if (!alive.waits) requestAnimationFrame(update);
  alive.waits = true;
}

function setValue({ name }, index, value, from) {
  const moved = alive.values[name].map((old, i) => (i === index ? value : old));
  alive.values[name] = data.model.shares.includes(name) && moved.length > 1 ? shared(moved, index) : moved;
  showIn(alive.shown[name], alive.values[name], index, from);
  later();
}

function cardsFor(variable) {
  return cardsOf(variable, first[variable.name].length, (i) => ({ input: (value, from) => setValue(variable, i, value, from), change: () => {},
    start: () => first[variable.name][i], text: (value) => (Number.isFinite(value) ? Number(value.toPrecision(5)) : value) }));
}

// Each card of the first screen unfolds the sliders of its parameters.
function buildCards() {
  const buttons = [...document.querySelectorAll(".unfold")], roots = new Map(), of = new Map();
  const owner = (name) => buttons.find(({ dataset }) => dataset.sliders.split(" ").includes(name)) ?? buttons.at(-1);
  for (const variable of variables) {
    alive.shown[variable.name] = cardsFor(variable);
    roots.set(variable.name, alive.shown[variable.name].map(({ root }) => root));
    of.set(variable.name, owner(variable.name));
    for (const root of roots.get(variable.name)) { root.hidden = true; byId("alive-cards").append(root); }
  }
  const show = () => {
    for (const [name, parts] of roots) for (const root of parts) root.hidden = of.get(name)?.getAttribute("aria-expanded") !== "true";
    byId("alive").hidden = !buttons.some((button) => button.getAttribute("aria-expanded") === "true");
  };
  for (const button of buttons) {
    button.hidden = ![...of.values()].includes(button);
    button.addEventListener("click", () => { button.setAttribute("aria-expanded", String(button.getAttribute("aria-expanded") !== "true")); show(); later(); });
  }
}

function reset() {
  alive.values = structuredClone(first);
  for (const { name } of variables) showIn(alive.shown[name], first[name]);
  later();
}

async function begin() {
  alive.contact = await loaded(data.model);
  alive.rows = await rowsOf(data.rows);
  alive.values = structuredClone(first);
  alive.start = alive.found = computed(alive.values);
  buildCards();
  if (data.loop) await drawTraces();
  reset();
  byId("alive-reset").addEventListener("click", reset);
  for (const name of ["gain", "effort"]) plots.get(name)?.figure.addEventListener("read", ({ detail }) => markInstant(detail));
  for (const input of document.querySelectorAll(".tabs > input")) input.addEventListener("change", later);
  document.body.dataset.alive = "ready";
}

begin();
