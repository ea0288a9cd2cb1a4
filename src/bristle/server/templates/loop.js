// Step 6: the controller of the axis, the gain of friction feedforward, and the values for the drive.

// Field of the axis file -> question and example; U is the unit of the effort in the log, L that of a length in SI.
const QUESTIONS = {
  "controller.k_p": ["What is the position gain (Kv)?", "60 1/s"],
  "controller.k_v": ["What is the gain of the velocity loop?", "110 U*s/L"],
  "controller.T_n": ["What is the integral time of the velocity loop?", "30 ms"],
  "controller.k_i": ["Or what is its integral gain?", "4000 U/L"],
  "controller.k_ff": ["In the log, what share of the velocity is fed forward?", "0 to 1, usually 0"],
  "controller.limit": ["What limits the output of the controller?", "12 U"],
  "controller.averaging": ["Over how many samples does it average the velocity?", "1 or 2"],
};
const DRIVE = {
  "effort.limit": ["What limits the drive?", "12 U"],
  "effort.lag": ["What is the time constant of the current loop?", "0.3 ms"],
  "plant.presliding": ["Over what distance does friction reverse?", "7 um, if the model lacks it"],
};

function valueAt(tables, key) { return key.split(".").reduce((table, name) => table?.[name], tables); }

function loopForm({ tables, kind, sample_time: step }, compensate) {
  const unit = valueAt(tables, "columns.effort.unit") || unitsOf(kind).force, place = element("div", { class: "fields" }), inputs = new Map();
  const law = element("select", { name: "controller.model" }, element("option", { value: "", text: "– select –" }),
    ...settings.controllers.map(({ name, description }) => element("option", { value: name, text: name.replaceAll("_", " "), title: description, selected: valueAt(tables, "controller.model") === name })));
  const field = (key, word, example) => {
    const now = inputs.get(key)?.value ?? valueAt(tables, key) ?? "", shown_ = example.replace("U", unit).replace("L", kind === "rotational" ? "rad" : "m");
    const input = element("input", { type: "text", name: key, value: String(now === "?" ? "" : now), placeholder: shown_ });
    inputs.set(key, input);
    return element("label", {}, element("span", { text: word }), input);
  };
  const fill = () => {
    const fields = (settings.controllers.find(({ name }) => name === law.value)?.fields ?? []).map(({ key, word, units }) =>
      law.value === "cascade" && QUESTIONS[key] ? [key, ...QUESTIONS[key]] : [key, `${word}?`, units[kind] || "number"]);
    if (law.value === "cascade") fields.splice(2, 0, ["controller.T_n", ...QUESTIONS["controller.T_n"]]);
    place.replaceChildren(...[...fields, ...Object.entries(DRIVE).map(([key, [word, example]]) => [key, word, example])].map((each) => field(...each)));
  };
  law.addEventListener("change", fill);
  fill();
  const edits = () => {
    const now = new Map([["controller.model", law.value || null], ...[...inputs].filter(([, { isConnected }]) => isConnected).map(([key, { value }]) => [key, valueIn(value)])]);
    const before = Object.keys(tables.controller ?? {}).map((name) => `controller.${name}`).filter((key) => !now.has(key));
    return { ...Object.fromEntries([...now].filter(([key, value]) => value !== (valueAt(tables, key) ?? null))), ...Object.fromEntries(before.map((key) => [key, null])) };
  };
  return [
    element("p", { class: "note", text: `bristle simulates the loop at the sample time of the log, ${withDigits(1e3 * step, 4)} ms. Write each value with its unit, as in the drive. Gear, screw, encoder and delay belong to step 2.` }),
    element("div", { class: "fields" }, element("label", {}, element("span", { text: "Which controller closes the position loop?" }), law)), place,
    element("p", {}, button("Compensate", () => compensate(edits()), { id: "compensate-now", class: "main" })),
  ];
}

function followingPicture({ error: [time, without, compensated, measured], measured: size }, kind) {
  return pictureOf("Following error around the worst reversal", (canvas, theme) => {
    const frame = frameOn(canvas, theme, { word: "time", unit: "s", values: time }, { word: "following error", unit: unitsOf(kind).position, values: [...without, ...compensated] });
    frame.curve(time, measured, { colour: theme.measured, width: 4 });
    frame.curve(time, without, { colour: colourOf("without"), width: 2.2, dash: [6, 3] });
    frame.curve(time, compensated, { colour: colourOf("with"), width: 2.6 });
  }, legendOf("Following error around the worst reversal:", ["measured", `in the log (${size} with its lag)`], ["without", "velocity and mass fed forward"], ["with", "friction fed forward, too"]));
}

function loopView(loop, command, compensate) {
  const { gain, values, drive } = loop;
  const form = element("details", { open: !gain, id: "loop-form" }, element("summary", { text: "Controller and drive" }), ...loopForm(loop, compensate));
  const head = gain
    ? [element("p", { class: `ruling ${gain.helps ? "usable" : "no"}`, id: "gain", text: gain.helps ? `Friction feedforward: ${gain.without} → ${gain.with}, ×${gain.times}` : `Friction feedforward does not help: ${gain.without} → ${gain.with}` }),
      element("p", { class: "note", text: `Following error, peak to peak, simulated on ${loop.log}; the log itself has ${gain.measured}. ${gain.caveat}` })]
    : [element("p", { class: "ruling", id: "no-gain", text: "How much does friction feedforward gain?" }), element("p", {}, ...withCode(`Unknown so far: ${loop.reason}.`))];
  const table = values ? copied(values) : null;
  return [...head, gain ? null : form, element("div", { class: "plots" }, gain ? followingPicture(gain, loop.kind) : null, table), gain ? form : null,
    drive ? folded("Friction over velocity, as a table", copied(drive)) : null,
    element("p", { class: "note" }, "In a terminal, with the axis file of step 2: ", element("code", { text: command }))];
}
