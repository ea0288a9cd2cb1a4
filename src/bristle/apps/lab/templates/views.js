// The views: each computes what it shows, draws it, and returns its frame with a caption in `words`.

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
  if (lab.preset === "tracked") return lab.tracked ? trackedPath(lab) : { x: new Float64Array(2), at: [0], dt: 1 };
  const turns = preset.turns ?? lab.turns;
  const lengths = turns.slice(1).reduce((sum, turn, i) => sum + Math.abs(turn - turns[i]), 0);
  const count = preset.turns ? lab.samples : Math.max(2, Math.min(lab.samples, Math.round(500 * lengths)));
  const path = turns.length > 1 ? pathThrough(turns, amplitude, count) : { x: new Float64Array(2), at: [0], length: 0 };
  const speed = 4 * amplitude / valueOf(lab, "period");
  return { ...path, dt: path.length > 0 ? path.length / (speed * (path.x.length - 1)) : 1 };
}

// The motion of the machine: positions and forces, and the far end of the spring where there is one.
function runOf(lab) {
  const key = `${pathKey(lab)} ${lab.model.model} ${Object.values(lab.values).join()} ${lab.trackedKey}`;
  if (lab.preset === "hand") return { ...lab.hand, key: `${lab.hand.x.length}` };
  if (lab.run?.key !== key) lab.run = { key, ...newRun(lab, lab.contact), overflow: lab.contact.overflow };
  return lab.run;
}

function newRun(lab, contact) {
  if (PRESETS[lab.preset].speed || PRESETS[lab.preset].effort) return pulledRun(lab, contact);
  const { x, dt, at } = pathOf(lab);
  return { x, dt, at, force: contact.forces(x, dt), end: null };
}

function pulledRun(lab, contact) {
  const { speed, effort } = PRESETS[lab.preset], [time, k, v_e] = ["time", "k", "v_e"].map((name) => valueOf(lab, name));
  const stretch = (share) => share * time * v_e * k / lab.level;
  let now = NaN;
  // The force transmitted to this mass is the force that moves it.
  contact.set("around_transmitted", [0]);
  if (effort) contact.set("k", [0]);
  const run = contact.moved(PULLED, time / PULLED, (step) => {
    const next = speed ? v_e * speed(step / PULLED, stretch) : 0;
    if (next !== now) contact.set("v_e", [now = next]);
    return effort ? lab.level * effort(step / PULLED) : 0;
  });
  for (const name of ["k", "v_e", "around_transmitted"]) contact.set(name, lab.values[name] ?? [0]);
  return { ...run, dt: time / PULLED, at: null, end: effort ? null : run.end };
}

// Ends of the position axis: with a machine above there is room for its block and spring.
function positionAxis(lab, run, width) {
  const amplitude = valueOf(lab, "amplitude"), { machine } = lab;
  let [low, high] = run.at ? [-amplitude, amplitude] : extent(run.x);
  if (!machine) return axis(low, high);
  if (run.end) high = Math.max(high, extent(run.end)[1]);
  // In the hand of the user the axis grows in steps.
  if (run.reach) [low, high] = [low < 0 ? -1 : 0, 1].map((side) => side * run.reach * 1.5 ** Math.max(0, Math.ceil(Math.log(Math.max(high, -low, run.reach) / run.reach) / Math.log(1.5))));
  if (lab.pin && !run.at) high = Math.max(high, extent(runOf(lab.pin).x)[1]);
  [low, high] = [Math.min(0, low), Math.max(high, 0.05 * amplitude)];
  const step = (high - low) / Math.max(60, width - machine.left - machine.right - (run.end ? 0 : machine.stretch));
  return [low - machine.left * step, high + (machine.right + (run.end ? 0 : machine.stretch)) * step];
}

