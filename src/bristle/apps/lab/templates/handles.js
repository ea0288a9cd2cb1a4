// Handles on the curves: each moves a parameter of the model, by pointer or by keys, where the model has that parameter.

const STIFFNESS = { names: ["sigma_0", "s", "k_i", "alpha"], unit: /^N(·m)?\/(m|rad)$/ };
const LEVEL = { names: ["F_C", "f_p"] }, PEAK = { names: ["F_S"] }, CORNER = { names: ["v_S"] }, VISCOUS = { names: ["sigma_2", "F_v"] };
const SAME = [["sigma_0", "s"], ["F_C"], ["F_S"], ["v_S"], ["sigma_1"], ["sigma_2", "F_v"], ["f_p"], ["offset"]]; // in two models
const STEP = 1.03, LEAP = 1.2, HIDDEN = 4; // factor of a key, with Shift, [px]

// The parameters of a role: one, one per direction, or a list.
function familyOf({ model, values }, { names, unit = /./ }) {
  const of = (name) => model.variables.filter((row) => [name, `${name}_pos`, `${name}_neg`].includes(row.name) && unit.test(row.unit) && !row.fixed);
  const rows = names.map(of).find((found) => found.length);
  if (!rows) return null;
  const numbers = rows.map((row) => values[row.name].reduce((sum, value) => sum + value, 0));
  return { rows, value: numbers.reduce((sum, number) => sum + number, 0) / rows.length, unit: rows[0].unit, symbol: rows[0].symbol.replace(/[+−](?=<\/sub>)/, "") };
}

// Where each handle lies in its plot, and the value that belongs to another place.
const HANDLES = [
  { key: "slope", plot: "loop", role: STIFFNESS, word: "initial slope: stiffness of the bristles",
    at: (value) => [slopeForce() / value, slopeForce()], from: (x) => slopeForce() / x },
  { key: "plateau", plot: "loop", role: LEVEL, word: "plateau: friction level in sliding", edge: 20, at: (value) => [0, value], from: (x, up) => up },
  { key: "break", plot: "loop", role: PEAK, word: "break-away level", edge: 60, at: (value) => [0, value], from: (x, up) => up },
  { key: "peak", plot: "speed", role: PEAK, word: "peak at low velocity", at: (value) => [0.02 * valueOf(lab, "top"), value], from: (x, up) => up },
  { key: "corner", plot: "speed", role: CORNER, word: "corner: Stribeck velocity", at: (value) => [value, steadyAt(value)], from: (x) => x },
  { key: "rise", plot: "speed", role: VISCOUS, word: "rise with velocity", at: () => [0.6 * valueOf(lab, "top"), steadyAt(0.6 * valueOf(lab, "top"))],
    from: (x, up, value) => value + (up - steadyAt(0.6 * valueOf(lab, "top"))) / (0.6 * valueOf(lab, "top")) },
];
let handles = [], grip = "";

function slopeForce() { return 0.4 * Math.min(lab.level, familyOf(lab, LEVEL)?.value ?? Infinity); }

function steadyAt(velocity) {
  const { force } = sweptOf(lab), half = (SWEPT - 1) / 2, share = 0.5 * (1 - velocity / valueOf(lab, "top"));
  return force[Math.max(1, Math.min(half, Math.round(share * half)))];
}

function buildHandles() {
  for (const { root } of handles) root.remove();
  handles = HANDLES.filter(({ role }) => familyOf(lab, role)).map((handle) => {
    const root = element("div", { class: "handle", role: "slider", tabindex: 0, "aria-label": handle.word, html: familyOf(lab, handle.role).symbol, "data-key": handle.key });
    byId(handle.plot).parentElement.append(root);
    holdHandle(handle, root);
    return { ...handle, root };
  });
  byId("grips").replaceChildren(...handles.filter(({ key }) => key !== "peak").map(({ key, root, word }) => element("button", { type: "button", value: key, html: root.innerHTML, "aria-label": word, onclick: () => choose(key) })));
  choose((handles.find(({ key }) => key === grip) ?? handles.find(({ key }) => key === "plateau") ?? handles[0])?.key ?? "");
}

// On a narrow page one handle shows at a time.
function choose(key) {
  grip = key;
  for (const handle of handles) handle.root.classList.toggle("current", handle.key === key);
  for (const button of byId("grips").children) button.setAttribute("aria-pressed", String(button.value === key));
  if (lab.run && tab !== "speed" && handles.find((handle) => handle.key === key)?.plot === "speed") openTab("speed");
}

