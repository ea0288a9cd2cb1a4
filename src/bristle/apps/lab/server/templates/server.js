// The page follows the server: it polls the state of an analysis and shows it. A second tab, or a reload, shows the same state.

const BUSY = 300, IDLE = 2500; // [ms] between two polls
const WORDS = { look: "Reading", check: "Checking", identify: "Identifying", predict: "Predicting", compensate: "Compensating", export: "Exporting", excite: "Designing", plan: "Planning", tune: "Tuning", undo: "Undoing" };
const STEPS = ["Log", "Columns", "Check", "Identify", "Verdict", "Compensate"];
const WAITS = ["", "waits for a log", "waits for columns and units", "waits for usable logs", "waits for a model", "waits for a model"];
const shown = {}, contents = {};
let state = null, timer = null, toldJob = null;

const pathTo = (end = "") => `/api/cases/${state.id}${end}`;

// Show other contents. A field that remains keeps the focus and the text that is typed there.
function replace(id, children) {
  const { name, value } = document.activeElement, holder = byId(id), had = name && holder.contains(document.activeElement);
  holder.replaceChildren(...children.filter(Boolean));
  const again = had ? holder.querySelector(`input[type="text"][name="${name}"]`) : null;
  if (again) Object.assign(again, { value }).focus({ preventScroll: true });
}

function take(next) {
  state = next;
  clearTimeout(timer);
  timer = setTimeout(follow, state.job?.state === "runs" ? BUSY : IDLE);
  return show();
}

async function follow() {
  try {
    await take(await json("GET", pathTo()));
  } catch (error) {
    fail(error.message);
    clearTimeout(timer);
    if (error.status === 404) return;
    timer = setTimeout(follow, IDLE);
  }
}

async function start(task, options = {}) { await take(await json("POST", pathTo("/jobs"), { task, options })); }

async function begin() {
  const fresh = await json("POST", "/api/cases");
  for (const name of Object.keys(shown)) delete shown[name];
  await take(fresh);
  showView(byId("tune").hidden ? "identify" : "tune");
}

// --- what is shown -------------------------------------------------------------------------------------------------

function unlocked() {
  const { looked, checked, identified } = state.parts, fits = state.files.some(({ role }) => role === "fit");
  const fine = checked?.ready && !checked.old;
  return [true, fits && Boolean(looked), fits && looked?.ready && !looked.old && Boolean(checked), fits && fine, Boolean(identified), Boolean(identified) && !identified.old];
}

function showSteps() {
  const open = unlocked(), current = open.lastIndexOf(true);
  open.forEach((is, i) => {
    const section = byId(`step-${i + 1}`);
    section.classList.toggle("locked", !is);
    section.querySelector("h2").dataset.waits = WAITS[i];
  });
  replace("steps", STEPS.map((word, i) => {
    const link = element("a", { href: `#step-${i + 1}`, text: `${i + 1} ${word}` });
    link.addEventListener("click", (event) => { event.preventDefault(); byId(`step-${i + 1}`).scrollIntoView(); });
    return element("li", { class: i === current ? "now" : open[i] ? "done" : "", "aria-current": i === current ? "step" : false }, link);
  }));
}

function showLogs() {
  replace("logs", state.files.map((file) => {
    const other = file.role === "fit" ? "held_out" : "fit";
    return element("li", {}, element("span", { class: "label", text: file.label }), element("span", { class: "note", text: `${sizeText(file.size)}, ${file.role === "fit" ? "to fit" : "held out"}` }),
      button(other === "fit" ? "Use for the fit" : "Hold out", () => doing(async () => { await take(await json("POST", pathTo(`/files/${file.number}/role`), { role: other })); await look(); })),
      button("Remove", () => doing(async () => { await take(await json("DELETE", pathTo(`/files/${file.number}`))); await look(); }), { "aria-label": `Remove ${file.label}` }));
  }));
}

