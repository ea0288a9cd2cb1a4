// The closed loop, computed in the background after a move. One request at a time.

const WORDS = { none: "control law alone", model: "friction feedforward", observer: "observer", both: "both" };
const STILL = 150; // [ms]
const asked = new Asked("tracked", tracked, (found) => {
  Object.assign(lab, { tracked: found, trackedKey: (lab.trackedKey ?? 0) + 1, run: null, path: null });
  drawNow();
  drawRest();
});
let askedKey = "", askedLater = 0;

function loopSetup(lab) {
  const value = (name) => lab.values[`loop_${name}`][0], names = ["M", "gain", "K_2", "g", "resolution", "A", "f"];
  const isRig = value("body") === 1, { model } = lab, body = isRig ? data.loop.rig : lab.start.model;
  // Load and temperature are the same for both; the mass passes the transmitted force to its friction.
  const around = Object.fromEntries(model.around.filter(({ name }) => name !== "around_transmitted").map(({ name }) => [name, lab.values[name]]));
  const values = { ...Object.fromEntries(model.variables.map(({ name }) => [name, lab.values[name]])), ...around };
  const first = () => ({ ...Object.fromEntries(body.variables.map((row) => [row.name, numbersOf(row.values)])), ...around });
  return { loop: data.loop, model, values, body, bodyValues: isRig ? body.values : first(),
    settings: Object.fromEntries(names.map((name) => [name, value(name)])) };
}

function track(lab) {
  const setup = loopSetup(lab), key = JSON.stringify([lab.model.name, lab.model.model, lab.values.loop_body, setup.values, setup.settings]);
  if (key === askedKey) return;
  askedKey = key;
  // While a slider moves, the cores are those of the curves that move with it.
  clearTimeout(askedLater);
  askedLater = setTimeout(() => asked.put(setup), asked.found ? STILL : 0);
}

// The true positions of the axis with the control law alone, for two periods.
function trackedPath({ tracked: { errors, dt, period, amplitude, frequency } }) {
  const turn = 2 * Math.PI * frequency * dt, x = Float64Array.from({ length: 2 * period }, (_, k) => amplitude * Math.sin(turn * k) - errors.none[k % period]);
  return { x, dt, at: null };
}

function widthOf(values) { return extent(values).reduce((low, high) => high - low); }

function trackView(lab, canvas, view = {}) {
  if (!lab.tracked) return null;
  const { errors, dt, period } = lab.tracked, theme = lab.theme, { units } = lab.model;
  const t = Float64Array.from({ length: period }, (_, k) => k * dt), { context, area } = wiped(canvas);
  const ends = Object.values(errors).map((error) => extent(error));
  const [bottom, top] = view.y ?? axis(Math.min(...ends.map(([low]) => low)), Math.max(...ends.map(([, high]) => high)));
  const [from, to] = view.x ?? [0, period * dt];
  const frame = new Frame(context, area, { word: "time", unit: "s", low: from, high: to },
    { word: "following error", unit: units.position, low: bottom, high: top }, theme);
  frame.axes();
  const looks = { none: { colour: theme.without, width: 2.2 }, model: { colour: theme.with, width: 1.8 },
    observer: { colour: theme.measured, width: 1.8, dash: [7, 4] }, both: { colour: theme.ink, width: 1.4 } };
  for (const [way, look] of Object.entries(looks)) frame.curve(t, errors[way], look);
  if (lab.preset === "tracked") frame.upright((2 * lab.moment * period * dt) % (period * dt), theme.soft);
  for (const way of ["none", "model"]) {
    const k = errors[way].reduce((best, value, i) => (value > errors[way][best] ? i : best), 0);
    frame.label(WORDS[way], t[k], errors[way][k], looks[way].colour, k > 0.6 * period ? "right" : "left");
  }
  const told_ = Object.entries(errors).map(([way, error]) => `${WORDS[way]} ${told(widthOf(error), units.position)}`);
  return Object.assign(frame, { words: `Peak-to-peak error of the second period: grey ${told_[0]}; blue ${told_[1]}; dashed ${told_[2]}; thin and dark ${told_[3]}.`, curves: Object.entries(looks).map(([way, { colour }]) => [t, errors[way], colour, WORDS[way]]) });
}
