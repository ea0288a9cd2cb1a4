// The views: each computes what it shows, and draws it.

const SWEPT = 4001, PULLED = 8000, CLOSED = 1e-3;

function valueOf(lab, name) { return lab.values[name][0]; }

function pathKey(lab) {
  return [lab.preset, lab.samples, valueOf(lab, "amplitude"), valueOf(lab, "period"), lab.preset === "drawn" ? lab.turns.join() : ""].join(" ");
}

// The path of the contact, and the time step for its speed.
function pathOf(lab) {
  const key = pathKey(lab);
  if (lab.path?.key !== key) lab.path = { key, ...newPath(lab) };
  return lab.path;
}

function newPath(lab) {
  const amplitude = valueOf(lab, "amplitude"), preset = PRESETS[lab.preset];
  const turns = preset.turns ?? lab.turns;
  const lengths = turns.slice(1).reduce((sum, turn, i) => sum + Math.abs(turn - turns[i]), 0);
  const count = preset.turns ? lab.samples : Math.max(2, Math.min(lab.samples, Math.round(500 * lengths)));
  const path = turns.length > 1 ? pathThrough(turns, amplitude, count) : { x: new Float64Array(2), at: [0], length: 0 };
  const speed = 4 * amplitude / valueOf(lab, "period");
  return { ...path, dt: path.length > 0 ? path.length / (speed * (path.x.length - 1)) : 1 };
}

function loopView(lab, canvas, reading) {
  const theme = lab.theme, path = pathOf(lab), { units } = lab.model;
  const last = path.x.length - 1, moment = Math.round(last * lab.moment);
  let remembered = null;
  const before = ghostOf(lab, path);
  const forces = lab.contact.forces(path.x, path.dt, moment, (inputs) => { remembered = inputs; });
  const [low, high] = extent(forces), [lowBefore, highBefore] = before ? extent(before) : [low, high];
  const amplitude = valueOf(lab, "amplitude"), [left, right] = axis(-amplitude, amplitude);
  const [bottom, top] = axis(Math.min(low, lowBefore), Math.max(high, highBefore));
  const { context, area } = wiped(canvas);
  const frame = new Frame(context, area, { word: "position", unit: units.position, low: left, high: right },
    { word: "friction force", unit: units.force, low: bottom, high: top }, theme);
  frame.axes();
  if (before) frame.curve(path.x, before, { colour: theme.ghost, dash: [5, 4], width: 1.5 });
  if (moment < last) frame.curve(path.x, forces, { colour: theme.rule, width: 1.5, first: moment });
  const closing = closingOf(lab, path, forces, high - low);
  frame.curve(path.x, forces, { colour: closing && !closing.closes ? theme.alert : theme.accent, width: 2.2, last: moment });
  frame.dot(path.x[moment], forces[moment], theme.ink);
  lab.frame = frame;
  lab.remembered = remembered;
  tell(reading, loopWords(lab, path, forces, closing), Boolean(closing && !closing.closes) || lab.contact.overflow);
}

function loopWords(lab, path, forces, closing) {
  const { units } = lab.model, [low, high] = extent(forces), at = path.at, turns = at.length;
  const words = [`Force from ${told(low, units.force)} to ${told(high, units.force)}`];
  if (["triangle", "presliding"].includes(lab.preset)) {
    words.push(`the last loop dissipates ${told(lossBetween(path.x, forces, at[turns - 3], at[turns - 1]), "J")}`);
  }
  if (closing) {
    words.push(`on return to the start of the minor loop the force differs by ${told(Math.abs(closing.gap), units.force)}: the loop ${closing.closes ? "closes" : "does not close"}`);
  }
  if (lab.isMoved()) words.push("dashed: initial values");
  if (lab.samples < SAMPLES) words.push(`${lab.samples} samples while the slider moves`);
  if (lab.contact.overflow) words.push("the plot omits forces that are not numbers");
  return `${words.join("; ")}.`;
}

// Force difference on return to the start of a minor loop; it closes if that is below a thousandth of the range.
function closingOf(lab, path, forces, range) {
  const ends = PRESETS[lab.preset].closes;
  if (!ends) return null;
  const gap = forces[path.at[ends[1]]] - forces[path.at[ends[0]]];
  return { gap, closes: Math.abs(gap) <= CLOSED * range };
}

