// The machine: a block on bristles, pulled by a spring, in true time, over the position axis of the loop below it.

const HAIRS = 15, HAIR = 30, BODY = 46, MOST_HELD = 40000, PAUSED = 0.9, GLANCE = 1 / 30; // [px], [px], samples, [s], [s]
const clock = { plays: false, last: 0, rests: 0, pending: 0, target: 0 };

function machineOf(width) {
  const narrow = width < 500, [half, rest, stretch] = narrow ? [32, 50, 16] : [54, 76, 30];
  return { narrow, half, rest, stretch, left: half + 18, right: half + rest + 30 };
}

function stiffnessOf(lab) { return familyOf(lab, STIFFNESS)?.value ?? Infinity; }

// Whether the block rests, bends its bristles, or slides, over the last glance.
function contactState(lab, run, k) {
  const before = Math.max(0, k - Math.max(1, Math.round(GLANCE / run.dt))), seen = lab.frame.x.high - lab.frame.x.low;
  const moved = run.x[k] - run.x[before], bent = (run.force[k] - run.force[before]) / stiffnessOf(lab), time = (k - before) * run.dt;
  const velocity = time > 0 ? moved / time : 0, slips = Math.abs(moved - bent) > 0.5 * Math.abs(moved);
  const word = Math.abs(moved) < 2e-5 * seen ? "holds" : slips ? "slides" : "bends";
  return { word, velocity, force: run.force[k], x: run.x[k] };
}

function machineView(lab, canvas) {
  const { frame, theme, machine } = lab, run = runOf(lab), k = Math.round((run.x.length - 1) * lab.moment), { half, rest } = machine;
  const { context, area } = wiped(canvas), { size } = theme, ground = area.height - 1.1 * size, top = ground - HAIR - BODY;
  const state = contactState(lab, run, k), x = frame.across(state.x), share = state.force / lab.level;
  const end = run.end ? frame.across(run.end[k]) + half + rest : x + half + rest + machine.stretch * share;
  // Deflection of the bristles in the scale of the axis, but visible.
  const full = lab.level / stiffnessOf(lab) / (frame.x.high - frame.x.low) * (frame.right - frame.left), bend = share * Math.min(40, Math.max(15, full));
  Object.assign(machine, { x, end, top, ground });
  const small = `${0.82 * size}px system-ui, "DejaVu Sans", sans-serif`;
  pen(context, { strokeStyle: theme.soft, lineWidth: 1.5, font: small });
  stroke(context, [[frame.left, ground], [area.width, ground]]);
  pen(context, { strokeStyle: theme.rule, lineWidth: 1 });
  for (let at = frame.left; at < area.width; at += 9) stroke(context, [[at, area.height], [at + 7, ground + 1]]);
  if (lab.pin) otherBlock(lab, context, x, top, ground);
  hairs(context, x - half + 5, 2 * half - 10, ground, bend, state.word === "slides" ? theme.care : theme.with);
  pen(context, { fillStyle: theme.with });
  context.beginPath();
  context.roundRect(x - half, top, 2 * half, BODY, 7);
  context.fill();
  spring(context, x + half, end, top + BODY / 2, theme);
  pen(context, { fillStyle: theme.ground, font: `600 ${0.95 * size}px system-ui, "DejaVu Sans", sans-serif` });
  context.fillText(state.word, x, top + BODY / 2);
  pen(context, { fillStyle: theme.ink, font: small, textBaseline: "top" });
  context.fillText(told(state.force, lab.model.units.force), (x + half + end) / 2, top + BODY / 2 + 11);
  return state;
}

function hairs(context, left, width, ground, bend, colour) {
  pen(context, { strokeStyle: colour, lineWidth: 2 });
  context.beginPath();
  for (let i = 0; i < HAIRS; i++) {
    const root = left + width * i / (HAIRS - 1);
    context.moveTo(root, ground - HAIR);
    context.quadraticCurveTo(root, ground - 0.35 * HAIR, root - bend, ground - 1);
  }
  context.stroke();
}

function spring(context, from, to, y, theme) {
  const turns = 9, radius = 7, straight = 8, length = to - 11 - from - 2 * straight;
  const coil = Array.from({ length: 2 * turns + 1 }, (_, i) => [from + straight + length * i / (2 * turns), i % (2 * turns) ? y + (i % 2 ? -radius : radius) : y]);
  pen(context, { strokeStyle: theme.ink, lineWidth: 1.8, fillStyle: theme.card });
  stroke(context, [[from, y], ...coil, [to - 11, y]]);
  context.beginPath();
  context.arc(to, y, 12, 0, 2 * Math.PI);
  context.fill();
  context.stroke();
  pen(context, { fillStyle: theme.ink, textAlign: "center", textBaseline: "middle" });
  context.fillText("↔", to, y);
}

