// Adding and removing slots: the description of a model with slots, made from that of the model without slots.

const RISING = ["transmitted", "ripple"];
const ALONG = ["position", "periodic", "ripple"]; // variation along the axis
const ONE_WAY = [["_pos", "+", ", moving forward", 1.1], ["_neg", "−", ", moving backward", 0.9]];

// A number without the additional digits of a product.
function rounded(value) { return Number(value.toPrecision(12)); }

function symbolOf({ name, symbol }, side, sign) {
  if (symbol.endsWith("</sub>")) return symbol.replace(/<\/sub>$/, `${sign}</sub>`);
  return symbol.startsWith("<i>") ? `${symbol}<sub>${side.slice(1)}</sub>` : name + side;
}

function oneWay(row) {
  return ONE_WAY.map(([side, sign, words, share]) => ({ ...row, name: row.name + side, key: row.name + side, symbol: symbolOf(row, side, sign),
    description: row.description + words, values: row.values.map((value) => rounded(share * Number(value))), interval: null, status: "" }));
}

// A number of a slot, given over a scale of the model.
function scaled({ scale, ...row }, scales) {
  if (!scale) return row;
  const times = scales[scale], sliders = row.sliders.map((slider) => ({ ...slider, low: slider.low * times, high: slider.high * times }));
  return { ...row, values: row.values.map((value) => round(value * times)), sliders };
}

// The name of a parameter, with the direction if the model distinguishes directions.
function namings(directional) {
  return directional.size ? ONE_WAY.map(([side]) => (name) => (directional.has(name) ? name + side : name)) : [(name) => name];
}

function conditionsWith(conditions, directional) {
  return conditions.flatMap((condition) => {
    const each = namings(directional).map((named) => ({ ...condition, left: condition.left.map(named), right: condition.right.map(named) }));
    return each.filter(({ left, right }, i) => i === 0 || String([left, right]) !== String([each[0].left, each[0].right]));
  });
}

function elementsWith(elements, directional) {
  if (!elements) return null;
  const [forward, backward = forward] = namings(directional);
  const limit = ({ times, over }, named) => ({ times: times.map(named), over: over.map(named) });
  return { ...elements, limits: [limit(elements.limits[0], backward), limit(elements.limits[1], forward)] };
}

function describedWith(model, on, offers) {
  const causes = (names) => names.map((slot) => offers[slot].cause).join(" and "), parts = [model.description];
  for (const [words, names] of [["its level rising with", RISING], ["varying with", ["position", "load", "temperature"]], ["with", ["periodic"]]]) {
    const causing = on.filter((slot) => names.includes(slot));
    if (causing.length) parts.push(`${words} ${causes(causing)}`);
  }
  return [...parts, ...(on.includes("asymmetry") ? ["by direction"] : [])].join(", ");
}