// The forces of the initial values, if the present values differ.
function ghostOf(lab, path) {
  if (!lab.isMoved()) return null;
  const key = pathKey(lab);
  // Two sets: during a move there may be fewer samples.
  if (!lab.ghosts.has(key)) {
    if (lab.ghosts.size > 1) lab.ghosts.delete(lab.ghosts.keys().next().value);
    lab.ghosts.set(key, lab.atStart((contact) => contact.forces(path.x, path.dt)));
  }
  return lab.ghosts.get(key);
}

function speedView(lab, canvas, reading) {
  const theme = lab.theme, { units, scales } = lab.model, top = valueOf(lab, "top");
  // So slow that the velocity changes little over ten pre-sliding distances.
  const time = 8000 * top * scales.reach / scales.speed ** 2;
  const { x, v, dt } = sweep(top, time, SWEPT), half = (SWEPT - 1) / 2;
  const forces = lab.inTheMiddle(() => lab.contact.forces(x, dt));
  const [low, high] = extent(forces, 1), { context, area } = wiped(canvas);
  const [left, right] = axis(-top, top, 0), [bottom, above] = axis(low, high);
  const frame = new Frame(context, area, { word: "velocity", unit: units.velocity, low: left, high: right },
    { word: "friction force", unit: units.force, low: bottom, high: above }, theme);
  frame.axes();
  frame.curve(v, forces, { colour: theme.accent, width: 2.2, first: 1, last: half });
  frame.curve(v, forces, { colour: theme.ink, width: 1.5, dash: [6, 4], first: half + 1 });
  const along = lab.model.placed?.size ? " Computed in the middle of the axis, without variation along the axis." : lab.model.varies && !lab.model.placed ? " This friction also varies during the sweep." : "";
  tell(reading, `Solid: rising velocity. Dashed: falling velocity. The sweep takes ${told(time, "s")}.${along}`, lab.contact.overflow);
}

function pulledView(lab, canvas, reading) {
  const theme = lab.theme, { units } = lab.model, time = valueOf(lab, "time"), dt = time / PULLED;
  // The force transmitted to this mass is the force that moves it.
  lab.contact.set("around_transmitted", [0]);
  const { x, end, force } = lab.contact.moved(PULLED, dt, () => 0);
  lab.contact.set("around_transmitted", lab.values.around_transmitted ?? [0]);
  const t = lab.times?.dt === dt ? lab.times.t : x.map((_, k) => (k + 1) * dt);
  lab.times = { dt, t };
  const { context, area } = wiped(canvas), upper = 0.55 * area.height;
  const [low, high] = extent(x), [lowEnd, highEnd] = extent(end), [bottom, top] = axis(Math.min(0, low, lowEnd), Math.max(high, highEnd), 0.02);
  const [least, most] = axis(...extent(force));
  const across = { word: "time", unit: "s", low: 0, high: time };
  const place = new Frame(context, { ...area, height: upper }, { ...across, word: "" , unit: "s" }, { word: "position", unit: units.position, low: bottom, high: top }, theme);
  const below = new Frame(context, { ...area, top: upper, height: area.height - upper }, across, { word: "friction", unit: units.force, low: least, high: most }, theme);
  place.left = below.left = Math.max(place.left, below.left);
  place.bottom += 1.4 * theme.size;
  place.x.word = "";
  place.x.unit = "";
  place.axes();
  below.axes();
  place.curve(t, end, { colour: theme.ink, width: 1.2, dash: [6, 4] });
  place.curve(t, x, { colour: theme.accent, width: 2.2 });
  below.curve(t, force, { colour: theme.accent, width: 1.6 });
  let still = 0;
  const slow = 0.01 * Math.abs(valueOf(lab, "v_e")) * dt;
  for (let k = 1; k < PULLED; k++) still += Math.abs(x[k] - x[k - 1]) < slow;
  tell(reading, `Solid: mass. Dashed: far end of the spring. The mass sticks in ${Math.round(100 * still / (PULLED - 1))} % of the time: its speed is below 1 % of that of the far end.`, false);
}

