"use strict";
// The paths of a contact, and the numbers read off them.

// For each preset: the turning points over the amplitude, and the amplitude over the pre-sliding distance.
const PRESETS = {
  triangle: { word: "Triangle", turns: [0, 1, -1, 1, -1, 1], amplitude: 5 },
  loops: { word: "Inner loops", turns: [0, 1, -1, 0.8, -0.8, 0.6, -0.6, 0.4, -0.4, 0.2, -0.2, 0], amplitude: 3 },
  minor: { word: "Minor loop", turns: [0, 1, -1, 0.6, -0.2, 0.6, 1], amplitude: 1, closes: [3, 5] },
  presliding: { word: "Pre-sliding", turns: [0, 1, -1, 1, -1, 1], amplitude: 0.4 },
  drawn: { word: "Your own path", turns: null, amplitude: 5 },
  // A mass on a spring: speed of the far end over v_e, or force over the scale of force, at a share of the time.
  hold: { word: "Pull the spring, then hold", speed: (share, stretch) => Number(stretch(share) < 1.1), amplitude: 5 },
  pulled: { word: "Pull the spring", speed: () => 1, amplitude: 5 },
  fro: { word: "Pull to and fro", speed: (share) => 1 - 2 * (Math.floor(4 * share + 0.5) % 2), amplitude: 5 },
  ripple: { word: "Force with a ripple", effort: (share) => (share < 1 / 16 ? 9.6 * share : 0.45 + 0.15 * Math.cos(2 * Math.PI * (share - 1 / 16) * CYCLES_PULLED)), amplitude: 5 },
  hand: { word: "Spring in your hand", amplitude: 5 },
  tracked: { word: "Motion in closed loop", amplitude: 5 },
};
const SAMPLES = 20000, MOST_HALVED = 3, CYCLES_PULLED = 32 / 3;

// A smaller number of samples: a power of two fewer than all, so that the curves of the initial values, which are drawn
// next to the present curves, need no new computation with each move.
function samplesWithin(times) { return SAMPLES / 2 ** Math.min(Math.ceil(Math.log2(times)), MOST_HALVED); }

// Positions at constant speed from turn to turn, with a sample at each turn: `at` contains the samples of the turns.
function pathThrough(turns, amplitude, count) {
  const lengths = turns.slice(1).map((turn, i) => Math.abs(turn - turns[i]));
  const total = lengths.reduce((sum, length) => sum + length, 0);
  const x = new Float64Array(count), at = [0];
  let travelled = 0;
  lengths.forEach((length, i) => {
    travelled += length;
    const first = at[i], last = i === lengths.length - 1 ? count - 1 : Math.round((count - 1) * travelled / total);
    for (let k = first + 1; k <= last; k++) {
      x[k] = amplitude * (turns[i] + (turns[i + 1] - turns[i]) * ((k - first) / (last - first)));
    }
    at.push(last);
  });
  return { x, at, length: total * amplitude };
}

// Positions while the velocity rises and falls linearly between two ends: mean velocities of steps.
function sweep(top, time, count) {
  const x = new Float64Array(count), v = new Float64Array(count), dt = time / (count - 1), half = (count - 1) / 2;
  for (let k = 1; k < count; k++) {
    const middle = k - 0.5;
    v[k] = top * (1 - 2 * Math.abs(middle - half) / half) * -1;
    x[k] = x[k - 1] + v[k] * dt;
  }
  return { x, v, dt };
}

// The work of friction between two samples: the sum of mean force times step.
function lossBetween(x, force, first, last) {
  let work = 0;
  for (let k = first + 1; k <= last; k++) work += force[k] * (x[k] - x[k - 1]);
  return work;
}

// Root mean square of a difference, and of the first of both.
function misfit(measured, forces) {
  let difference = 0, whole = 0;
  for (let k = 0; k < measured.length; k++) {
    difference += (measured[k] - forces[k]) ** 2;
    whole += measured[k] ** 2;
  }
  return { rms: Math.sqrt(difference / measured.length), share: Math.sqrt(difference / whole) };
}

function extent(values, first = 0) {
  let low = Infinity, high = -Infinity;
  for (let k = first; k < values.length; k++) {
    if (values[k] < low) low = values[k];
    if (values[k] > high) high = values[k];
  }
  return low <= high ? [low, high] : [-1, 1];
}

// --- numbers for people ---------------------------------------------------------------------------------------------

const PREFIXES = [[1e6, 1e-6, "M"], [1e4, 1e-3, "k"], [1, 1, ""], [1e-3, 1e3, "m"], [1e-6, 1e6, "µ"], [0, 1e9, "n"]];

// The most readable multiple of a unit for a number of this magnitude; a prefix before a power stays.
function scaleOf(unit, magnitude) {
  if (unit === "N/m" && magnitude >= 100) return magnitude >= 1e5 ? { factor: 1e-6, unit: "N/µm" } : { factor: 1e-3, unit: "N/mm" };
  if (!/^(m|N|rad|s|J)(?![A-Za-z²³^])/.test(unit) || !(magnitude > 0)) return { factor: 1, unit };
  const prefixes = /^[ms]/.test(unit) || unit.startsWith("rad") ? PREFIXES.slice(2) : PREFIXES;
  const [, factor, letter] = prefixes.find(([from]) => magnitude >= from * (1 - 1e-12)) ?? prefixes.at(-1);
  return { factor, unit: letter + unit };
}

