// The following error in the large picture: the whole log at once, and with the present values.

const AWAIT = 120; // [ms]
const CURVES = { measured: "measured", compensated: "with friction" };
const following = { asked: null, key: "", wanted: "", later: 0, start: null };

async function traceOf({ name, numbers, count, step, time, sampleTime }) {
  const next = await columnsOf(numbers), samples = next(count, 2);
  return { name, t: samples.map((sample) => time + sampleTime * sample), error: next(count, 1, step) };
}

// The large picture has only the lines around the worst reversal: add the rest of the log, for the strip under it.
async function drawTraces() {
  const panel = plots.get("gain")?.panels[0], traces = await Promise.all(data.loop.traces.map(traceOf));
  if (!panel) return;
  const without = traces.some(({ name }) => name === "feedforward") ? "feedforward" : "as_recorded", [low, high] = panel.facts.x.ends;
  for (const { name, t, error } of traces) {
    const curve = panel.curves.find((each) => each.name === (name === without ? "without" : CURVES[name]));
    if (!curve) continue;
    const near_ = panel.pointsOf(curve).map(([x, y]) => [panel.x.value(panel.x.share(x)), panel.y.value(panel.y.share(y))]);
    const [across, up] = scalesOf(panel), far = Array.from(t, (time, k) => [time * across, error[k] * up]);
    const all = [...far.filter(([x]) => x < low), ...near_, ...far.filter(([x]) => x > high)];
    panel.setCurve(curve.name, all.map(([x]) => x), all.map(([, y]) => y));
    const own = panel.artists.find((artist) => artist.node === curve.node.querySelector("path[clip-path]"));
    own.original = own.d;
  }
}

function scalesOf(panel) { return [factorOf(panel.facts.x.word, "s"), factorOf(panel.facts.y.word, data.model.units.position)]; }

function moveGain() {
  const found = isMoved() && following.key === keyNow() ? following.asked?.found : null;
  for (const panel of plots.get("gain")?.panels ?? []) {
    const [across, up] = scalesOf(panel);
    if (!found) panel.setCurve("with friction", null);
    else panel.setCurve("with friction", found.error.map((_, k) => k * data.loop.loop.sampleTime * across), found.error.map((error) => error * up));
  }
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
  following.start ??= found;
  following.key = following.wanted;
  moveGain();
  tellFollowing();
}

function tellFollowing() {
  const { loop, reason } = data.loop, words = [];
  if (!loop) words.push(`This page cannot simulate the loop with other values: ${reason}.`);
  else if (following.start) {
    const part = loop.count < loop.all ? `the first ${told(loop.count * loop.sampleTime, "s")} of the loop` : "the loop";
    const now = isMoved() && following.key === keyNow() ? `, and ${peakToPeak(following.asked.found)} with these values` : "";
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
  if (!isMoved()) moveGain();
  clearTimeout(following.later);
  following.later = setTimeout(() => following.asked.put(setupNow()), following.start ? AWAIT : 0);
}
