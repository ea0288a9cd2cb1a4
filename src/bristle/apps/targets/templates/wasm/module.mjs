// Friction of an axis: {{ model }}. Written by bristle {{ version }}.
{% for line in facts %}// {{ line | folded('// ') }}
{% endfor %}/*
{{ table }}
*/
// import { load } from "./{{ name }}.mjs";
// const axis = await load();          // or load(bytes) of {{ name }}.wasm
// axis.force(x, dt);                  // in every cycle: the mean friction force of the step that ends at x
// axis.forces(positions, dt);         // the same for each of several positions, one after another
// axis.set(name, value);              // change a parameter from the next call on; RangeError outside its range
// const bytes = axis.save();          // the state of the contact, in the format of the export to C, without parameters
// axis.load(bytes);                   // restore it; RangeError if the bytes are damaged or of another model
// Call k gives element k of br.response(model, x, dt{% if rest %}, rest="{{ rest }}"{% endif %}). The first call sets the position of the axis, and returns 0.

const LASTING = {{ lasting }};
const PLACES = {{ places }};
const RANGES = {{ ranges }};
// Format of a saved state: layout, position and force, marks, the numbers of the state, those of the contact, checksum.
// VALUES has the number of values of each whole number of the state, and 0 for a real number.
const LAYOUT = {{ layout }}n;
const VALUES = {{ values }};
const CONTACT = {{ contact }};
const MEMORY = {{ memory }};
const SAVED = 8 * (5 + VALUES.length + MEMORY);

async function bytesBeside() {
  const url = new URL("./{{ name }}.wasm", import.meta.url);
  if (url.protocol !== "file:") return (await fetch(url)).arrayBuffer();
  return (await import("node:fs/promises")).readFile(url);
}

function checksum(bytes) {
  let value = {{ FNV_OFFSET }}n;
  for (const byte of bytes) value = BigInt.asUintN(64, (value ^ BigInt(byte)) * {{ FNV_PRIME }}n);
  return value;
}

// Return the state in saved bytes; null if they are damaged, of another model, or contain an impossible state.
function restored(bytes) {
  if (!(bytes instanceof Uint8Array) || bytes.length !== SAVED) return null;
  const view = new DataView(bytes.buffer, bytes.byteOffset, SAVED);
  const last = SAVED - 8;
  if (view.getBigUint64(0, true) !== LAYOUT || view.getBigUint64(last, true) !== checksum(bytes.subarray(0, last))) {
    return null;
  }
  const [begun, flags] = [view.getUint32(24, true), view.getUint32(28, true)];
  const at = (place) => view.getFloat64(32 + 8 * place, true);
  const whole = (place) => Number(view.getBigUint64(32 + 8 * place, true));
  const state = VALUES.map((most, place) => (most ? whole(place) : at(place)));
  const contact = Array.from({ length: MEMORY }, (_, place) => at(VALUES.length + place));
  const ends = [view.getFloat64(8, true), view.getFloat64(16, true)];
  const fits = VALUES.every((most, place) => !most || state[place] < most);
  return begun < 2 && flags < 4 && fits && [...ends, ...state, ...contact].every(Number.isFinite)
    ? { ends, begun, flags, state, contact } : null;
}

export async function load(bytes) {
  const { instance } = await WebAssembly.instantiate(bytes ?? (await bytesBeside()));
  const { memory, advance } = instance.exports;
  const numbers = new Float64Array(memory.buffer);
  const virgin = numbers.slice();
  const lasting = LASTING / 8;
  return {
    // Reset, with the exported parameters.
    start() { numbers.set(virgin); },
    force: advance,
    forces(positions, dt) {
      const all = new Float64Array(positions.length);
      for (let k = 0; k < all.length; ++k) all[k] = advance(positions[k], dt);
      return all;
    },
    get refused() { return numbers[lasting + {{ REFUSED }}] !== 0; },
    get overflow() { return numbers[lasting + {{ OVERFLOW }}] !== 0; },
    parameters: Object.keys(PLACES),
    save() {
      const bytes = new Uint8Array(SAVED);
      const view = new DataView(bytes.buffer);
      view.setBigUint64(0, LAYOUT, true);
      view.setFloat64(8, numbers[lasting + {{ POSITION }}], true);
      view.setFloat64(16, numbers[lasting + {{ FORCE }}], true);
      view.setUint32(24, numbers[lasting + {{ BEGUN }}], true);
      view.setUint32(28, numbers[lasting + {{ REFUSED }}] + 2 * numbers[lasting + {{ OVERFLOW }}], true);
      VALUES.forEach((most, place) => {
        const number = numbers[lasting + {{ STATE }} + place];
        if (most) view.setBigUint64(32 + 8 * place, BigInt(number), true);
        else view.setFloat64(32 + 8 * place, number, true);
      });
      for (let place = 0; place < MEMORY; ++place) {
        view.setFloat64(32 + 8 * (VALUES.length + place), numbers[CONTACT / 8 + place], true);
      }
      view.setBigUint64(SAVED - 8, checksum(bytes.subarray(0, SAVED - 8)), true);
      return bytes;
    },
    load(bytes) {
      const then = restored(bytes);
      if (!then) throw new RangeError("the bytes are damaged, or not of {{ model }}");
      numbers.set([...then.ends, then.begun, then.flags & 1, then.flags >> 1, ...then.state], lasting);
      numbers.set(then.contact, CONTACT / 8);
    },
    // Change a parameter: a number, or as many as it has.
    set(name, value) {
      if (!Object.hasOwn(PLACES, name)) throw new RangeError(`${name} is not a parameter; the parameters are ${Object.keys(PLACES).join(", ")}`);
      const values = typeof value === "number" ? [value] : Array.from(value);
      const [least, most] = RANGES[name];
      const count = PLACES[name][0].length;
      if (values.length !== count) throw new RangeError(`${name}: ${count} numbers are needed`);
      const fits = (each) => each >= (least ?? -Number.MAX_VALUE) && each <= (most ?? Infinity);
      if (!values.every((each) => typeof each === "number" && fits(each))) {
        throw new RangeError(`${name}: ${value} is not allowed; from ${least ?? "any"} to ${most ?? "any"}`);
      }
      for (const place of PLACES[name]) place.forEach((at, i) => { numbers[at / 8] = values[i]; });
    },
    get(name) {
      if (!Object.hasOwn(PLACES, name)) throw new RangeError(`${name} is not a parameter`);
      const values = PLACES[name][0].map((at) => numbers[at / 8]);
      return values.length === 1 ? values[0] : values;
    },
  };
}
