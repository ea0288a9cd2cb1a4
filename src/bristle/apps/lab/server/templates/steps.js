// Steps 3 to 6: the results, as text, tables and pictures.

function checkView(checked) {
  return checked.logs.flatMap((log) => [
    element("h3", { text: `${log.label}${log.role === "held_out" ? " (held out)" : ""}` }),
    log.rate ? element("p", { class: "note", text: `${withDigits(log.rate, 6)} samples a second, ${withDigits(log.duration, 5)} s, ${log.kind}` }) : null,
    listOf(log.problems, "told problems"),
    log.left_out ? element("p", { class: "note", text: log.left_out }) : null,
    log.problems.length || log.left_out ? null : element("p", { text: log.diagnostics.length ? "Usable. Findings in this log: " : "Usable, without findings." }),
    listOf(log.diagnostics?.map(({ severity, message }) => `${severity}: ${message}`)),
    log.passages ? folded("Experiments in the log", tableOf(log.passages)) : null,
    log.notes?.length ? folded("Notes", listOf(log.notes)) : null,
  ]).filter(Boolean);
}

// The verdict, and the report with its pictures and tables.
function verdictView(found, state, download) {
  return [
    state.parts.identified.old ? element("p", { class: "old", text: "The logs or the axis file have changed since this identification. Check the logs and identify again." }) : null,
    element("p", { class: `ruling ${found.verdict.level}`, id: "ruling", text: found.verdict.words }),
    found.unfinished ? element("p", { class: "alert", text: `Unfinished: ${found.unfinished}` }) : null,
    element("p", {}, element("strong", { text: found.model }), ...withCode(`: ${found.misfit.join("; ")}.`)),
    listOf(found.verdict.reasons),
    folded("Parameters", copied(found.parameters)),
    element("div", { id: "predicted" }),
    element("div", { class: "tools" }, button("Download results.zip", download, { id: "results" })),
    element("p", { class: "note" }, "The same command in a terminal: ", element("code", { text: found.command })),
    element("div", { id: "report" }),
  ];
}

function predictedView(predicted) {
  const units = unitsOf(predicted.kind);
  return [element("h3", { text: "Held-out logs" }), ...predicted.logs.flatMap((log) => log.left_out ? [element("p", { class: "note", text: log.left_out })] : [
    element("p", { text: `${log.label}: ${log.verdict.words}; model error ${withDigits(log.error_percent, 3)} % of the effort${log.inside_percent === null ? "" : `, ${withDigits(log.inside_percent, 3)} % of the samples are within the 95 % band`}.` }),
    effortPicture(log.time, units.force, `Effort of ${log.label}`),
  ])];
}

function exportedView(exported, { target, file }, download) {
  return [
    element("h3", { text: `Written for ${target}: ${exported.files.join(", ")}` }),
    listOf(exported.notes),
    exported.shown ? folded(exported.shown.file, element("pre", { tabindex: "0", text: exported.shown.text })) : null,
    element("p", {}, button(`Download ${file}`, download, { id: "download-export", class: "main" })),
  ].filter(Boolean);
}

function chosenOf(name) { return [...document.querySelectorAll(`input[name="${name}"]:checked`)].map(({ value }) => value); }

function choicesOf(choices, name, type) {
  return choices.map((choice) => element("label", { title: choice.description ?? false },
    element("input", { type, name, value: choice.name, checked: choice.first }), ` ${choice.title ?? choice.name}`));
}
