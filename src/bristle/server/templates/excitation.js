// The motion to record, designed from the limits of an axis.

const LIMITS = [["limits.velocity", "Largest velocity", "0.5 m/s"], ["limits.acceleration", "Largest acceleration", "5 m/s^2"],
  ["effort.limit", "Largest effort", "300 N"], ["plant.mass", "Moving mass, if known", "20 kg"], ["plant.inertia", "Or inertia, if known", "0.02 kg*m^2"],
  ["plant.presliding", "Pre-sliding distance", "20 um"], ["encoder.resolution", "Step of the encoder", "0.1 um"], ["timing.sample_time", "Sample time", "1 ms"]];
const PURPOSES = [["presliding", "pre-sliding"], ["break-away", "break-away"], ["damping", "damping"], ["stribeck", "friction over velocity"]];

function excitationForm(design) {
  const inputs = LIMITS.map(([key, word, example]) => [key, word, element("input", { type: "text", name: `excite.${key}`, placeholder: example })]);
  const duration = element("input", { type: "text", value: "60 s", name: "excite.duration" });
  const travel = element("input", { type: "text", name: "excite.travel", placeholder: "200 mm" });
  const purposes = PURPOSES.map(([name, word]) => [name, word, element("input", { type: "checkbox", value: name, checked: true })]);
  const kinds = ["translational", "rotational"].map((kind) => element("input", { type: "radio", name: "excite-kind", value: kind, checked: kind === "translational" }));
  const go = button("Design the motion", () => {
    const edits = Object.fromEntries(inputs.map(([key, , input]) => [key, valueIn(input.value)]).filter(([, value]) => value !== null));
    edits.kind = kinds.find(({ checked }) => checked).value;
    const chosen = purposes.filter(([, , input]) => input.checked).map(([name]) => name);
    design({ edits, duration: duration.value, travel: travel.value, purposes: chosen.length === PURPOSES.length ? "" : chosen.join(",") });
  }, { class: "main", id: "design" });
  return [
    element("p", { class: "note", text: "Write the limits of the axis, with units. For an empty field, bristle uses the value from the axis file of step 1." }),
    element("div", { class: "choices", role: "radiogroup", "aria-label": "Kind of axis" }, ...kinds.map((input) => element("label", {}, input, ` ${input.value}`))),
    element("div", { class: "fields" }, ...inputs.map(([, word, input]) => labelled(word, input)), labelled("Travel, if the stroke is unknown", travel), labelled("Duration", duration)),
    element("div", { class: "choices", role: "group", "aria-label": "Purpose of the motion" }, ...purposes.map(([, word, input]) => element("label", {}, input, ` ${word}`))),
    element("p", {}, go),
    element("div", { id: "excited" }),
  ];
}

function excitedView(excited, { download, report }) {
  const units = unitsOf(excited.kind), [time, position] = excited.curve;
  return [
    pictureOf("Position of the motion over time", (canvas, theme) => {
      frameOn(canvas, theme, { word: "time", unit: "s", values: time }, { word: "position", unit: units.position, values: position })
        .curve(time, position, { colour: theme.accent, width: 1.4 });
    }),
    tableOf(excited.pieces),
    excited.outlook ? tableOf(excited.outlook) : null,
    listOf(excited.notes),
    element("div", { class: "tools" }, button("Download motion.zip", download), button("Show the report", report)),
    element("p", { class: "note", text: "motion.csv contains the samples of the motion. moves.csv and motion.nc contain its moves." }),
  ];
}
