// The closed loop, computed in the background after a move. One request at a time.

const WORDS = { none: "control law alone", model: "friction feedforward", observer: "observer", both: "both" };
const SHARE = 0.25; // of the radius: drawn size of the largest error of the circle
const STILL = 150; // [ms]
const asked = new Asked("tracked", tracked, () => drawTracked(lab));
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
  if (key === askedKey && asked.found) return drawTracked(lab);
  if (key === askedKey) return null;
  askedKey = key;
  // While a slider moves, the cores are those of the curves that move with it.
  clearTimeout(askedLater);
  askedLater = setTimeout(() => asked.put(setup), asked.found ? STILL : 0);
  return null;
}

function widthOf(values) {
  const [low, high] = extent(values);
  return high - low;
}

function drawTracked(lab) {
  trackView(lab, byId("track"), byId("track-reading"));
  circleView(lab, byId("circle"), byId("circle-reading"));
}

function trackView(lab, canvas, reading) {
  const { errors, dt, period } = asked.found, theme = lab.theme, { units } = lab.model;
  const t = Float64Array.from({ length: period }, (_, k) => k * dt), { context, area } = wiped(canvas);
  const ends = Object.values(errors).map((error) => extent(error));
  const [bottom, top] = axis(Math.min(...ends.map(([low]) => low)), Math.max(...ends.map(([, high]) => high)));
  const frame = new Frame(context, area, { word: "time", unit: "s", low: 0, high: period * dt },
    { word: "following error", unit: units.position, low: bottom, high: top }, theme);
  frame.axes();
  const looks = { none: { colour: theme.ghost, width: 2.2 }, model: { colour: theme.accent, width: 1.8 },
    observer: { colour: theme.measured, width: 1.8, dash: [7, 4] }, both: { colour: theme.ink, width: 1.4 } };
  for (const [way, look] of Object.entries(looks)) frame.curve(t, errors[way], look);
  const told_ = Object.entries(errors).map(([way, error]) => `${WORDS[way]} ${told(widthOf(error), units.position)}`);
  tell(reading, `Peak-to-peak error of the second period: grey ${told_[0]}; blue ${told_[1]}; dashed ${told_[2]}; thin and dark ${told_[3]}.`, false);
}

function circleView(lab, canvas, reading) {
  const { errors, across, dt, period } = asked.found, theme = lab.theme, { units } = lab.model, radius = valueOf(lab, "loop_A");
  const turn = 2 * Math.PI * valueOf(lab, "loop_f") * dt, from = period, round = (k) => [Math.cos(turn * (from + k)), Math.sin(turn * (from + k))];
  const radial = (way) => errors[way].map((error, k) => {
    const [c, s] = round(k);
    return Math.hypot(radius * c - across[way][k], radius * s - error) - radius;
  });
  const deviations = { none: radial("none"), both: radial("both") };
  const largest = Math.max(...extent(deviations.none).map(Math.abs), Number.MIN_VALUE), times = SHARE * radius / largest;
  const [low, high] = axis(-(1 + SHARE) * radius, (1 + SHARE) * radius, 0), { context, area } = wiped(canvas);
  const side = Math.min(area.width, area.height), frame = new Frame(context, { ...area, left: (area.width - side) / 2, width: side },
    { word: "one axis", unit: units.position, low, high }, { word: "other axis", unit: units.position, low, high }, theme);
  frame.axes();
  const ring = (deviation, look) => {
    const x = new Float64Array(period), y = new Float64Array(period);
    for (let k = 0; k < period; k++) {
      const [c, s] = round(k), r = radius + times * (deviation ? deviation[k] : 0);
      x[k] = r * c;
      y[k] = r * s;
    }
    frame.curve(x, y, look);
  };
  ring(null, { colour: theme.rule, width: 1.5 });
  ring(deviations.none, { colour: theme.ghost, width: 2.2 });
  ring(deviations.both, { colour: theme.accent, width: 1.8 });
  const size = (way) => told(Math.max(...extent(deviations[way]).map(Math.abs)), units.position);
  tell(reading, `Circle driven by two such axes, with errors enlarged ${withDigits(times, 2)} times: control law alone (grey), up to ${size("none")}; with observer and friction feedforward (blue), up to ${size("both")}.`, false);
}