function loopView(lab, canvas, view = {}) {
  const theme = lab.theme, run = runOf(lab), { units } = lab.model, last = run.x.length - 1, moment = Math.round(last * lab.moment);
  const before = ghostOf(lab), pinned = lab.pin ? runOf(lab.pin) : null, { context, area } = wiped(canvas);
  const ends = [run, before, pinned].filter(Boolean).map(({ force }) => extent(force)), [low, high] = ends[0];
  const [bottom, top] = view.y ?? axis(Math.min(...ends.map(([least]) => least)), Math.max(...ends.map(([, most]) => most), ...levelsOf(lab)), 0.1);
  const [left, right] = view.x ?? positionAxis(lab, run, area.width - 5.5 * theme.size);
  const frame = new Frame(context, area, { word: "position", unit: units.position, low: left, high: right },
    { word: "friction force", unit: units.force, low: bottom, high: top }, theme);
  frame.axes();
  if (lab.machine) frame.curve([run.x[moment], run.x[moment]], [bottom, top], { colour: theme.soft, width: 1, dash: [2, 4] });
  if (before) frame.curve(before.x, before.force, { colour: theme.ghost, dash: [5, 4], width: 1.5 });
  const closings = [[lab, run, theme.with], ...(pinned ? [[lab.pin, pinned, theme.third]] : [])].reverse().map(([bench, { x, force, at }, colour]) => {
    const end = x.length - 1, now = Math.round(end * lab.moment);
    if (now < end) frame.curve(x, force, { colour: theme.rule, width: 1.5, first: now });
    frame.curve(x, force, { colour, width: 2.2, last: now });
    frame.dot(x[now], force[now], colour);
    const closing = closingOf(bench, at, force);
    if (closing && now >= closing.last && !closing.closes) gapIn(frame, x, force, closing);
    return closing;
  }).reverse();
  if (pinned) nameLines(frame, [[lab, run, theme.with], [lab.pin, pinned, theme.third]]);
  frame.words = loopWords(lab, run, [low, high], closings, moment);
  frame.alert = Boolean(closings[0] && !closings[0].closes) || Boolean(run.overflow);
  frame.curves = [[run.x, run.force, theme.with, lab.model.model], ...(pinned ? [[pinned.x, pinned.force, theme.third, lab.pin.model.model]] : [])];
  lab.frame = frame;
  return frame;
}

// The levels of friction that have a handle.
function levelsOf(lab) { return lab.machine ? [LEVEL, PEAK].map((role) => familyOf(lab, role)?.value).filter(Number.isFinite) : []; }

function gapIn(frame, x, force, { first, last, share }) {
  const { theme } = frame;
  frame.curve([x[first], x[first]], [force[first], force[last]], { colour: theme.alert, width: 5 });
  frame.label(`gap ${withDigits(100 * share, 2)} %`, x[first], force[last], theme.alert, "right");
}

// The names of two models at their lines, beside the farthest point of each.
function nameLines(frame, lines) {
  const spots = lines.map(([{ model }, { x, force }, colour]) => {
    const k = x.reduce((best, value, i) => (value > x[best] ? i : best), 0);
    return { text: model.model, x: x[k], up: force[k], colour };
  }), near = 1.3 * frame.theme.size, [first, second] = spots;
  const apart = frame.up(second.up) - frame.up(first.up);
  if (Math.abs(apart) < near) second.up = frame.valueUp(frame.up(first.up) + (apart < 0 ? -near : near));
  for (const { text, x, up, colour } of spots) frame.label(text, x, up, colour);
}

function loopWords(lab, run, [low, high], closings, moment) {
  const { units } = lab.model, { at, x, force } = run;
  const words = [`${PRESETS[lab.preset].word}: force from ${told(low, units.force)} to ${told(high, units.force)}`];
  if (["triangle", "presliding"].includes(lab.preset)) {
    words.push(`the last loop dissipates ${told(lossBetween(x, force, at[at.length - 3], at[at.length - 1]), "J")}`);
  }
  const [own, other] = closings.map((closing) => closing && `${told(Math.abs(closing.gap), units.force)}: the loop ${closing.closes ? "closes" : "does not close"}`);
  if (own) words.push(`on return the force differs by ${own}`);
  if (other) words.push(`${lab.pin.model.model}: ${other}`);
  if (lab.isMoved()) words.push("dashed: initial values");
  if (lab.samples < SAMPLES) words.push(`${lab.samples} samples while the slider moves`);
  if (run.overflow) words.push("the plot omits forces that are not numbers");
  return `${words.join("; ")}.`;
}

// Force difference on return to the start of a minor loop; it closes if that is below a thousandth of the range.
function closingOf(lab, at, forces) {
  const ends = PRESETS[lab.preset].closes;
  if (!ends) return null;
  const [first, last] = ends.map((turn) => at[turn]), gap = forces[last] - forces[first], [low, high] = extent(forces), share = 2 * Math.abs(gap) / (high - low);
  return { gap, share, first, last, closes: share <= 2 * CLOSED };
}

// The motion with the initial values, if the present values differ.
function ghostOf(lab) {
  if (!lab.isMoved() || lab.preset === "hand") return null;
  const key = `${pathKey(lab)} ${lab.settings.map(({ name }) => lab.values[name]).join()}`;
  // Two sets: during a move there may be fewer samples.
  if (!lab.ghosts.has(key)) {
    if (lab.ghosts.size > 1) lab.ghosts.delete(lab.ghosts.keys().next().value);
    lab.ghosts.set(key, lab.atStart((contact) => newRun(lab, contact)));
  }
  return lab.ghosts.get(key);
}