function planeView(lab, canvas, reading) {
  const theme = lab.theme, { units } = lab.model, corners = staircase(lab.remembered);
  const [low, high] = axis(-planeReach(lab), planeReach(lab)), { context, area } = wiped(canvas);
  const frame = new Frame(context, area, { word: "down at β", unit: units.position, low, high }, { word: "up at α", unit: units.position, low, high }, theme);
  frame.axes();
  frame.clip(() => {
    const line = (points) => points.forEach(([alpha, beta]) => context.lineTo(frame.across(beta), frame.up(alpha)));
    context.fillStyle = theme.shade;
    context.beginPath();
    line([[high, low], ...corners, [low, low]]);
    context.fill();
  });
  frame.curve([low, high], [low, high], { colour: theme.ink, width: 1 });
  frame.curve([low, ...corners.map(([, beta]) => beta)], [high, ...corners.map(([alpha]) => alpha)], { colour: theme.accent, width: 2.2 });
  const input = lab.remembered.at(-1);
  frame.dot(input, input, theme.ink);
  const points = lab.remembered.length - 1;
  tell(reading, `Relays in the shaded part are up. ${points} turning point${points === 1 ? "" : "s"} in memory; the input is ${told(input, units.position)}.`, false);
}

function elementsView(lab, canvas, reading) {
  const theme = lab.theme, { elements } = lab.model, kept = lab.remembered, limits = limitsOf(elements, lab.values);
  const [low, high] = axis(Math.min(...limits.map(([least]) => least)), Math.max(...limits.map(([, most]) => most)));
  const { context, area } = wiped(canvas), count = kept.length;
  const frame = new Frame(context, area, { word: "element", unit: "", low: 0.5, high: count + 0.5 },
    { word: elements.word, unit: elements.unit, low, high }, theme);
  frame.xTicks = frame.xTicks.filter(Number.isInteger);
  frame.axes();
  let full = 0;
  kept.forEach((value, i) => {
    const [left, right] = [i + 0.7, i + 1.3].map((each) => frame.across(each)), [least, most] = limits[i];
    const isFull = value >= most * (1 - 1e-9) || value <= least * (1 - 1e-9);
    full += isFull;
    context.fillStyle = isFull ? theme.accent : theme.ghost;
    context.fillRect(left, Math.min(frame.up(0), frame.up(value)), right - left, Math.abs(frame.up(value) - frame.up(0)));
    for (const limit of [least, most]) frame.curve([i + 0.65, i + 1.35], [limit, limit], { colour: theme.ink, width: 1.5 });
  });
  tell(reading, `Bars: force of each element; lines: its slip limits at rest. ${full} of ${count} elements ${full === 1 ? "slips" : "slip"}.`, false);
}

// The verdicts on drift and closure, with a mark in addition to the colour.
function verdictView(lab, list) {
  const judge = lab.judge ?? lab.contact;
  for (const { name } of lab.model.variables) judge.set(name, lab.values[name]);
  const lines = verdicts(lab.model, judged(judge));
  lab.setAll(lab.values);
  const html = lines.map(({ asked, passed, text }) =>
    `<li class="${passed === false ? "alert" : ""}"><span aria-hidden="true">${passed === null ? "–" : passed ? "✓" : "✗"}</span> <b>${asked}</b>: ${text}</li>`).join("");
  if (list.innerHTML !== html) list.innerHTML = html;
}

// The range of the plane: that of the input, kept while the input only shrinks.
function planeReach(lab) {
  const farthest = Math.max(...lab.remembered.map(Math.abs), 1e-3 * lab.model.scales.reach);
  const key = `${lab.model.name} ${lab.model.model} ${lab.preset} ${valueOf(lab, "amplitude")}`;
  if (lab.planeKey !== key || lab.planeFarthest < farthest || lab.planeFarthest > 4 * farthest && lab.moment === 1) {
    Object.assign(lab, { planeKey: key, planeFarthest: farthest });
  }
  return lab.planeFarthest;
}

function tell(reading, text, alert) {
  if (reading.textContent !== text) reading.textContent = text;
  reading.classList.toggle("alert", alert);
}
