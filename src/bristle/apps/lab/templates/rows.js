// The rows of an identification: the motion of the model, and its forces after filters and plant.

async function rowsOf(rows) {
  const { step, sampleTime } = rows, next = await columnsOf(rows.numbers);
  const stretches = rows.stretches.map(({ intervals, rows: count, ...rest }) => {
    const ends = next(intervals, 2), places = next(intervals, 2, step).map((place) => rest.origin + place);
    return { ...rest, ends, places, at: next(count, 2) };
  });
  const t = Float64Array.from(stretches.flatMap(({ time, at }) => [...at].map((sample) => time + sampleTime * sample)));
  const measured = next(t.length, 1, rows.measured);
  const mechanical = rows.mechanical.map(({ name, step: unit }) => ({ name, values: next(t.length, 1, unit) }));
  const found = { ...rows, stretches, t, measured, mechanical, runs: runsIn(t) };
  found.velocity = weighed(found, stretches.map((stretch) => meanVelocities(stretch, sampleTime)));
  return found;
}

// First and last row of each stretch without a rest or a gap.
function runsIn(t) {
  const steps = t.slice(1).map((time, k) => time - t[k]), usual = 1.5 * Float64Array.from(steps).sort()[steps.length >> 1];
  const ends = [...steps.keys()].filter((k) => steps[k] > usual);
  return [0, ...ends.map((k) => k + 1)].map((first, i) => [first, ends[i] ?? t.length - 1]);
}

function meanVelocities({ places, ends, origin }, sampleTime) {
  return places.map((place, k) => (place - (k ? places[k - 1] : origin)) / (sampleTime * (k ? ends[k] - ends[k - 1] : ends[0] + 1)));
}

// The mean force of each interval of a stretch. At rest after a backward move, the backward force applies.
function forcesIn(contact, { places, ends, begin, origin }, sampleTime) {
  let last = origin, side = 1;
  contact.begin();
  for (const [place, number] of begin) contact.lasts(place, number);
  contact.advance(origin, 1);
  return places.map((place, k) => {
    const force = contact.advance(place, sampleTime * (k ? ends[k] - ends[k - 1] : ends[0] + 1)), rests = place === last;
    if (!rests) side = place - last;
    last = place;
    return rests && side < 0 ? contact.rest(-0, 0) : force;
  });
}

// The filtered signal in each row; beyond the ends it is constant.
function weighed({ response, stretches, t }, signals) {
  const values = new Float64Array(t.length), middle = response.length >> 1, whole = response[response.length - 1];
  let row = 0;
  stretches.forEach(({ ends, at }, i) => {
    const signal = signals[i], last = signal.length - 1;
    let first = 0;
    for (const sample of at) {
      while (first < last && ends[first] < sample - middle) first++;
      let sum = 0, before = 0;
      for (let k = first; k <= last; k++) {
        const place = ends[k] - sample + middle, share = k === last || place >= response.length - 1 ? whole : response[Math.max(place, 0)];
        sum += (share - before) * signal[k];
        before = share;
        if (place >= response.length - 1) break;
      }
      values[row++] = sum / whole;
    }
  });
  return values;
}

// The effort of the plant in each row, with these values of its parameters.
function mechanicalInRows({ mechanical, t }, values) {
  const effort = new Float64Array(t.length);
  for (const { name, values: column } of mechanical) {
    const times = name ? values[name][0] : 1;
    for (let k = 0; k < effort.length; k++) effort[k] += times * column[k];
  }
  return effort;
}
