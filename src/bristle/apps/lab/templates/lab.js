// The page: layout, history, and computation after a move.

const byId = (id) => document.getElementById(id);
const ready = new Map();
const past = [], future = [];
const SLOTS = ["asymmetry", "position", "ripple", "periodic", "load", "temperature", "transmitted"];
const TABS = { speed: "Over velocity", track: "Closed loop", plane: "Memory", checks: "Checks" };
const USUAL_PATH = "triangle", MOST_PAST = 200, MOST_TURNS = 400;
const LONG = 6, LONG_LOOP = 8, PAUSE = 80, JUDGED = 150, STANDS = 120, ONE_STEP = 1000; // [ms]
let data = null, usual = null, kept = "", keptBy = "", keptAt = 0, tab = "speed", frames = 0, waiting = 0, settling = 0, loopTook = 0, restTook = 0, judging = 0, verdictTook = 0, shown = {};

const lab = newBench(colours()), plots = newPlots();

// --- drawing ----------------------------------------------------------------------------------------------------------

// While a slider moves, a slow loop has fewer samples; at rest it has all of them.
function drawNow(moves = false) {
  const before = performance.now(), isLong = moves && loopTook > LONG_LOOP;
  clearTimeout(settling);
  settling = isLong ? setTimeout(drawNow, STANDS) : 0;
  lab.samples = isLong ? samplesWithin(loopTook / LONG_LOOP) : SAMPLES;
  syncPin();
  drawMoment(true);
  if (!isLong) loopTook = performance.now() - before;
}

// The present moment of the run: machine, loop, memory and chapter.
function drawMoment(all = false) {
  plots.loop.show();
  const { word, velocity, x } = machineView(lab, byId("machine")), { position, velocity: unit } = lab.model.units;
  const text = `The block ${word}: ${told(x, position)}, ${word === "holds" ? "at rest" : told(velocity, unit)}.`;
  frames++;
  if (all || frames % 6 === 0) {
    byId("machine-reading").textContent = text;
    if (tab === "plane") plots.plane.show();
  }
  if (tab === "track" && lab.preset === "tracked") plots.track.show();
  byId("moment").value = Math.round(1000 * lab.moment);
  checkChapter();
}

function drawRest() {
  const before = performance.now();
  waiting = 0;
  for (const name of ["speed", "track"].filter((each) => each === tab)) plots[name].show();
  if (tab === "checks" && !judging) judging = setTimeout(judge, verdictTook > LONG ? JUDGED : 0);
  if (tab === "track" || lab.preset === "tracked") track(lab);
  restTook = performance.now() - before;
}

// Verdicts change during a move, but not in every frame.
function judge() {
  const before = performance.now();
  judging = 0;
  verdictView(lab, byId("verdicts"));
  verdictTook = performance.now() - before;
}

// The loop is drawn at once, the rest later: less often if it is so slow that a slider would lag.
function draw(moves = false) {
  drawNow(moves);
  if (!waiting) waiting = setTimeout(drawRest, restTook > LONG ? PAUSE : 0);
}

// --- values -------------------------------------------------------------------------------------------------------------

function setValue({ name }, index, value, from) {
  lab.move(name, index, value);
  showIn(shown[name], lab.values[name], index, from);
  tellBroken();
  draw(from === "slider");
}

function showAll() {
  lab.setAll(lab.values);
  for (const { name } of lab.all()) showIn(shown[name], lab.values[name]);
  byId("moment").value = Math.round(1000 * lab.moment);
  byId("path").value = lab.preset;
  tellBroken();
  draw();
}

function tellBroken() {
  const html = brokenLines(lab.model, lab.values);
  if (byId("broken").innerHTML !== html) byId("broken").innerHTML = html;
}

function cardsFor(variable) {
  const { name } = variable;
  return cardsOf(variable, lab.values[name].length, (i) => ({ input: (value, from) => setValue(variable, i, value, from), change: () => keep(name + i), start: () => lab.first[name][i] }));
}

