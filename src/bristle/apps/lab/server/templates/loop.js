// Step 6: the controller of the axis, the gain of friction feedforward, and the values for the drive.

// Field of the axis file -> question and example; U is the unit of the effort in the log, L the unit of a length.
const CASCADE = { "controller.k_p": ["What is the position gain (Kv)?", "60 1/s"], "controller.k_v": ["What is the velocity gain?", "110 U*s/L"],
  "controller.T_n": ["What is the integral time of the velocity loop?", "30 ms"], "controller.k_i": ["Or what is its integral gain?", "4000 U/L"],
  "controller.k_ff": ["What share of the velocity was fed forward?", "0 to 1, usually 0"], "controller.limit": ["What is the limit of its output?", "12 U"],
  "controller.averaging": ["Over how many samples is the velocity averaged?", "1 or 2"] };
const DRIVE = { "effort.limit": ["What is the limit of the drive?", "12 U"], "effort.lag": ["What is the time constant of the current loop?", "0.3 ms"],
  "plant.presliding": ["Over what distance does friction reverse?", "only for models without it"] };

function valueAt(tables, key) { return key.split(".").reduce((table, name) => table?.[name], tables); }

function loopForm({ tables, kind, sample_time: step }, compensate) {
  const unit = valueAt(tables, "columns.effort.unit") || unitsOf(kind).force, place = element("div", { class: "fields" });
  const inputs = () => [...place.querySelectorAll("input")];
  const law = element("select", { name: "controller.model" }, element("option", { value: "", text: "– select –" }), ...settings.controllers.map(({ name, description }) =>
    element("option", { value: name, text: name.replaceAll("_", " "), title: description, selected: valueAt(tables, "controller.model") === name })));
  const fill = () => {
    const fields = settings.controllers.find(({ name }) => name === law.value)?.fields ?? [];
    const asked_ = law.value === "cascade" ? CASCADE : Object.fromEntries(fields.map(([key, word, units]) => [key, [`${word}?`, units]]));
    place.replaceChildren(labelled("Which controller closes the position loop?", law), ...Object.entries({ ...asked_, ...DRIVE }).map(([key, [question, example]]) =>
      labelled(question, element("input", { type: "text", name: key, value: String(valueAt(tables, key) ?? ""), placeholder: example.replace("U", unit).replace("L", kind === "rotational" ? "rad" : "m") }))));
  };
  law.addEventListener("change", fill);
  fill();
  const edits = () => { // values that differ from the axis file, and nothing for parameters of another controller
    const now = { "controller.model": law.value || null, ...Object.fromEntries(inputs().map(({ name, value }) => [name, valueIn(value)])) };
    const before = Object.fromEntries(Object.keys(tables.controller ?? {}).map((name) => [`controller.${name}`, null]));
    return Object.fromEntries(Object.entries({ ...before, ...now }).filter(([key, value]) => value !== (valueAt(tables, key) ?? null)));
  };
  return [
    element("p", { class: "note", text: `Write each value with its unit, as in the drive. Gear, screw, encoder and delay belong to step 2; a gain per rad needs the lead of the screw. The loop runs at the sample time of the log, ${withDigits(1e3 * step, 4)} ms.` }),
    place,
    element("p", {}, button("Compensate", () => compensate(edits()), { id: "compensate-now", class: "main" })),
    element("p", { id: "compensate-failed", class: "alert", role: "alert", hidden: true }),
  ];
}

function loopView(loop, command, compensate) {
  const { gain, values, drive } = loop;
  const form = Object.assign(folded("Controller and drive", ...loopForm(loop, compensate)), { open: !gain, id: "loop-form" });
  return [
    element("p", { class: `ruling ${gain ? gain.helps ? "usable" : "no" : ""}`, id: gain ? "gain" : "no-gain",
      text: gain ? gain.headline : "How much does friction feedforward gain?" }),
    gain ? element("p", { class: "note", text: `Following error, simulated on ${loop.log}; as logged: ${gain.measured}. ${gain.caveat} The report of step 5 shows its picture.` })
      : element("p", {}, ...withCode(`Unknown so far: ${loop.reason}.`)),
    form,
    values ? copied(values) : null,
    drive ? folded("Friction over velocity, as a table", copied(drive)) : null,
    element("p", { class: "note" }, "In a terminal, with the axis file of step 2: ", element("code", { text: command })),
  ];
}
