// Friction of an axis: {{ model }}. Written by bristle {{ version }}.
{% for line in facts %}// {{ line }}
{% endfor %}/*
{{ table }}
*/
// import { load } from "./{{ name }}.mjs";
// const axis = await load();          // or load(bytes) of {{ name }}.wasm
// axis.force(x, dt);                  // in every cycle: the mean friction force of the step that ends at x
// Call k gives element k of br.response(model, x, dt{% if rest %}, rest="{{ rest }}"{% endif %}), to the bit. The first call tells where the axis is, and gives 0.

const LASTING = {{ lasting }};
const PLACES = {{ places }};
const RANGES = {{ ranges }};

async function bytesBeside() {
  const url = new URL("./{{ name }}.wasm", import.meta.url);
  if (url.protocol !== "file:") return (await fetch(url)).arrayBuffer();
  return (await import("node:fs/promises")).readFile(url);
}

export async function load(bytes) {
  const { instance } = await WebAssembly.instantiate(bytes ?? (await bytesBeside()));
  const { memory, advance } = instance.exports;
  const numbers = new Float64Array(memory.buffer);
  const virgin = numbers.slice();
  const lasting = LASTING / 8;
  return {
    // Begin anew, with the parameters that were exported.
    start() { numbers.set(virgin); },
    force: advance,
    get refused() { return numbers[lasting + {{ REFUSED }}] !== 0; },
    get overflow() { return numbers[lasting + {{ OVERFLOW }}] !== 0; },
    parameters: Object.keys(PLACES),
    // Change a parameter: a number, or as many as it has.
    set(name, value) {
      const values = typeof value === "number" ? [value] : value;
      const [least, most] = RANGES[name];
      if (!values.every((each) => each >= (least ?? -Number.MAX_VALUE) && each <= (most ?? Infinity))) {
        throw new RangeError(`${name}: ${value} is not allowed; from ${least ?? "any"} to ${most ?? "any"}`);
      }
      for (const place of PLACES[name]) place.forEach((at, i) => { numbers[at / 8] = values[i]; });
    },
    get(name) {
      const values = PLACES[name][0].map((at) => numbers[at / 8]);
      return values.length === 1 ? values[0] : values;
    },
  };
}