// Friction during a slow sweep of the velocity.
function sweptOf(lab) {
  const top = valueOf(lab, "top"), { scales } = lab.model, key = `${lab.model.model} ${Object.values(lab.values).join()}`;
  if (lab.swept?.key === key) return lab.swept;
  // So slow that the velocity changes little over ten pre-sliding distances.
  const time = 8000 * top * scales.reach / scales.speed ** 2, { x, v, dt } = sweep(top, time, SWEPT);
  lab.swept = { key, v, time, force: lab.inTheMiddle(() => lab.contact.forces(x, dt)), overflow: lab.contact.overflow };
  return lab.swept;
}

function speedView(lab, canvas, view = {}) {
  const theme = lab.theme, { units } = lab.model, top = valueOf(lab, "top"), half = (SWEPT - 1) / 2, { v, force, time, overflow } = sweptOf(lab);
  const benches = [[lab, theme.with], ...(lab.pin ? [[lab.pin, theme.third]] : [])], ends = benches.map(([bench]) => extent(sweptOf(bench).force, 1));
  const [left, right] = view.x ?? axis(-top, top, 0), [bottom, above] = view.y ?? axis(Math.min(...ends.map(([low]) => low)), Math.max(...ends.map(([, high]) => high)));
  const { context, area } = wiped(canvas);
  const frame = new Frame(context, area, { word: "velocity", unit: units.velocity, low: left, high: right },
    { word: "friction force", unit: units.force, low: bottom, high: above }, theme);
  frame.axes();
  for (const [bench, colour] of benches.reverse()) {
    const curve = sweptOf(bench);
    frame.curve(v, curve.force, { colour, width: 2.2, first: 1, last: half });
    frame.curve(v, curve.force, { colour: bench === lab ? theme.ink : colour, width: 1.5, dash: [6, 4], first: half + 1 });
  }
  if (lab.pin) nameLines(frame, benches.reverse().map(([bench, colour]) => [bench, { x: v.subarray(1, half).map((each) => (each > 0.3 * top ? -Infinity : each)), force: sweptOf(bench).force.subarray(1, half) }, colour]));
  const along = lab.model.placed?.size ? " Computed in the middle of the axis, without variation along the axis." : lab.model.varies && !lab.model.placed ? " This friction also varies during the sweep." : "";
  return Object.assign(frame, { words: `Solid: falling velocity. Dashed: rising velocity. The sweep takes ${told(time, "s")}.${along}`, alert: overflow, curves: benches.map(([bench, colour]) => [v.subarray(1), sweptOf(bench).force.subarray(1), colour, bench.model.model]) });
}

// The memory at the present moment.
function rememberedOf(lab) {
  const { x, dt } = runOf(lab), moment = Math.round((x.length - 1) * lab.moment);
  lab.contact.forces(x.subarray(0, moment + 1), dt, moment, (inputs) => { lab.remembered = inputs; });
  return lab.remembered;
}

function planeView(lab, canvas, view = {}) {
  const theme = lab.theme, { units } = lab.model, corners = staircase(rememberedOf(lab)), reach = planeReach(lab), all = axis(-reach, reach);
  const [[low, high], [least, most]] = [view.x ?? all, view.y ?? all], { context, area } = wiped(canvas);
  const frame = new Frame(context, area, { word: "down at β", unit: units.position, low, high }, { word: "up at α", unit: units.position, low: least, high: most }, theme);
  frame.axes();
  frame.clip(() => {
    const line = (points) => points.forEach(([alpha, beta]) => context.lineTo(frame.across(beta), frame.up(alpha)));
    context.fillStyle = theme.shade;
    context.beginPath();
    line([[all[1], all[0]], ...corners, [all[0], all[0]]]);
    context.fill();
  });
  frame.curve(all, all, { colour: theme.ink, width: 1 });
  frame.curve([all[0], ...corners.map(([, beta]) => beta)], [all[1], ...corners.map(([alpha]) => alpha)], { colour: theme.accent, width: 2.2 });
  const input = lab.remembered.at(-1);
  frame.dot(input, input, theme.ink);
  const points = lab.remembered.length - 1;
  return Object.assign(frame, { words: `Relays in the shaded part are up. ${points} turning point${points === 1 ? "" : "s"} in memory; the input is ${told(input, units.position)}.` });
}

function elementsView(lab, canvas, view = {}) {
  const theme = lab.theme, { elements } = lab.model, kept = rememberedOf(lab), limits = limitsOf(elements, lab.values);
  const [low, high] = view.y ?? axis(Math.min(...limits.map(([least]) => least)), Math.max(...limits.map(([, most]) => most)));
  const { context, area } = wiped(canvas), count = kept.length;
  const frame = new Frame(context, area, { word: "element", unit: "", low: view.x?.[0] ?? 0.5, high: view.x?.[1] ?? count + 0.5 },
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
  return Object.assign(frame, { words: `Bars: force of each element; lines: its slip limits at rest. ${full} of ${count} elements ${full === 1 ? "slips" : "slip"}.` });
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