function buildCards() {
  shown = {};
  const cards = byId("cards"), added = byId("slot-cards");
  cards.replaceChildren();
  added.replaceChildren();
  for (const variable of [...lab.model.variables, ...lab.model.around]) {
    const made = shown[variable.name] = cardsFor(variable);
    const roots = made.map(({ root }) => root);
    if (variable.slot) added.append(...roots);
    else if (variable.array) {
      cards.append(element("details", { class: "many", open: roots.length <= 4 },
        element("summary", { html: `<span class="symbol">${variable.symbol}</span>`, }, ` ${variable.description}`), ...roots));
    } else cards.append(...roots);
  }
  for (const group of document.querySelectorAll("[data-settings]")) {
    group.replaceChildren();
    for (const name of group.dataset.settings.split(" ")) {
      const variable = lab.settings.find((each) => each.name === name);
      shown[name] = cardsFor(variable);
      group.append(...shown[name].map(({ root }) => root));
    }
  }
  buildHandles();
}

// --- the history, and the link --------------------------------------------------------------------------------------

// Every value that differs from its initial value, for the link.
function stateText() {
  const changed = new URLSearchParams(), ofChapter = new URLSearchParams(CHAPTERS[lab.chapter - 1]?.state);
  if (lab.chapter) changed.set("chapter", lab.chapter);
  const { plain, slots, name } = lab.model;
  if (plain !== usual || lab.chapter) changed.set("model", name);
  if (String(slots) !== String(ownSlots(plain))) changed.set("slots", slots.join(" "));
  if (lab.preset !== USUAL_PATH) changed.set("path", lab.preset);
  if (lab.pin || ofChapter.has("with")) changed.set("with", lab.pin?.model.name ?? "");
  if (lab.preset === "drawn") changed.set("turns", lab.turns.map((turn) => Number(turn.toFixed(4))).join(" "));
  for (const { name } of lab.all()) {
    const values = lab.values[name];
    if (ofChapter.has(name) || values.some((value, i) => value !== lab.first[name][i])) changed.set(name, values.map(typed).join(" "));
  }
  return changed.toString();
}

// Presses on one control within a second are one step of the history.
function keep(by = "") {
  const text = stateText(), now = performance.now(), goesOn = by && by === keptBy && now - keptAt < ONE_STEP;
  if (settling) drawNow();
  if (text !== kept) {
    if (!goesOn) past.push(kept);
    if (past.length > MOST_PAST) past.shift();
    future.length = 0;
    [keptBy, keptAt] = [by, now];
  }
  settle(text);
}

function settle(text) {
  kept = text;
  byId("undo").disabled = past.length === 0;
  byId("redo").disabled = future.length === 0;
  try {
    history.replaceState(null, "", text ? `#${text}` : location.pathname + location.search);
  } catch { /* if a host forbids it, "Copy link" still gives the link */ }
}

async function go(text) {
  const given = new URLSearchParams(text), chapter = CHAPTERS[given.get("chapter") - 1], wanted = new URLSearchParams(chapter?.state);
  for (const [name, value] of given) wanted.set(name, value);
  const model = data.models.find(({ name }) => name === wanted.get("model")) ?? usual;
  await show(model, wanted.has("slots") ? wanted.get("slots").split(" ") : undefined);
  lab.aim(wanted.get("path") in PRESETS && wanted.get("path") !== "hand" ? wanted.get("path") : USUAL_PATH);
  lab.chapter = chapter ? CHAPTERS.indexOf(chapter) + 1 : 0;
  const turns = (wanted.get("turns") ?? "").split(" ").map(read).filter((turn) => Math.abs(turn) <= 2);
  lab.turns = turns.length ? turns.slice(0, MOST_TURNS) : [0];
  for (const variable of lab.all()) {
    const values = (wanted.get(variable.name) ?? "").split(" ").map(read);
    const fits = values.length === lab.first[variable.name].length && !variable.fixed
      && values.every((value) => value >= Number(variable.min) && value <= Number(variable.max) || value in variable.choices);
    lab.values[variable.name] = fits ? values : [...lab.first[variable.name]];
  }
  await pinModel(wanted.get("with"));
  if (chapter) openTab(chapter.tab ?? "speed");
  tellChapter();
  showAll();
}

async function step(from, to) {
  if (!from.length) return;
  to.push(kept);
  await go(from.pop());
  keptBy = "";
  settle(stateText());
}