// The block of the model to compare with, where it stands elsewhere.
function otherBlock(lab, context, x, top, ground) {
  const run = runOf(lab.pin), { half } = lab.machine, at = lab.frame.across(run.x[Math.round((run.x.length - 1) * lab.moment)]);
  if (Math.abs(at - x) < 1.5) return;
  pen(context, { strokeStyle: lab.theme.third, fillStyle: lab.theme.third, lineWidth: 2, dash: [5, 3], textAlign: "left", textBaseline: "bottom" });
  context.beginPath();
  context.roundRect(at - half, top, 2 * half, ground - top - 2, 7);
  context.stroke();
  context.fillText(lab.pin.model.model, at - half, top - 2);
}

// --- true time ---------------------------------------------------------------------------------------------------------

function play(plays) {
  if (plays && !clock.plays) {
    clock.last = performance.now();
    if (lab.moment >= 1 && lab.preset !== "hand") lab.moment = 0;
    requestAnimationFrame(tick);
  }
  clock.plays = plays;
  byId("play").textContent = plays ? "❚❚ Pause" : "▶ Play";
  byId("play").setAttribute("aria-pressed", String(plays));
}

function tick(now) {
  if (!clock.plays) return;
  const gap = Math.min(0.1, Math.max(0, now - clock.last) / 1000), run = runOf(lab), time = (run.x.length - 1) * run.dt;
  clock.last = now;
  if (lab.preset === "hand") holdSpring(gap);
  else if (lab.moment >= 1) {
    clock.rests += gap;
    if (clock.rests > PAUSED) lab.moment = 0;
  } else {
    clock.rests = 0;
    lab.moment = Math.min(1, lab.moment + gap / Math.max(time, 1e-9));
  }
  drawMoment();
  requestAnimationFrame(tick);
}

// Time passes while the far end of the spring is in the hand of the user.
function holdSpring(gap) {
  const { hand, live } = lab, text = Object.values(lab.values).join();
  if (hand.text !== text) for (const [name, list] of Object.entries(lab.values)) live.set(name, list);
  hand.text = text;
  clock.pending += gap / hand.dt;
  const steps = Math.floor(clock.pending);
  clock.pending -= steps;
  if (!steps || hand.x.length > MOST_HELD) return;
  live.set("v_e", [(clock.target - hand.end.at(-1)) / (steps * hand.dt)]);
  for (let i = 0; i < steps; i++) {
    hand.force.push(live.push(0, hand.dt));
    hand.x.push(live.x);
    hand.end.push(live.end);
  }
  lab.moment = 1;
}

function takeSpring() {
  if (lab.preset === "hand") return;
  const hand = { x: [0], force: [0], end: [0], dt: valueOf(lab, "time") / PULLED, at: null, reach: 1.6 * lab.level / valueOf(lab, "k") };
  Object.assign(lab, { preset: "hand", hand, pin: null });
  byId("with").value = "";
  clock.target = 0;
  lab.live.begin();
  leaveChapter();
  showAll();
}

function partAt(px) { return Math.abs(px - lab.machine.end) < 18 ? "spring" : Math.abs(px - lab.machine.x) < lab.machine.half + 8 ? "block" : ""; }

// Drag the block to draw its path, or the far end of the spring to pull it.
function followPointer(canvas) {
  canvas.addEventListener("pointermove", (event) => canvas.classList.toggle("grab", partAt(event.offsetX) !== ""));
  dragged(canvas, ({ offsetX: at }) => {
    const part = partAt(at);
    if (part === "spring") takeSpring();
    if (part) play(part === "spring");
    return part && { part, at };
  }, ({ offsetX }, last) => {
    const moved = lab.frame.valueAt(offsetX) - lab.frame.valueAt(last.at);
    last.at = offsetX;
    if (last.part === "spring") clock.target += moved;
    else moveBy(moved);
  });
  steered(canvas, "machine", (event, way) => {
    const isSpring = /Up|Down/.test(event.key), seen = event.shiftKey ? 0.1 : 0.01;
    if (isSpring) takeSpring();
    play(isSpring);
    if (isSpring) clock.target += way * seen * (lab.frame.x.high - lab.frame.x.low);
    else moveBy(way * 2 * seen * valueOf(lab, "amplitude"));
  });
}

// Move the contact on by a distance; without a reversal the path gets no turn.
function moveBy(distance) {
  if (lab.preset !== "drawn") {
    const { amplitude } = lab.values;
    leaveChapter();
    lab.aim("drawn");
    Object.assign(lab, { turns: [0], values: { ...lab.values, amplitude } });
  }
  const { turns } = lab, at = turns.at(-1), to = Math.max(-1.05, Math.min(1.05, at + distance / valueOf(lab, "amplitude")));
  if (to === at) return;
  if (turns.length > 1 && (to - at) * (at - turns.at(-2)) > 0) turns[turns.length - 1] = to;
  else if (turns.length < MOST_TURNS) turns.push(to);
  else return say(`The path has ${MOST_TURNS} turns, the most that are allowed. Restart it with “${PRESETS.drawn.word}”.`);
  lab.moment = 1;
  byId("path").value = "drawn";
  drawNow();
}
