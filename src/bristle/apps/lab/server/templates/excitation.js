// The motion to record, designed from the limits of an axis.

const LIMITS = [["limits.velocity", "Largest velocity", "0.5 m/s"], ["limits.acceleration", "Largest acceleration", "5 m/s^2"],
  ["effort.limit", "Largest effort", "300 N"], ["plant.mass", "Moving mass, if known", "20 kg"], ["plant.inertia", "Or inertia, if known", "0.02 kg*m^2"],
  ["plant.presliding", "Pre-sliding distance", "20 um"], ["encoder.resolution", "Step of the encoder", "0.1 um"], ["timing.sample_time", "Sample time", "1 ms"]];
const PURPOSES = [["presliding", "pre-sliding"], ["break-away", "break-away"], ["damping", "damping"], ["stribeck", "friction over velocity"]];

function excitationForm(design) {
  const field = (name, attributes) => element("input", { type: "text", name: `excite.${name}`, ...attributes }), valueOf = (name) => document.getElementsByName(`excite.${name}`)[0].value;
  const kinds = ["translational", "rotational"].map((name, i) => ({ name, first: i === 0 })), purposes = PURPOSES.map(([name, title]) => ({ name, title, first: true }));
  const go = button("Design the motion", () => {
    const edits = Object.fromEntries(LIMITS.map(([key]) => [key, valueIn(valueOf(key))]).filter(([, value]) => value !== null)), chosen = chosenOf("purpose");
    design({ edits: { ...edits, kind: chosenOf("excite-kind")[0] }, duration: valueOf("duration"), travel: valueOf("travel"), purposes: chosen.length === PURPOSES.length ? "" : chosen.join(",") });
  }, { class: "main", id: "design" });
  return [
    element("p", { class: "note", text: "Write the limits of the axis, with units. For an empty field, bristle uses the value from the axis file of step 1." }),
    element("div", { class: "choices", role: "radiogroup", "aria-label": "Kind of axis" }, ...choicesOf(kinds, "excite-kind", "radio")),
    element("div", { class: "fields" }, ...LIMITS.map(([key, word, placeholder]) => labelled(word, field(key, { placeholder }))),
      labelled("Travel, if the stroke is unknown", field("travel", { placeholder: "200 mm" })), labelled("Duration", field("duration", { value: "60 s" }))),
    element("div", { class: "choices", role: "group", "aria-label": "Purpose of the motion" }, ...choicesOf(purposes, "purpose", "checkbox")),
    element("p", {}, go),
    element("div", { id: "excited" }),
  ];
}

function excitedView({ notes }, download) {
  return [
    listOf(notes),
    element("div", { class: "tools" }, button("Download motion.zip", download)),
    element("p", { class: "note", text: "motion.csv contains the samples of the motion. moves.csv and motion.nc contain its moves." }),
    element("div", { id: "excited-report" }),
  ];
}