function headWith({ toml, python }, on) {
  const name = on.map((slot) => `+${slot}`).join("");
  if (python) return { toml: toml.replace(/"$/, `${name}"`), python: python.replace(/"\)$/, `${name}")`) };
  const quoted = on.map((slot) => `"${slot}"`).join(", ");
  if (!on.length) return { toml, python };
  return { toml: toml.endsWith("]") ? toml.replace(/\]$/, `, ${quoted}]`) : `${toml}\nslots = [${quoted}]`, python };
}

// The module with every slot, and the memory of its parameters with neutral values.
function wideOf({ wide }, offers) {
  const rows = Object.values(offers).flatMap((slot) => [...(slot.rows ?? []), ...(slot.around ? [slot.around] : [])]);
  return { ...wide, still: rows.flatMap(({ name, nothing }) => placesOf(wide.places, name).flat().map((at) => [at, nothing])) };
}

// A model with these slots, in the form of Python: `offers` describes the slots for this kind of axis.
function withSlots(model, slots, offers) {
  const on = model.offered.filter((slot) => slots.includes(slot)), sided = on.includes("asymmetry"), varies = on.some((slot) => slot !== "asymmetry");
  const added = new Map(on.flatMap((slot) => offers[slot]?.rows ?? []).map((row) => [row.name, scaled(row, model.scales)]));
  const plain = [...model.variables.slice(0, -1), ...added.values(), ...model.variables.slice(-1)];
  const directional = new Set(sided ? plain.filter((row) => row.directional).map(({ name }) => name) : []);
  const own = new Map((model.own?.rows ?? []).map((row) => [row.name, row]));
  const conditions = conditionsWith(model.conditions, directional);
  return { ...model, ...(varies ? wideOf(model, offers) : {}), plain: model, slots: on, varies,
    model: [model.model, ...on].join("+"), description: describedWith(model, on, offers),
    head: headWith(model.head, on),
    variables: plain.flatMap((row) => (directional.has(row.name) ? oneWay(row) : [row])).map((row) => own.get(row.name) ?? row),
    placed: new Set(on.filter((slot) => ALONG.includes(slot)).flatMap((slot) => offers[slot].rows).flatMap(({ name }) => [name, ...ONE_WAY.map(([side]) => name + side)])),
    around: aroundWith(model, on, offers),
    conditions: on.includes("position") ? [...conditions, offers.position.condition] : conditions,
    elements: elementsWith(model.elements, directional) };
}

// The surroundings: usual values for an initial slot, otherwise the initial values of the slot.
function aroundWith(model, on, offers) {
  const put = on.filter((slot) => offers[slot]?.around).map((slot) => {
    const row = scaled(offers[slot].around, model.scales);
    return ownSlots(model).includes(slot) ? { ...row, values: [row.nothing] } : row;
  });
  return [...new Map(put.map((row) => [row.name, row])).values()];
}

function ownSlots(model) { return model.own?.slots ?? []; }

// Transfer moved values to another set of slots, also between one parameter and one per direction.
function carried(values, variables) {
  return Object.fromEntries(variables.map(({ name, values: first }) => {
    const side = ONE_WAY.find(([end]) => name.endsWith(end)), both = side && values[name.slice(0, -4)];
    const sides = ONE_WAY.map(([end]) => values[name + end]);
    if (values[name]) return [name, values[name]];
    if (both) return [name, both.map((value) => rounded(side[3] * value))];
    if (sides[0] && sides[1]) return [name, sides[0].map((value, i) => rounded(0.5 * (value + sides[1][i])))];
    return [name, numbersOf(first)];
  }));
}

// --- the walks of all of them ---------------------------------------------------------------------------------------------

// Every combination of slots, or each slot alone and all of them.
function combinations(slots, complete) {
  if (!complete) return [...slots.map((slot) => [slot]), slots];
  return Array.from({ length: 2 ** slots.length }, (_, bits) => slots.filter((_, i) => (bits >> (slots.length - 1 - i)) & 1));
}

async function walkedWithSlots(model, offers) {
  const { differ, of } = await walked(withSlots(model, ownSlots(model), offers));
  const { count, together, complete, hashes, mass } = model.walks.slots, { scales, dt } = model.walks.contact;
  const contacts = new Map(), x = walkPositions(scales, count), sets = combinations(model.offered, complete), forces = new Float64Array(sets.length * count);
  const contactWith = async (slots) => {
    const variant = withSlots({ ...model, own: null }, slots, offers);
    if (!contacts.has(variant.code)) contacts.set(variant.code, await loaded(variant));
    const contact = contacts.get(variant.code);
    contact.hold();
    for (const { name, values } of [...variant.variables, ...model.pull]) contact.set(name, numbersOf(values));
    return [contact, variant];
  };
  for (const [i, slots] of sets.entries()) {
    const [contact, { around }] = await contactWith(slots);
    for (const { name, values } of around) contact.set(name, values);
    forces.set(contact.forces(x, dt), i * count);
  }
  const [contact] = await contactWith(model.offered), pushed = pushedAbout(contact, model.walks.mass);
  return { differ: differ + differing(forces, hashes, together * count) + differing(pushed, mass), of: of + hashes.length + mass.length };
}