async function contactOf(model) {
  if (!ready.has(model.code)) ready.set(model.code, await loaded(model));
  return ready.get(model.code);
}

async function show(plain, slots = ownSlots(plain)) {
  const offers = data.slots[plain.kind], model = withSlots(plain, slots, offers), first = withSlots(plain, ownSlots(plain), offers);
  const start = { model: first, contact: await contactOf(first) };
  lab.take(model, await contactOf(model), settingsOf(model, data.loop), start);
  lab.judge = await contactOf(plain.leans ? model : plain);
  byId("model").value = String(data.models.indexOf(plain));
  byId("description").textContent = `${model.description[0].toUpperCase()}${model.description.slice(1)}.`;
  lab.live = await loaded(model);
  for (const plot of Object.values(plots)) plot.look();
  byId("tab-plane").hidden = !model.stack && !model.elements;
  openTab(tab === "plane" && byId("tab-plane").hidden ? "speed" : tab);
  byId("plane-title").textContent = `Memory of the ${model.stack ? "operator" : "elements"}`;
  byId("plane").setAttribute("aria-label", model.stack
    ? "Preisach plane with the staircase between relays that are up and relays that are down"
    : "Force of each element, as a bar between its slip limits");
  byId("python").disabled = !model.head.python;
  buildSlots();
  buildCards();
}

// Another set of slots; moved values and the path stay.
async function putSlots(slots) {
  const { values, preset, turns, moment } = lab;
  await show(lab.model.plain, slots);
  lab.aim(preset);
  const settings = Object.fromEntries(lab.settings.filter(({ name }) => values[name]).map(({ name }) => [name, values[name]]));
  Object.assign(lab, { turns, moment, values: { ...lab.values, ...settings, ...carried(values, lab.model.variables) } });
  showAll();
  keep();
}

function buildSlots() {
  const { plain, slots } = lab.model, group = byId("slots"), focused = document.activeElement?.name;
  const offered = SLOTS.filter((slot) => plain.offered.includes(slot));
  group.replaceChildren(...offered.map((slot) => element("label", {},
    element("input", { type: "checkbox", name: `slot-${slot}`, checked: slots.includes(slot),
      onchange: () => putSlots(offered.filter((each) => group.querySelector(`[name="slot-${each}"]`).checked)) }),
    element("span", { text: slot, title: data.slots[plain.kind][slot].does }))));
  group.querySelector(`[name="${focused}"]`)?.focus();
}

function takePath(preset) {
  if (preset === "hand") takeSpring();
  else {
    if (preset === "drawn") lab.turns = [0];
    lab.aim(preset);
    leaveChapter();
    plots.loop.look();
    showAll();
    lab.moment = 0;
  }
  play(preset !== "drawn");
  keep();
}

function openTab(name) {
  tab = name;
  for (const button of byId("tabs").children) {
    button.setAttribute("aria-selected", String(button.value === name));
    byId(`view-${button.value}`).hidden = button.value !== name;
  }
  if (lab.contact) draw();
}

// --- the rest ---------------------------------------------------------------------------------------------------------------

function say(text) { byId("said").textContent = text; }

async function copy(text, what) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    return say(`The browser does not allow copying. ${what}: ${text}`);
  }
  return say(`${what} copied.`);
}

async function selfTest() {
  byId("test").hidden = false;
  let differ = 0, of = 0;
  for (const model of data.models) {
    const counts = await walkedWithSlots(model, data.slots[model.kind]);
    differ += counts.differ;
    of += counts.of;
  }
  byId("selftest").textContent = `${differ} of ${of} blocks differ`;
}

function offerFiles() {
  for (const [id, plot] of Object.entries(plots)) {
    const canvas = byId(id), name = () => `${lab.model.model.replaceAll("+", "_")}_${id}`, title = canvas.closest("section").querySelector("h2");
    const buttons = ["SVG", "PNG"].map((kind) => element("button", { type: "button", text: kind, "aria-label": `${title.textContent}, ${canvas.id}, as ${kind}`,
      onclick: () => download(canvas, kind, name(), () => plot.show()) }));
    byId(`${id}-reading`).after(element("div", { class: "files" }, ...buttons));
  }
}

