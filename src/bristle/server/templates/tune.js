// Tune a machine: the plan, the run with its gates, live records, and the change of the following error.

const RUN_STATES = { waiting: ["○", "waiting"], running: ["▶", "running"], passed: ["✓", "passed"], refused: ["✕", "refused"] };
const OUTCOMES = { kept: ["usable", "Kept"], restored: ["no", "Restored"], undone: ["", "Undone"], running: ["", "Running"] };
const SIGNALS = { motion: ["position", [["measured", "measured"], ["with", "reference"]]], error: ["following error", []], effort: ["effort", []] };
let run = null, drawnRecord = "";

const machineJob = () => (["plan", "tune", "undo"].includes(state.job?.task) && state.job.state === "runs" ? state.job.task : "");

// Seconds until the planned end of a step; null without a plan or for a run of another process.
function secondsLeft(place) {
  const planned = contents.planned?.data.seconds;
  if (machineJob() !== "tune" || !planned) return null;
  const sum = (list) => list.reduce((total, seconds) => total + seconds, 0);
  return Math.max(0, sum(planned.slice(0, place + 1)) - state.job.share * sum(planned));
}

function stepOfRun({ title, state: at, text }, place) {
  const [sign, word] = RUN_STATES[at], left = at === "running" ? secondsLeft(place) : null;
  const age = `last entry ${withDigits(Math.round(run.age), 4)} s ago`;
  const fact = at !== "running" ? text : left === null ? age : `${left.toFixed(0)} s left`;
  return element("li", { class: at, "aria-current": at === "running" ? "step" : false },
    element("span", { class: "mark", "aria-hidden": "true", text: sign }), element("span", { text: title }),
    element("span", { class: "note", text: `${word}${fact ? `: ${fact}` : ""}` }));
}

function planView({ table }) {
  return [tableOf(table), element("p", { class: "note", text: "Nothing has moved, and nothing was written." })];
}

function outcomeView() {
  const [level, word] = OUTCOMES[run.outcome], { change } = run;
  return [
    element("p", { class: `ruling ${level}`, id: "outcome", text: change && run.outcome === "kept" ? `${word}: ${change.before} → ${change.after}` : word }),
    change && element("p", { class: "note", text: "rms following error before and after" }),
    ...run.sentences.filter((sentence) => !sentence.startsWith("Undo: ")).map((sentence) => element("p", { text: sentence })),
    run.undo && run.outcome !== "running" && element("p", { class: "note" }, "Undo in a terminal: ", element("code", { text: run.undo })),
  ];
}

function recordPicture([name, { unit, curves: [time, ...signals] }], record) {
  const [word, keys] = SIGNALS[name];
  return pictureOf(`${word}, record ${record.replaceAll("_", " ")}`, (canvas, theme) => {
    const frame = frameOn(canvas, theme, { word: "time", unit: "s", values: time }, { word, unit, values: signals.flat() });
    [...signals].reverse().forEach((values, i) => frame.curve(time, values, { colour: signals.length > 1 ? theme[keys[i][0]] : theme.with, width: signals.length > 1 && i === 0 ? 2.4 : 1.2 }));
  }, ...keys);
}

async function showRun() {
  const job = machineJob(), watched = state.machine && !byId("tune").hidden;
  if (watched) ({ run, record: run_record } = await json("GET", pathTo("/machine")));
  if (!state.machine) run = null;
  const runs = run?.outcome === "running";
  byId("move").disabled = Boolean(job) || !state.parts.planned || state.parts.planned.old || run?.outcome === "kept";
  byId("plan").disabled = Boolean(job);
  byId("move-view").hidden = !state.parts.planned || state.parts.planned.old;
  byId("run-view").hidden = !run;
  if (!run) return;
  replace("run-steps", run.steps.map(stepOfRun));
  replace("run-outcome", runs ? [] : outcomeView());
  byId("undo").hidden = !run.undo || Boolean(job);
  byId("run-report").hidden = !run.report;
  const key = run_record ? `${run_record.name} ${run_record.revision}` : "";
  if (!watched || key === drawnRecord) return;
  const curves = key ? await json("GET", pathTo(`/machine/records/${run_record.name}`)).catch(({ status }) => { if (status !== 409) throw new Refusal("bristle cannot read the record"); }) : {};
  if (!curves) return; // bristle is writing it
  drawnRecord = key;
  replace("run-plots", Object.entries(curves).map((entry) => recordPicture(entry, run_record.name)));
}
let run_record = null;

async function chooseMachine() {
  byId("run-shown").replaceChildren();
  drawnRecord = "";
  await take(await json("POST", pathTo("/machine"), { file: byId("machine-file").value, folder: byId("run-folder").value }));
}

function showView(name) {
  for (const [id, own] of [["flow", "identify"], ["steps", "identify"], ["tune", "tune"]]) byId(id).hidden = own !== name;
  for (const tab of document.querySelectorAll("#views button")) tab.setAttribute("aria-pressed", String(tab.value === name));
  history.replaceState(null, "", `#${[token, state?.id ?? opened, name === "tune" ? name : ""].filter(Boolean).join(".")}`);
}

function listenForRuns() {
  for (const tab of document.querySelectorAll("#views button")) tab.addEventListener("click", () => { showView(tab.value); doing(showRun); });
  byId("open-run").addEventListener("click", () => doing(chooseMachine));
  byId("plan").addEventListener("click", () => doing(async () => { await chooseMachine(); await start("plan"); }));
  byId("move").addEventListener("click", () => doing(() => start("tune")));
  byId("undo").addEventListener("click", () => doing(async () => { if (confirm("Restore the machine as before this run?")) await start("undo"); }));
  byId("run-report").addEventListener("click", () => doing(async () => {
    const { address } = await json("POST", pathTo("/machine/ticket"));
    replace("run-shown", [element("iframe", { src: address, title: "Report of the run" })]);
  }));
}