function told(value, unit, digits = 3) {
  if (!Number.isFinite(value)) return `${value === Infinity ? "∞" : value === -Infinity ? "−∞" : "not a number"} ${unit}`.trim();
  const scale = scaleOf(unit, Math.abs(value));
  return `${withDigits(value * scale.factor, digits)}\u00a0${scale.unit}`.trim().replace("-", "−");
}

function withDigits(value, digits) {
  const rounded = Number(value.toPrecision(digits));
  const size = Math.abs(rounded);
  return size !== 0 && (size >= 1e6 || size < 1e-4) ? rounded.toExponential().replace("e+", "e") : String(rounded);
}

// A number as typed into a field or a file: exact to the bit.
function typed(value) {
  if (!Number.isFinite(value)) return value > 0 ? "inf" : "-inf";
  const size = Math.abs(value);
  return size !== 0 && (size < 1e-3 || size >= 1e6) ? value.toExponential().replace("e+", "e") : String(value);
}

function read(text) {
  const plain = text.trim().toLowerCase().replace("−", "-").replace("∞", "inf");
  if (plain === "inf" || plain === "-inf") return plain === "inf" ? Infinity : -Infinity;
  return /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/.test(plain) ? Number(plain) : NaN;
}

// A number as typed into a field with a prefix before its unit, and back: exact, a power of ten moves the point only.
function typedIn(value, factor) { return typed(factor === 1 || !Number.isFinite(value) ? value : Number((value * factor).toPrecision(15))); }

function readIn(text, factor) {
  const number = read(text), digits = String(number);
  if (factor === 1 || !Number.isFinite(number)) return number;
  return digits.includes("e") ? number / factor : Number(`${digits}e${-Math.round(Math.log10(factor))}`);
}

// --- sliders --------------------------------------------------------------------------------------------------------

const STOPS = 2000;

function atStop(slider, stop) {
  const share = stop / STOPS;
  if (!slider.logarithmic) return Number((slider.low + share * (slider.high - slider.low)).toPrecision(4));
  if (slider.to_zero && stop === 0) return 0;
  if (slider.endless && stop === STOPS) return Infinity;
  return Number((slider.low * (slider.high / slider.low) ** share).toPrecision(4));
}

function stopAt(slider, value) {
  const share = !slider.logarithmic ? (value - slider.low) / (slider.high - slider.low)
    : value <= 0 ? 0 : value === Infinity ? 1 : Math.log(value / slider.low) / Math.log(slider.high / slider.low);
  return Math.round(STOPS * Math.min(1, Math.max(0, share)));
}

// --- conditions between parameters ------------------------------------------------------------------------------------

const HOLDS = { ">=": (a, b) => a >= b, ">": (a, b) => a > b, "<": (a, b) => a < b };

function product(factors, values) {
  return factors.reduce((whole, factor) => whole * (values[factor] ? values[factor][0] : Number(factor)), 1);
}

// The smallest factor of friction along the axis.
function leastFactor([p_1], [p_2]) {
  const turn = p_2 ? Math.max(-1, Math.min(-0.5 * p_1 / p_2, 1)) : 0;
  return Math.min(...[-1, 1, turn].map((at) => 1 + at * p_1 + at * at * p_2));
}

function met({ left, sign, right, least }, values) {
  if (least !== undefined) return leastFactor(values.p_1, values.p_2) > least;
  return HOLDS[sign](product(left, values), product(right, values));
}

function broken(model, values) {
  return model.conditions.filter((condition) => !met(condition, values));
}

// Shares with sum 1 after a change of one share: the others keep their proportions.
function shared(shares, moved) {
  const left = 1 - shares[moved];
  const rest = shares.reduce((sum, share, i) => sum + (i === moved ? 0 : share), 0);
  return shares.map((share, i) => (i === moved ? share : rest > 0 ? share * left / rest : left / (shares.length - 1)));
}

// --- as text to be copied -----------------------------------------------------------------------------------------------

function written(variable, values, endless) {
  if (variable.choices.length) return JSON.stringify(variable.choices[values[0]]);
  if (variable.whole) return typed(values[0]);
  const texts = values.map((value) => (endless && !Number.isFinite(value) ? endless(value) : typed(value)));
  return variable.array ? `[${texts.join(", ")}]` : texts[0];
}

function asToml(model, values) {
  const lines = model.variables.map((variable) => {
    const meaning = variable.unit ? `${variable.unit}: ${variable.description}` : variable.description;
    return `${variable.key} = ${written(variable, values[variable.name])}  # ${meaning}`;
  });
  return ["schema = 1", `kind = "${model.kind}"`, "", "[friction]", model.head.toml, ...lines, ""].join("\n");
}

function asPython(model, values) {
  if (!model.head.python) return "";
  const infinite = (value) => `float("${typed(value)}")`;
  const lines = model.variables.map((variable) => `    ${variable.name}=${written(variable, values[variable.name], infinite)},`);
  return ["import bristle as br", "", `model = ${model.head.python}(`, `    kind="${model.kind}",`, ...lines, ")", ""].join("\n");
}