function listen() {
  offerFiles();
  buildChapters();
  byId("with").append(...data.models.filter(({ own }) => !own).map(({ name }) => element("option", { value: name, text: name })));
  byId("with").addEventListener("change", async (event) => { await pinModel(event.target.value); showAll(); keep(); });
  byId("path").append(...Object.entries(PRESETS).map(([name, { word }]) => element("option", { value: name, text: word })));
  byId("path").addEventListener("change", (event) => takePath(event.target.value));
  byId("tabs").append(...Object.entries(TABS).map(([name, text]) => element("button", { type: "button", role: "tab", id: `tab-${name}`, value: name, text, "aria-controls": `view-${name}`, onclick: () => openTab(name) })));
  byId("play").addEventListener("click", () => play(!clock.plays));
  byId("more").addEventListener("click", () => byId("more").setAttribute("aria-expanded", String(!(byId("parameters").hidden = !byId("parameters").hidden))));
  byId("model").append(...data.models.map(({ name }, i) => element("option", { value: i, text: name })));
  byId("model").addEventListener("change", async (event) => {
    const preset = lab.preset === "hand" ? USUAL_PATH : lab.preset, { pin } = lab;
    await show(data.models[Number(event.target.value)]);
    lab.aim(preset);
    leaveChapter();
    await pinModel(pin?.model.name);
    showAll();
    keep();
  });
  byId("moment").addEventListener("input", (event) => { play(false); lab.moment = Number(event.target.value) / 1000; drawMoment(true); });
  byId("undo").addEventListener("click", () => step(past, future));
  byId("redo").addEventListener("click", () => step(future, past));
  byId("reset").addEventListener("click", async () => { await show(lab.model.plain); lab.aim(USUAL_PATH); leaveChapter(); await pinModel(""); showAll(); keep(); });
  byId("link").addEventListener("click", () => copy(`${location.href.split("#")[0]}#${stateText()}`, "Link"));
  byId("toml").addEventListener("click", () => copy(asToml(lab.model, lab.values), "TOML"));
  byId("python").addEventListener("click", () => copy(asPython(lab.model, lab.values), "Python"));
  document.addEventListener("keydown", (event) => {
    if (event.key === " " && !event.target.closest("button, input, select, summary")) {
      event.preventDefault();
      play(!clock.plays);
    }
    if (!(event.ctrlKey || event.metaKey) || event.target.matches("input[type=text]")) return;
    const key = event.key.toLowerCase();
    if (key === "z" || key === "y") {
      event.preventDefault();
      if (key === "y" || event.shiftKey) step(future, past);
      else step(past, future);
    }
  });
  window.addEventListener("hashchange", async () => {
    if (location.hash === "#selftest") return selfTest();
    if (location.hash === "#machine" || location.hash.slice(1) === kept) return null;
    return openAndPlay(location.hash.slice(1));
  });
  followPointer(byId("machine"));
  const redraw = () => {
    lab.theme = colours();
    drawNow(Boolean(settling));
    drawRest();
  };
  const observer = new ResizeObserver((entries) => {
    entries.forEach(resized);
    lab.machine = machineOf(byId("machine").clientWidth);
    if (lab.contact) redraw();
  });
  for (const canvas of document.querySelectorAll("canvas")) observer.observe(canvas);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
}

async function begin() {
  data = JSON.parse(new TextDecoder().decode(await inflated(JSON.parse(byId("data").textContent).code)));
  for (const model of data.models) {
    Object.assign(model, { before: [data.common] });
    Object.assign(model.wide, { before: [data.common, { code: model.code, before: [data.common] }] });
  }
  usual = data.models[data.first];
  lab.machine = machineOf(byId("machine").clientWidth);
  listen();
  const text = location.hash.slice(1);
  await go(text === "selftest" ? "" : text);
  past.length = 0;
  if (text === "selftest") await selfTest();
  else settle(stateText());
  lab.moment = 0;
  if (window.matchMedia("(prefers-reduced-motion: reduce)").matches || text === "selftest") lab.moment = 1, drawMoment(true);
  else play(true);
}

const begun = begin();
