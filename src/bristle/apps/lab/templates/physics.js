"use strict";
// The physics of the page: modules of WebAssembly, and their functions.

function numbersOf(values) { return values.map(Number); }

function bytesOf(code) { return Uint8Array.from(atob(code), (letter) => letter.charCodeAt(0)); }

// Unpack deflated bytes. A stored block in front of them holds the end of `before`, the data that they may refer to.
async function inflated(code, before = new Uint8Array()) {
  const known = before.subarray(-32768), { length } = known, head = [0, length, length >> 8, ~length, ~length >> 8];
  const stream = new Blob([Uint8Array.from(head), known, bytesOf(code)]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer()).subarray(length);
}

// A binary may be packed as the continuation of others.
async function binaryOf({ code, before = [] }) {
  const parts = await Promise.all(before.map(binaryOf));
  return inflated(code, Uint8Array.from(parts.flatMap((part) => [...part])));
}

const modules = new Map();

function moduleOf(model) {
  if (!modules.has(model.code)) modules.set(model.code, binaryOf(model).then((bytes) => WebAssembly.compile(bytes)));
  return modules.get(model.code);
}

// The memory of a parameter: forward numbers first if it has both directions.
function placesOf(places, name) {
  const side = ["_pos", "_neg"].indexOf(name.slice(-4)), both = places[name.slice(0, -4)];
  if (places[name]) return places[name];
  if (side >= 0 && both) return both.slice(side * both.length / 2, (side + 1) * both.length / 2);
  return [...(places[`${name}_pos`] ?? []), ...(places[`${name}_neg`] ?? [])];
}

// A friction model, ready to be moved. Its state lies before its parameters in the memory.
async function loaded(model) {
  const instance = new WebAssembly.Instance(await moduleOf(model));
  const { memory, advance, step, rest } = instance.exports;
  const numbers = new Float64Array(memory.buffer);
  const virgin = numbers.slice(0, model.parameters / 8);
  const lasting = model.lasting / 8, contact = model.contact / 8, body = model.body / 8;
  return {
    model, advance, rest,
    begin() { numbers.set(virgin); },
    // A copy of the state of the contact.
    kept(into = new Float64Array(body - lasting)) {
      into.set(numbers.subarray(lasting, body));
      return into;
    },
    back(kept) { numbers.set(kept, lasting); },
    lasts(place, number) { numbers[lasting + place] = number; },
    bodyLasts(place, number) { numbers[body + place] = number; },
    // The mass, released at a position with a velocity and pushed.
    put(x, v) {
      numbers[body] = x;
      numbers[body + 1] = v;
    },
    push(effort, dt) { return step(effort, dt); },
    get x() { return numbers[body]; },
    get end() { return numbers[body + 2]; },
    // No variation with position, load and so on, until parameters are set again.
    hold() { for (const [at, value] of model.still) numbers[at / 8] = value; },
    // A share of a zero level is undefined: use that of infinity.
    set(name, values) {
      for (const place of placesOf(model.places, name)) {
        place.forEach((at, i) => { numbers[at / 8] = values[i] === 0 && model.levels?.includes(at) ? Infinity : values[i]; });
      }
    },
    // Forces along positions; element 0 is 0, and the contact starts without memory. A callback sees it at one sample.
    forces(x, dt, moment = -1, look = () => {}) {
      const forces = new Float64Array(x.length), first = Math.min(moment + 1, x.length);
      numbers.set(virgin);
      for (let k = 0; k < first; k++) forces[k] = advance(x[k], dt);
      if (first > 0) look(this.remembered());
      for (let k = first; k < x.length; k++) forces[k] = advance(x[k], dt);
      return forces;
    },
    // The mass pushed by the effort of a function for each step: position, far end of the spring, friction.
    moved(count, dt, effort) {
      numbers.set(virgin);
      const motion = { x: new Float64Array(count), end: new Float64Array(count), force: new Float64Array(count) };
      for (let k = 0; k < count; k++) {
        motion.force[k] = step(effort(k), dt);
        motion.x[k] = numbers[body];
        motion.end[k] = numbers[body + 2];
      }
      return motion;
    },
    get overflow() { return numbers[lasting + model.overflow] !== 0; },
    // The memory of an operator: turning points with the present input last, or elements; otherwise empty.
    remembered() {
      if (model.elements) return [...numbers.subarray(contact, contact + model.elements.numbers)];
      if (!model.stack) return null;
      const depth = numbers[lasting + model.stack.depth];
      return [...numbers.subarray(contact, contact + depth), numbers[lasting + model.stack.z]];
    },
  };
}

