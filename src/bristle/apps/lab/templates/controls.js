// Number fields with sliders: one for each number that can be changed.

function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key === "text") made.textContent = value;
    else if (key === "html") made.innerHTML = value; // symbols: written by bristle, escaped there
    else if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (value !== false) made.setAttribute(key, value === true ? "" : value);
  }
  made.append(...children.filter(Boolean));
  return made;
}

function allowedIn(variable) {
  const low = Number(variable.min), high = Number(variable.max), unit = variable.unit ? ` ${variable.unit}` : "";
  if (low === -Infinity && high === Infinity) return `a number${unit && ` in${unit}`}`;
  if (high === Infinity) return `${typed(low)}${unit} or more`;
  return low === -Infinity ? `${typed(high)}${unit} or less` : `${typed(low)} to ${typed(high)}${unit}`;
}

function numbered(symbol, number) {
  return symbol.endsWith("<sub>i</sub>") ? symbol.replace("<sub>i</sub>", `<sub>${number}</sub>`) : `${symbol}<sub>${number}</sub>`;
}

let controls = 0;

// A field and a slider for one number of a variable. `input` is called during a move, `change` at its end.
function control(variable, index, { input, change, start, text = (value) => value }) {
  const slider = { ...variable.sliders[index], low: Number(variable.sliders[index].low), high: Number(variable.sliders[index].high) };
  const name = variable.array ? `${variable.name}[${index + 1}]` : variable.name;
  const id = `number-${controls++}`, told_ = `${variable.description}${variable.array ? `, ${index + 1}` : ""}`;
  const field = element("input", { id, type: "text", inputmode: "decimal", autocomplete: "off", spellcheck: "false", disabled: variable.fixed });
  const range = element("input", { type: "range", name, min: 0, max: STOPS, step: 1, "aria-label": `${told_}, slider`, disabled: variable.fixed });
  const unit = element("span", { class: "unit", text: variable.unit }), scaleFor = (value) => scaleOf(variable.unit, Math.abs([value, start(), slider.low].find((each) => each && Number.isFinite(each)) ?? 1));
  let scale = scaleFor(start());
  const refused = element("p", { class: "refused", role: "alert", hidden: true });
  const back = element("button", { type: "button", class: "back", title: `Reset ${name}`, "aria-label": `Reset ${name}`, text: "↺" });
  const root = element("div", { class: "card" },
    element("label", { for: id },
      element("span", { class: "symbol", html: variable.array ? numbered(variable.symbol, index + 1) : variable.symbol }),
      element("span", { class: "meaning", text: told_ })),
    element("div", { class: "number" }, field, unit, back),
    variable.fixed ? element("p", { class: "note", text: "fixed on this page" }) : element("div", { class: "track" }, markOf(variable, slider), range),
    refused);
  const refuse = (text) => {
    refused.hidden = !text;
    refused.textContent = text;
    field.setAttribute("aria-invalid", text ? "true" : "false");
  };
  range.addEventListener("input", () => { refuse(""); input(atStop(slider, Number(range.value)), "slider"); });
  range.addEventListener("change", () => change(name));
  field.addEventListener("change", () => {
    const value = readIn(field.value, scale.factor);
    if (!(value >= Number(variable.min) && value <= Number(variable.max))) {
      return refuse(`${field.value || "An empty field"} is not allowed. Allowed: ${allowedIn(variable)}`);
    }
    refuse("");
    input(value, "field");
    change();
  });
  back.addEventListener("click", () => { refuse(""); input(start(), "field"); change(); field.focus(); });
  return {
    root,
    show(value, from) {
      scale = scaleFor(value);
      field.value = typedIn(text(value), scale.factor);
      if (unit.textContent !== scale.unit) unit.textContent = scale.unit;
      if (from !== "slider") range.value = stopAt(slider, value);
      range.setAttribute("aria-valuetext", told(value, variable.unit, 4));
      back.hidden = value === start();
      root.classList.toggle("moved", value !== start());
    },
  };
}

// The cards of a variable, one for each of its numbers.
function cardsOf(variable, count, handlers) {
  return variable.choices.length ? [choice(variable, handlers(0))] : Array.from({ length: count }, (_, i) => control(variable, i, handlers(i)));
}

function showIn(cards, values, index = -1, from = "field") { cards.forEach((each, i) => each.show(values[i], i === index ? from : "field")); }