function showJob() {
  const { job } = state, runs = job?.state === "runs", busy = Boolean(runs);
  byId("job").hidden = !runs;
  if (runs) {
    byId("job-task").textContent = WORDS[job.task];
    byId("job-text").textContent = `${job.cancelled ? job.task === "tune" ? "restoring the machine" : "ending with the best result" : job.text}, ${job.seconds.toFixed(0)} s`;
    byId("job-share").value = job.share;
    byId("cancel").hidden = job.task !== "identify" || job.cancelled;
    byId("stop").hidden = ["plan", "undo"].includes(job.task) || (job.task === "tune" && job.cancelled);
    byId("stop").textContent = job.task === "tune" ? "Stop, and restore the machine" : "Stop now, without a result";
  }
  for (const id of ["identify", "compensate-now", "export", "design", "check-now"]) {
    const control_ = byId(id);
    if (control_) control_.disabled = busy || (id === "check-now" && !(state.parts.looked?.ready && !state.parts.looked.old));
  }
  const told_ = job && !runs ? `${job.task} ${job.seconds} ${job.state}` : null;
  const message = job?.state === "cancelled" ? `Cancelled.${job.task === "identify" ? " No model was fitted yet." : ""}` : byId(`${job?.task}-failed`) ? job.message : `${WORDS[job?.task]}: ${job?.message}`;
  if (told_ && told_ !== toldJob && ["failed", "cancelled"].includes(job.state)) fail(message, job.task);
  toldJob = told_;
  byId("said").textContent = job?.state === "done" ? `${WORDS[job.task]} took ${job.seconds.toFixed(1)} s.` : "";
}

const VIEWS = {
  looked: (data) => replace("columns", columnsView(data, state, { edit: (edits) => doing(() => start("look", { edits })), use: (text) => doing(() => start("look", { text })),
    check: () => doing(() => start("check")) })),
  checked: (data) => replace("check", checkView(data)),
  identified: showResults,
  compensated: showResults,
  predicted: (data) => { if (byId("predicted")) replace("predicted", predictedView(data)); },
  exported: (data) => replace("exported", exportedView(data, state.parts.exported, () => doing(() => saved(pathTo("/parts/exported/archive"), "export.zip")))),
  excited: (data) => {
    byId("excite-more").open = true;
    replace("excited", excitedView(data, () => doing(() => saved(pathTo("/parts/excited/archive"), "motion.zip"))));
    doing(() => report("excited", "excited-report"));
  },
  planned: (data) => replace("planned", planView(data)),
};
// Steps 5 and 6 after an identification, and again after another controller.
function showResults() {
  const { compensated } = state.parts, found = (compensated && !compensated.old && contents.compensated?.data) || contents.identified.data;
  replace("verdict", verdictView(found, state, () => doing(() => saved(pathTo("/parts/identified/archive"), "results.zip"))));
  replace("compensate", loopView(found.loop, found.command, (edits) => doing(() => start("compensate", { edits }))));
  shown.predicted = undefined;
  doing(() => report("identified", "report"));
}

const HOLDERS = { looked: ["columns"], checked: ["check"], identified: ["verdict", "compensate"], compensated: [], predicted: ["predicted"], exported: ["exported"], excited: ["excited"], planned: ["planned"] };
const RESULTS = { identified: "step-5", compensated: "step-6", exported: "exported" }; // where the page goes when they are ready

async function show() {
  let ready = "";
  showLogs();
  for (const name of Object.keys(VIEWS)) {
    const part = state.parts[name], key = part ? `${state.id} ${part.revision} ${part.old} ${name === "looked" ? state.axis.text : ""}` : "";
    if (shown[name] === key) continue;
    if (part && contents[name]?.revision !== `${state.id} ${part.revision}`) {
      contents[name] = { revision: `${state.id} ${part.revision}`, data: await json("GET", pathTo(`/parts/${name}`)) };
    }
    const fresh = shown[name] !== undefined && part && !part.old && shown[name] !== key;
    shown[name] = key;
    if (!part) for (const id of HOLDERS[name]) byId(id)?.replaceChildren();
    else VIEWS[name](contents[name].data);
    if (fresh && RESULTS[name]) ready = RESULTS[name];
  }
  showSteps(); // last: what a step unlocks stays where it appears
  if (ready) byId(ready).scrollIntoView();
  showJob();
  await showRun();
}