// Corners of the staircase between relays that are up and relays that are down, from the line of the virgin contact
// to the present input: consecutive pairs of turning points, larger value first.
function staircase(remembered) {
  const inputs = [-remembered[0], ...remembered];
  const corners = inputs.slice(1).map((input, i) => [Math.max(input, inputs[i]), Math.min(input, inputs[i])]);
  const last = inputs[inputs.length - 1];
  return [...corners, [last, last]];
}

// The smallest and largest value of each element before it slips.
function limitsOf({ limits, numbers }, values) {
  const at = (names, i) => names.reduce((whole, name) => whole * (values[name][i] ?? values[name][0]), 1);
  return Array.from({ length: numbers }, (_, i) => limits.map(({ times, over }, side) => (2 * side - 1) * at(times, i) / at(over, i)));
}

// --- the walks that compare the bits ----------------------------------------------------------------

const SEED = 20260, FACTOR = 1664525, TERM = 1013904223, PART = 125, RESTS = 16, BLOCK = 1000;

function nextBits(bits) { return (Math.imul(bits, FACTOR) + TERM) >>> 0; }

function walkPositions(scales, count) {
  const x = new Float64Array(count);
  let bits = SEED, at = 0;
  for (let k = 1; k < count; k++) {
    bits = nextBits(bits);
    if ((bits >>> 8) % RESTS) at += ((bits >>> 16) - 32768) * scales[Math.floor(k / PART) % scales.length];
    x[k] = at;
  }
  return x;
}

// The 64-bit hash of Fowler, Noll and Vo (1a) of numbers, in two halves of 32 bits; its prime is 2^40 + 0x1b3.
function hashOf(values) {
  const bytes = new Uint8Array(values.buffer, values.byteOffset, values.byteLength);
  let high = 0xcbf29ce4, low = 0x84222325;
  for (const byte of bytes) {
    low = (low ^ byte) >>> 0;
    const product = low * 0x1b3;
    high = (Math.imul(high, 0x1b3) + Math.floor(product / 0x100000000) + (low << 8)) >>> 0;
    low = product % 0x100000000;
  }
  return high.toString(16).padStart(8, "0") + low.toString(16).padStart(8, "0");
}

function differing(values, hashes, block = BLOCK) {
  return hashes.filter((hash, i) => hashOf(values.subarray(i * block, (i + 1) * block)) !== hash).length;
}

// Positions of a mass with a different push in every step.
function pushedAbout(contact, { count, dt, push }) {
  let bits = SEED;
  return contact.moved(count, dt, () => {
    bits = nextBits(bits);
    return ((bits >>> 16) - 32768) * push;
  }).x;
}

// Repeat the walk of Python, and return the number of differing blocks of steps, and of all blocks.
async function walked(model) {
  const contact = await loaded(model), { contact: walk, mass } = model.walks;
  for (const variable of [...model.variables, ...model.pull]) contact.set(variable.name, numbersOf(variable.values));
  const forces = contact.forces(walkPositions(walk.scales, walk.count), walk.dt);
  return {
    differ: differing(forces, walk.hashes) + differing(pushedAbout(contact, mass), mass.hashes),
    of: walk.hashes.length + mass.hashes.length,
  };
}
