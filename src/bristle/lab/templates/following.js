// The following error in the report, and with the present feedforward.

const LOOKS = {
  measured: { word: "log", colour: "measured", width: 3.4 },
  as_recorded: { word: "as recorded", colour: "ghost", width: 1.8 },
  feedforward: { word: "velocity and inertia feedforward", colour: "soft", width: 1.2, dash: [6, 4] },
  compensated: { word: "with friction feedforward", colour: "accent", width: 1.4 },
  moved: { word: "with these values", colour: "alert", width: 2 },
};
const AWAIT = 120, DWARFS = 10; // [ms], times the smallest: such large lines start hidden
const following = { view: newView(), traces: [], plot: null, asked: null, key: "", wanted: "", later: 0, start: null, hidden: new Set() };

function tracesOf(parts) {
  return parts.map(({ name, numbers, count, step, time, sampleTime }) => {
    const next = columnsOf(numbers), samples = next(count, 2);
    return { name, t: samples.map((sample) => time + sampleTime * sample), error: next(count, 1, step) };
  });
}

function allTraces() {
  const { asked } = following, found = isMoved() && following.key === keyNow() && asked?.found;
  return found ? [...following.traces, { name: "moved", t: found.t, error: found.error }] : following.traces;
}

function shownTraces() { return allTraces().filter(({ name }) => !following.hidden.has(name)); }

function lookOf(name) {
  const { colour, ...look } = LOOKS[name] ?? { colour: "ink", width: 1, dash: [2, 3] };
  return { ...look, colour: alive.theme[colour] };
}

function followingPlot(canvas, view) {
  const traces = shownTraces(), { units } = data.model, { context, area } = wiped(canvas);
  if (!traces.length) return null;
  const [low, high] = view.x ?? [Math.min(...traces.map(({ t }) => t[0])), Math.max(...traces.map(({ t }) => t[t.length - 1]))];
  const parts = traces.map((trace) => ({ ...trace, first: Math.max(0, nearest(trace.t, low) - 1), last: Math.min(trace.t.length - 1, nearest(trace.t, high) + 1) }));
  const ends = parts.map(({ error, first: from, last: to }) => extent(error.subarray(from, to + 1)));
  const [bottom, top] = axis(Math.min(...ends.map(([least]) => least)), Math.max(...ends.map(([, most]) => most)));
  const frame = new Frame(context, area, { word: "time", unit: "s", low, high }, { word: "following error", unit: units.position, low: bottom, high: top }, alive.theme);
  frame.axes();
  for (const { name, t, error, first: from, last: to } of parts) frame.curve(t, error, { ...lookOf(name), first: from, last: to });
  return frame;
}

function markTime(frame, time) {
  frame.upright(time, alive.theme.soft);
  const values = shownTraces().map(({ name, t, error }) => {
    const k = nearest(t, time);
    frame.dot(t[k], error[k], lookOf(name).colour, 3.5);
    return `${LOOKS[name]?.word ?? name} ${told(error[k], data.model.units.position)}`;
  });
  return `At ${told(time, "s", 5)}: ${values.join(", ")}.`;
}

function followingPlots(of) {
  following.traces = tracesOf(data.loop.traces);
  const sizes = following.traces.map(({ error }) => Math.max(...extent(error).map(Math.abs))), least = Math.min(...sizes);
  following.traces.forEach(({ name }, i) => { if (sizes[i] > DWARFS * least) following.hidden.add(name); });
  buildLegend();
  const wide = ({ x }) => (x.high - x.low) / 300;
  following.plot = of("following", following.view, { draw: followingPlot, pick: (frame, x) => frame.valueAt(x), shift: (frame, time, way) => time + way * wide(frame), tell: markTime });
  return [following.plot];
}

function buildLegend() {
  const names = [...following.traces.map(({ name }) => name), ...(data.loop.loop ? ["moved"] : [])];
  byId("alive-following-legend").append(...names.map((name) => {
    const button = element("button", { type: "button", value: name, text: LOOKS[name]?.word ?? name, "aria-pressed": String(!following.hidden.has(name)),
      onclick: () => {
        if (!following.hidden.delete(name)) following.hidden.add(name);
        button.setAttribute("aria-pressed", String(!following.hidden.has(name)));
        following.plot.show();
      } });
    const { colour, width, dash } = lookOf(name);
    button.style.setProperty("border-bottom", `${Math.max(2, width)}px ${dash ? "dashed" : "solid"} ${colour}`);
    return button;
  }));
}

// --- with these values --------------------------------------------------------------------------------------------------

function keyNow() { return JSON.stringify(alive.values, (_, value) => (Number.isFinite(value) || typeof value !== "number" ? value : String(value))); }

function setupNow() {
  const { loop } = data.loop, own = Object.fromEntries(data.model.variables.map(({ name }) => [name, alive.values[name]]));
  const mass = alive.values.M ? loop.mass / first.M[0] * alive.values.M[0] : loop.mass;
  return { loop: { ...loop, limit: Number(loop.limit) }, model: data.model, values: own, mass };
}

function peakToPeak({ error }) {
  const [low, high] = extent(error, data.loop.loop.settle);
  return told(high - low, data.model.units.position);
}

function followed(found) {
  found.t ??= found.error.map((_, k) => k * data.loop.loop.sampleTime);
  following.start ??= found;
  following.key = following.wanted;
  following.plot.later();
  tellFollowing();
}

function tellFollowing() {
  const { loop, reason } = data.loop, words = [];
  if (!loop) words.push(`This page cannot simulate the loop with other values: ${reason}.`);
  else if (following.start) {
    const part = loop.count < loop.all ? `the first ${told(loop.count * loop.sampleTime, "s")} of the loop` : "the loop";
    const now = allTraces().at(-1).name === "moved" ? `, and ${peakToPeak(following.asked.found)} with these values` : "";
    words.push(`Following error of ${part}, peak to peak, computed on this page: ${peakToPeak(following.start)} with feedforward of the identified values${now}.`);
  }
  const text = words.join(" ");
  if (byId("alive-following-told").textContent !== text) byId("alive-following-told").textContent = text;
}

function follow() {
  tellFollowing();
  if (!data.loop.loop) return;
  following.asked ??= new Asked("followedMove", followedMove, followed);
  const key = keyNow();
  if (key === following.wanted) return;
  following.wanted = key;
  clearTimeout(following.later);
  following.later = setTimeout(() => following.asked.put(setupNow()), following.start ? AWAIT : 0);
}