async function report(part, place) {
  const { address } = await json("POST", pathTo(`/parts/${part}/ticket`));
  replace(place, [element("iframe", { src: address, title: "Report" })]);
}

// --- what a person does ----------------------------------------------------------------------------------------------

async function look() { if (state.files.some(({ role }) => role === "fit") && (!state.parts.looked || state.parts.looked.old)) await start("look"); }

async function receive(files) {
  const [role] = chosenOf("role");
  for (const file of files) {
    if (file.size > settings.file_size) throw new Refusal(`${file.name} has ${sizeText(file.size)}; the limit is ${sizeText(settings.file_size)}. Start bristle lab --serve again with a larger BRISTLE_SIZE_LIMIT in the environment`);
    byId("said").textContent = `receiving ${file.name}`;
    const headers = { "X-Bristle-Name": encodeURIComponent(file.name), "X-Bristle-Role": /\.toml$/i.test(file.name) ? "axis" : role, "Content-Type": "application/octet-stream" };
    state = await (await asked("PUT", pathTo("/files"), { body: file, headers })).json();
  }
  await take(state);
  await look();
}

function chosenModels() {
  const names = chosenOf("model");
  if (!names.length) throw new Refusal("Select at least one model");
  return [...new Set(names.flatMap((name) => byId("asymmetry").checked && !name.endsWith("+asymmetry") ? [name, `${name}+asymmetry`] : [name]))].join(",");
}

function countIn(id) {
  const value = valueIn(byId(id).value);
  if (!Number.isInteger(value)) throw new Refusal(`${byId(id).value || "An empty field"} is not a whole number`);
  return value;
}

function listen() {
  const drop = byId("drop"), files = byId("files");
  files.addEventListener("change", () => doing(async () => { await receive([...files.files]); files.value = ""; }));
  for (const name of ["dragover", "dragenter"]) drop.addEventListener(name, (event) => { event.preventDefault(); drop.classList.add("over"); });
  drop.addEventListener("dragleave", () => drop.classList.remove("over"));
  drop.addEventListener("drop", (event) => { event.preventDefault(); drop.classList.remove("over"); doing(() => receive([...event.dataTransfer.files])); });
  byId("identify").addEventListener("click", () => doing(() => start("identify", { models: chosenModels(), draws: countIn("draws"), cutoff: byId("cutoff").value })));
  byId("export").addEventListener("click", () => doing(() => start("export", { target: chosenOf("target")[0], name: byId("export-name").value, points: countIn("points") })));
  byId("cancel").addEventListener("click", () => doing(async () => take(await json("POST", pathTo("/cancel"), {}))));
  byId("stop").addEventListener("click", () => doing(async () => take(await json("POST", pathTo("/cancel"), { at_once: true }))));
  byId("new").addEventListener("click", () => doing(begin));
  byId("close").addEventListener("click", () => doing(async () => { if (confirm("Remove logs and results of this analysis?")) { await json("DELETE", pathTo()); await begin(); } }));
  byId("to-excite").addEventListener("click", (event) => { event.preventDefault(); byId("excite-more").open = true; byId("excite").scrollIntoView(); });
  document.querySelector(".skip").addEventListener("click", (event) => { event.preventDefault(); byId(byId("tune").hidden ? "files" : "machine-file").focus(); });
}

doing(async () => {
  byId("models").append(...choicesOf(settings.models, "model", "checkbox"));
  byId("targets").append(...choicesOf(settings.targets, "target", "radio"));
  replace("excitation", excitationForm((options) => doing(() => start("excite", options))));
  listen();
  listenForRuns();
  if (!token) throw new Refusal("The address lacks its token. Open the address printed by bristle");
  try {
    if (!opened) await begin();
    else await take(await json("GET", `/api/cases/${opened}`));
    for (const [id, name] of [["machine-file", "file"], ["run-folder", "folder"]]) byId(id).value = state.machine?.[name] ?? byId(id).value;
    if (view === "tune") {
      showView(view);
      await showRun();
    }
  } catch (error) {
    if (error.status !== 404) throw error;
    await begin();
  }
});
