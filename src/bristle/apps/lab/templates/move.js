// The loop of a log: the axis follows the recorded reference, with the feedforward of a model.

function slopes(x, dt) {
  const last = x.length - 1;
  return x.map((_, k) => (x[Math.min(k + 1, last)] - x[Math.max(k - 1, 0)]) / (dt * (Math.min(k + 1, last) - Math.max(k - 1, 0))));
}

// The recorded reference with velocity and acceleration; beyond its end it stands still.
function recordedReference({ reference, origin, sampleTime, delay }) {
  const v = slopes(reference, sampleTime), a = slopes(v, sampleTime), count = reference.length;
  const places = Float64Array.from({ length: count + delay + 1 }, (_, k) => origin + reference[Math.min(k, count - 1)]);
  places[count + delay] += places[count + delay - 1] - places[count + delay - 2];
  return { x: places.subarray(0, count), v, a, places };
}

function fedAlong({ places, a }, contact, mass, { delay, sampleTime }) {
  const friction = fedForward(contact, places, sampleTime), at = (k) => (k < a.length ? a[k] : 0), last = a.length + delay - 1;
  return a.map((_, k) => friction[k + delay] + mass * 0.5 * (at(k + delay) + at(Math.min(k + delay + 1, last))));
}

// The following error at each sample, measured by the encoder.
async function followedMove({ loop, model, values, mass }) {
  const { sampleTime: dt, substeps, delay, limit, lag, begin } = loop, next = await columnsOf(loop.numbers), count = loop.count;
  const reference = next(count, 2, loop.step), disturbance = next(count, 1, loop.pushed);
  const [parts, contact, body] = [await loadedParts(loop), await loaded(model), await loaded(loop.body ?? model)];
  for (const [name, list] of Object.entries(values)) contact.set(name, list);
  for (const [name, list] of Object.entries({ ...loop.bodyValues, M: [loop.M], k: [0], v_e: [0] })) body.set(name, numbersOf(list));
  const desired = recordedReference({ reference, origin: loop.origin, sampleTime: dt, delay }), fed = fedAlong(desired, contact, mass, loop);
  const commands = new Float64Array(count), error = new Float64Array(count);
  parts.begin({});
  body.begin();
  for (const [place, number] of begin) body.bodyLasts(place, number);
  let drive = loop.effortBefore;
  for (let k = 0; k < count; k++) {
    const read = parts.sense(body.x, dt), asked = parts.command("law", [desired.x[k], desired.v[k], desired.a[k], fed[k]], read, dt);
    commands[k] = Math.max(-limit, Math.min(limit, asked));
    error[k] = desired.x[k] - read;
    const pushed = (k >= delay ? commands[k - delay] : loop.effortBefore) - disturbance[k];
    for (let i = 0; i < substeps; i++) {
      body.push(pushed + lag.inMean * (drive - pushed), dt / substeps);
      drive = pushed + lag.atEnd * (drive - pushed);
    }
  }
  return { error };
}