// The broken conditions of the values, each with a remedy: bristle writes and escapes the symbols and remedies.
function brokenLines(model, values) {
  const symbols = Object.fromEntries(model.variables.map(({ name, symbol }) => [name, symbol]));
  const said = (factors) => factors.map((factor) => symbols[factor] ?? factor).join(" · ");
  const lines = broken(model, values).map(({ left, sign, right, text, mend, advisory }) =>
    `${advisory ? "Recommended" : "Required"}: ${text ?? `${said(left)} ${sign === ">=" ? "≥" : sign === "<" ? "&lt;" : "&gt;"} ${said(right)}`}. ${mend}.`);
  return lines.map((line) => `<li>${line}</li>`).join("");
}

// The identified interval on the track of a slider, if there is one.
function markOf(variable, slider) {
  if (!variable.interval) return null;
  const [low, high] = variable.interval.map((end) => stopAt(slider, end) / STOPS);
  const mark = element("div", { class: "interval", title: `95 % interval ${variable.interval.map((end) => told(end, variable.unit, 4)).join(" to ")}` });
  mark.style.setProperty("--from", low);
  mark.style.setProperty("--to", high);
  return mark;
}

// A variable with a choice of names.
function choice(variable, { input, change }) {
  const id = `number-${controls++}`;
  const select = element("select", { id, name: variable.name, disabled: variable.fixed },
    ...variable.choices.map((name, i) => element("option", { value: i, text: name })));
  select.addEventListener("change", () => { input(Number(select.value), "field"); change(); });
  const root = element("div", { class: "card choice" },
    element("label", { for: id }, element("span", { class: "symbol", html: variable.symbol }), element("span", { class: "meaning", text: variable.description })),
    element("div", { class: "number" }, select));
  return { root, show(value) { select.value = value; } };
}

// Variables of the views, in the form in which Python describes those of models.
function setting(name, symbol, unit, description, value, low, high, logarithmic = true) {
  return { name, key: name, symbol, unit, description, values: [value], min: low, max: high, choices: [], array: false,
    whole: false, fixed: false, interval: null, sliders: [{ low, high, logarithmic, to_zero: false, endless: false }] };
}

// The loop: stiff compared with the contact if the mass is unknown.
function loopSettings(model, loop) {
  const { reach, speed, force } = model.scales, { paper } = loop, gain = 150, { units } = model;
  const mass = model.mass ?? round(2 * force / (reach * gain * gain)), amplitude = round(2.8 * reach);
  const bodies = ["this model, initial values", "the rig of the paper"];
  return [
    { ...setting("loop_body", "", "", "friction of the mass", 0, 0, 1), choices: model.kind === loop.rig.kind ? bodies : bodies.slice(0, 1) },
    setting("loop_M", "<i>M</i>", model.pull[0].unit, "mass driven by the control law", mass, mass / 100, 100 * mass),
    setting("loop_gain", "<i>λ</i>", "1/s", "gain λ of the control law; also its gain K₁", gain, 10, 400),
    setting("loop_K_2", "<i>K</i><sub>2</sub>", `${units.velocity}²`, "switching gain of the control law", 0, 0, 10 * paper.K_2, false),
    setting("loop_g", "<i>g</i>", "1/s", "bandwidth of the observer", paper.g, 1, 400),
    setting("loop_A", "<i>A</i>", units.position, "amplitude of the motion", amplitude, reach / 20, 200 * reach),
    setting("loop_f", "<i>f</i>", "Hz", "frequency of the motion", paper.frequency, 0.05, 20),
    setting("loop_resolution", "<i>δ</i>", units.position, "step of the encoder", round(reach / 20), reach / 1000, reach),
  ];
}

function settingsOf(model, loop = null) {
  const { reach, speed } = model.scales, amplitude = PRESETS.triangle.amplitude * reach;
  const [m, k, v] = ["M", "k", "v_e"].map((name) => model.pull.find((variable) => variable.name === name));
  const natural = 2 * Math.PI * Math.sqrt(m.values[0] / k.values[0]);
  return [
    setting("amplitude", "<i>A</i>", model.units.position, "amplitude of the path", round(amplitude), reach / 20, 200 * reach),
    setting("period", "<i>T</i>", "s", "period of one oscillation with this amplitude", 10, 1e-3, 1e4),
    ...(loop ? loopSettings(model, loop) : []),
    ...(model.around ?? []),
    setting("top", "<i>v</i><sub>max</sub>", model.units.velocity, "largest velocity of the sweep", round(model.fastest || 10 * speed), speed / 10, 1e4 * speed),
    ...[m, k, v].map((variable) => ({ ...variable, values: numbersOf(variable.values) })),
    setting("time", "<i>t</i><sub>end</sub>", "s", "duration of the pull", round(150 * natural), 5 * natural, 2000 * natural),
  ];
}

function round(value) { return Number(value.toPrecision(3)); }
