// Recorded and modelled signals, drawn with the frames of the lab.

function rangeOf(values) { return axis(...extent(values.filter((value) => value !== null))); }

function frameOn(canvas, theme, x, y) {
  const { context, area } = wiped(canvas);
  const [low, high] = extent(x.values), [bottom, top] = rangeOf(y.values);
  const frame = new Frame(context, area, { word: x.word, unit: x.unit, low, high: high > low ? high : low + 1 },
    { word: y.word, unit: y.unit, low: bottom, high: top }, theme);
  frame.axes();
  return frame;
}

function signalPicture({ word, unit, column, curve: [time, values], time_unit }) {
  return pictureOf(`${word}, column ${column}`, (canvas, theme) => {
    const frame = frameOn(canvas, theme, { word: "time", unit: time_unit, values: time }, { word, unit, values });
    const there = values.map((value, i) => [time[i], value]).filter(([, value]) => value !== null);
    frame.curve(there.map(([at]) => at), there.map(([, value]) => value), { colour: theme.accent, width: 1.2 });
  });
}

function effortPicture([time, measured, predicted], unit, label) {
  return pictureOf(label, (canvas, theme) => {
    const frame = frameOn(canvas, theme, { word: "time", unit: "s", values: time }, { word: "effort", unit, values: [...measured, ...predicted] });
    frame.curve(time, measured, { colour: theme.measured, width: 2.4 });
    frame.curve(time, predicted, { colour: theme.with, width: 1 });
  }, ["measured", "measured"], ["with", "model"]);
}

function unitsOf(kind) {
  return kind === "rotational" ? { position: "rad", velocity: "rad/s", force: "N·m" } : { position: "m", velocity: "m/s", force: "N" };
}
