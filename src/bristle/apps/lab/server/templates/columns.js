// Step 2: the proposed meaning of the columns; each change is written to the axis file.

const USUAL = { time: ["s", "ms", "us"], effort: ["N", "N*m", "A", "V", "%", "‰"],
  length: ["m", "mm", "um", "rad", "deg", "rev", "count"], velocity: ["m/s", "mm/s", "mm/min", "rad/s", "deg/s", "rpm"] };

function usualUnits(channel) { return USUAL[channel] ?? USUAL.length; }

// Value of a field for the axis file: a number if possible.
function valueIn(text) {
  const trimmed = text.trim();
  return trimmed === "" ? null : /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(trimmed) ? Number(trimmed) : trimmed;
}

function channelRow(channel, looked, edit) {
  const entry = looked.form.tables.columns?.[channel] ?? {}, key = `columns.${channel}`, remark = looked.form.remarks[key];
  const names = [...new Set([entry.column, ...looked.columns.map(({ name }) => name)])].filter(Boolean);
  const select = element("select", { "aria-label": `Column of the ${channel}`, name: `${key}.column` },
    element("option", { value: "", text: "– none –" }),
    ...names.map((name) => element("option", { value: name, text: name, selected: name === entry.column })));
  select.addEventListener("change", () => edit(select.value
    ? { [`${key}.column`]: select.value, [`${key}.unit`]: looked.columns.find(({ name }) => name === select.value)?.unit || entry.unit || "?" }
    : Object.fromEntries(Object.keys(entry).map((name) => [`${key}.${name}`, null]))));
  const open = looked.form.missing.includes(`${key}.unit`);
  const unit = element("input", { type: "text", list: `units-${channel}`, value: open ? "" : entry.unit ?? "", placeholder: open ? "unit?" : "",
    "aria-label": `Unit of the ${channel}`, name: `${key}.unit`, disabled: !entry.column, "aria-invalid": open ? "true" : "false" });
  unit.addEventListener("change", () => edit({ [`${key}.unit`]: unit.value.trim() || null }));
  const negative = entry.sign === -1;
  const sign = channel === "time" ? null : element("button", { type: "button", text: negative ? "× −1" : "× +1", disabled: !entry.column, name: `${key}.sign`,
    "aria-pressed": String(negative), "aria-label": `Invert the sign of the ${channel}` });
  sign?.addEventListener("click", () => edit({ [`${key}.sign`]: negative ? null : -1 }));
  return element("div", { class: `channel${open ? " open" : ""}` }, element("span", { text: channel.replace("_", " ") }), select, unit, sign,
    element("datalist", { id: `units-${channel}` }, ...usualUnits(channel).map((value) => element("option", { value }))),
    remark ? element("p", { class: "note", text: remark }) : null);
}

// Optional fields that change the meaning of the log; a field that only the loop uses belongs to step 6.
const OPTIONAL = [["transmission.lead", "How far does the axis move per turn of the screw?", "10 mm"], ["transmission.gear_ratio", "How many turns of the motor per turn behind the gear?", "1"],
  ["encoder.resolution", "How large is one step of the encoder?", "0.1 um"], ["timing.delay", "By how much does the logged effort lag?", "estimated"],
  ["timing.sample_time", "What is the sample time, if the log has no time?", "1 ms"], ["effort.hold", "How does the effort act between samples? zero (constant) or linear", "unknown"]];

const isElsewhere = (key) => key.startsWith("controller.") || DRIVE[key] || OPTIONAL.some(([other]) => other === key);

// All other fields of the axis file, missing values first.
function furtherFields(looked, edit) {
  const fields = [];
  for (const [table, entries] of Object.entries(looked.form.tables)) {
    if (table === "columns" || typeof entries !== "object") continue;
    for (const [name, value] of Object.entries(entries)) {
      if (!["string", "number"].includes(typeof value)) continue;
      const key = `${table}.${name}`, open = looked.form.missing.includes(key) || looked.refusal.includes(`${key}:`);
      if (isElsewhere(key) && !open) continue;
      const input = element("input", { type: "text", name: key, value: value === "?" ? "" : String(value), placeholder: "?" });
      input.addEventListener("change", () => edit({ [key]: (table === "effort" ? input.value.trim() : valueIn(input.value)) || "?" }));
      const label = element("label", { class: open ? "open" : "" }, element("span", { text: `${table}: ${name.replaceAll("_", " ")}` }), input,
        looked.form.remarks[key] ? element("span", { class: "note", text: looked.form.remarks[key] }) : null);
      if (open) fields.unshift(label);
      else fields.push(label);
    }
  }
  return fields;
}

function optionalFields(looked, edit) {
  return OPTIONAL.filter(([key]) => key !== "effort.hold" || valueAt(looked.form.tables, "effort.held") === undefined).map(([key, word, placeholder]) =>
    labelled(word, element("input", { type: "text", name: key, value: String(valueAt(looked.form.tables, key) ?? ""), placeholder, onchange: ({ target }) => edit({ [key]: valueIn(target.value) }) })));
}

function kindChoice(looked, edit) {
  const now = looked.form.tables.kind ?? "", titles = { "": `from the units${now === "" && looked.kind ? ` (${looked.kind})` : ""}`, translational: "translational", rotational: "rotational" };
  return element("div", { class: "choices", role: "radiogroup", "aria-label": "Kind of axis", onchange: ({ target }) => edit({ kind: target.value || null }) },
    ...choicesOf(Object.entries(titles).map(([name, title]) => ({ name, title, first: name === now })), "kind", "radio"));
}

function axisFileEditor(text, label, use) {
  const area = element("textarea", { spellcheck: "false", "aria-label": "Axis file" });
  area.value = text;
  return folded("The axis file", area, element("div", { class: "tools" }, button("Use this file", () => use(area.value)),
    button(`Download ${label}`, () => download(new Blob([area.value], { type: "text/plain" }), label))));
}

function columnsView(looked, state, { edit, use, check }) {
  const part = state.parts.looked, ready = part.ready && !part.old;
  const go = button("Confirm and check the logs", check, { id: "check-now", class: "main", disabled: !ready });
  const missing = part.missing.length ? [`Fill in: ${part.missing.join(", ")}`] : [];
  return [
    element("p", { class: "note", text: `bristle recognized these columns, units and signs in ${looked.log}. Correct them if necessary.` }),
    ...looked.channels.map((channel) => channelRow(channel, looked, edit)),
    kindChoice(looked, edit),
    element("div", { class: "fields" }, ...furtherFields(looked, edit)),
    element("details", { id: "drive-fields", open: byId("drive-fields")?.open ?? false }, element("summary", { text: "Gear, screw, encoder, delay (optional)" }), element("div", { class: "fields" }, ...optionalFields(looked, edit))),
    listOf([...missing, ...(looked.refusal && !missing.length ? [looked.refusal] : []), ...looked.problems], "told problems"),
    element("div", { class: "plots" }, ...looked.plots.map(signalPicture)),
    folded("How the columns were recognized", listOf(looked.notes)),
    axisFileEditor(state.axis.text ?? "", state.axis.label, use),
    element("p", {}, go),
  ];
}