function holdHandle(handle, root) {
  const value = () => familyOf(lab, handle.role).value;
  dragged(root, (event) => {
    choose(handle.key);
    event.stopPropagation();
    return byId(handle.plot).getBoundingClientRect();
  }, (event, { left, top }) => {
    const frame = handle.plot === "loop" ? lab.frame : plots.speed.frame;
    const x = Math.max(frame.valueAt(event.clientX - left), frame.valueAt(frame.across(0) + 1));
    moveFamily(handle.role, handle.from(x, frame.valueUp(event.clientY - top), value()));
  });
  steered(root, handle.key, (event, way) => moveFamily(handle.role, value() * (event.shiftKey ? LEAP : STEP) ** way));
}

// Move all parameters of a role by one factor, within their ranges and conditions.
function moveFamily(role, wanted) {
  const { rows, value } = familyOf(lab, role), factor = value > 0 ? wanted / value : NaN;
  const moved = Object.fromEntries(rows.map(({ name, min, max }) =>
    [name, lab.values[name].map((each) => Number(Math.min(Math.max(Number.isFinite(factor) ? each * factor : wanted, Number(min)), Number(max)).toPrecision(4)))]));
  if (!(wanted > 0) || broken(lab.model, { ...lab.values, ...moved }).length > broken(lab.model, lab.values).length) return;
  for (const [name, list] of Object.entries(moved)) {
    lab.values[name] = list;
    lab.contact.set(name, list);
    showIn(shown[name], list);
  }
  tellBroken();
  draw(true);
}

// Put the handles where their parameters are, with the lines they hold.
function placeHandles(plot, frame) {
  for (const { key, root, role, word, at, edge, plot: own } of handles) {
    if (own !== plot || lab.machine.narrow && key !== grip) continue;
    const family = familyOf(lab, role); // none while another model is on its way
    if (!family) continue;
    const { value, unit } = family, [x, up] = at(value), px = edge ? frame.right - edge : frame.across(x), py = frame.up(up);
    const steep = !edge && plot === "loop" && px - frame.across(0) < HIDDEN, virgin = edge || plot === "speed" || !["hand", "tracked"].includes(lab.preset);
    const inside = px > frame.left && px <= frame.right && py >= frame.top && py <= frame.bottom && !steep && virgin;
    root.hidden = !inside;
    if (!inside) continue;
    if (plot === "loop") frame.curve(edge ? [frame.x.low, frame.x.high] : [0, x], edge ? [up, up] : [0, up], { colour: frame.theme.soft, width: 1, dash: [2, 4] });
    const text = told(value, unit);
    frame.label(text, edge ? frame.valueAt(px - 12) : frame.valueAt(px + 10), frame.valueUp(py - (edge ? 0 : 2)), frame.theme.ink, edge ? "right" : "left");
    const now = Number(value.toPrecision(4));
    root.style.setProperty("transform", `translate(${Math.round(px)}px, ${Math.round(py)}px)`);
    if (root.title === `${word}: ${text}`) continue;
    root.title = `${word}: ${text}`;
    for (const [name, content] of [["now", now], ["min", 0], ["max", 100 * now], ["text", text]]) root.setAttribute(`aria-value${name}`, content);
  }
}

// --- a second model on the same path ---------------------------------------------------------------------------------------

async function pinModel(name) {
  const plain = data.models.find((model) => model.name === name);
  if (!plain || plain.kind !== lab.model.kind) lab.pin = null;
  else {
    const model = withSlots(plain, ownSlots(plain), data.slots[plain.kind]), pin = newBench(lab.theme);
    pin.take(model, await loaded(model), lab.settings);
    lab.pin = pin;
  }
  byId("with").value = lab.pin ? name : "";
}

// The second model has the same path, and the values of the parameters that both have.
function syncPin() {
  const { pin, theme, preset, turns, samples, level, tracked: found, trackedKey, values } = lab;
  if (!pin) return;
  const both = SAME.map((names) => [pin.first, values].map((each) => names.find((name) => each[name]))).filter(([to, from]) => to && from);
  const settings = lab.settings.map(({ name }) => [name, values[name]]);
  Object.assign(pin, { theme, preset, turns, samples, level, tracked: found, trackedKey, settings: lab.settings, values: { ...pin.first, ...Object.fromEntries([...settings, ...both.map(([to, from]) => [to, values[from]])]) } });
  pin.setAll(pin.values);
}
