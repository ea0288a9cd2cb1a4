// The following error of a mass with friction in a loop with an encoder and a delay: control law alone, with friction
// feedforward, with an observer, and with both. It runs in a worker if the host allows it.

const CUTOFF = 400, LAYER = 2e-5, NOISE = 0.08, SUBSTEPS = 2; // [Hz], [m/s or rad/s], of a count, steps of a sample
const WAYS = { none: "sliding", model: "sliding", observer: "observer", both: "observer" };

// Laws and encoder, ready to run. A law reads its inputs from its persistent memory.
async function loadedParts(loop) {
  const { exports } = new WebAssembly.Instance(await moduleOf(loop));
  const numbers = new Float64Array(exports.memory.buffer), virgin = numbers.slice();
  const at = Object.fromEntries(Object.entries(loop.parts).map(([name, { lasting }]) => [name, lasting / 8]));
  return {
    begin(values) {
      numbers.set(virgin);
      for (const { places } of Object.values(loop.parts)) {
        for (const [name, value] of Object.entries(values)) for (const [place] of places[name] ?? []) numbers[place / 8] = value;
      }
    },
    sense(x, dt) { return exports.sense(x, dt); },
    command(law, desired, measured, dt) {
      numbers.set(desired, at[law] + 1);
      return exports[law](measured, dt);
    },
  };
}

// The friction feedforward of a model along a motion, from each sample to the next. At rest, a model without
// memory keeps the force of the last direction.
function fedForward(contact, places, dt) {
  const forces = new Float64Array(places.length - 1);
  let side = 0;
  contact.begin();
  contact.advance(places[0], dt);
  for (let k = 0; k < forces.length; k++) {
    const step = places[k + 1] - places[k], force = contact.advance(places[k + 1], dt);
    if (step !== 0) side = Math.sign(step);
    forces[k] = step === 0 && contact.model.holds ? 0.5 * (1 + side) * force + 0.5 * (1 - side) * contact.rest(-0, 0) : force;
  }
  return forces;
}

// True and measured position of the mass at each sample.
function followed(parts, body, law, desired, told, { dt, delay, count, values }) {
  const x = new Float64Array(count), read = new Float64Array(count), commands = new Float64Array(count);
  parts.begin(values);
  body.begin();
  body.put(desired.x[0], desired.v[0]);
  for (let k = 0; k < count; k++) {
    x[k] = body.x;
    read[k] = parts.sense(x[k], dt);
    commands[k] = parts.command(law, [desired.x[k], desired.v[k], desired.a[k], told ? told[k] : 0], read[k], dt);
    const applied = k >= delay ? commands[k - delay] : 0;
    for (let i = 0; i < SUBSTEPS; i++) body.push(applied, dt / SUBSTEPS);
  }
  return { x, read };
}

function sineOf(amplitude, frequency, count, dt) {
  const w = 2 * Math.PI * frequency, x = new Float64Array(count), v = new Float64Array(count), a = new Float64Array(count);
  for (let k = 0; k < count; k++) {
    x[k] = amplitude * Math.sin(w * k * dt);
    v[k] = amplitude * w * Math.cos(w * k * dt);
    a[k] = -w * w * x[k];
  }
  return { x, v, a };
}

// Two periods in all four variants, of which the second is shown.
async function tracked({ loop, model, values, body, bodyValues, settings }) {
  const [parts, contact, mass] = [await loadedParts(loop), await loaded(model), await loaded(body)];
  const { M, gain, K_2, g, resolution, A, f } = settings, { delay } = loop, dt = Math.min(loop.sampleTime, 1 / (500 * f));
  for (const [name, list] of Object.entries(values)) contact.set(name, list);
  for (const [name, list] of Object.entries({ ...bodyValues, M: [M], k: [0], v_e: [0] })) mass.set(name, list);
  const period = Math.round(1 / (f * dt)), count = 2 * period;
  const setup = { dt, delay, count, values: { J: M, lambda_: gain, K_1: gain, K_2, phi: LAYER, cutoff: CUTOFF, g, resolution, noise: NOISE * resolution } };
  const desired = sineOf(A, f, count + delay + 1, dt), told = fedForward(contact, desired.x, dt).subarray(delay);
  const errors = Object.fromEntries(Object.keys(WAYS).map((way) => {
    const { x } = followed(parts, mass, WAYS[way], desired, way === "model" || way === "both" ? told : null, setup);
    return [way, x.map((place, k) => desired.x[k] - place).slice(period)];
  }));
  return { dt, period, errors, amplitude: A, frequency: f };
}
