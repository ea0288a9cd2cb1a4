// Tune a machine: the plan, the run with its gates, live records, and the change of the following error.

const RUN_STATES = { waiting: ["○", "waiting"], running: ["▶", "running"], passed: ["✓", "passed"], refused: ["✕", "refused"] };
const OUTCOMES = { kept: ["usable", "Kept"], restored: ["no", "Restored"], not_restored: ["no", "Not restored"], undone: ["", "Undone"], running: ["", "Running"] };
const KEYS = { measured: "measured", reference: "with", without: "without", with: "with" }; // name of a curve -> its colour
let run = null, record = null, drawnRecord = "";

const machineJob = () => (["plan", "tune", "undo"].includes(state.job?.task) && state.job.state === "runs" ? state.job.task : "");

// Seconds until the planned end of a step; null without a plan or for a run of another process.
function secondsLeft(place) {
  const planned = contents.planned?.data.seconds;
  if (machineJob() !== "tune" || !planned) return null;
  const sum = (list) => list.reduce((total, seconds) => total + seconds, 0);
  return Math.max(0, sum(planned.slice(0, place + 1)) - state.job.share * sum(planned));
}

function stepOfRun({ title, state: at, text }, place) {
  const [sign, known] = RUN_STATES[at], word = at === "waiting" && run.outcome !== "running" ? "not run" : known, left = at === "running" ? secondsLeft(place) : null;
  const age = `last entry ${withDigits(Math.round(run.age), 4)} s ago`;
  const fact = at !== "running" ? text : left === null ? age : `${left.toFixed(0)} s left`;
  return element("li", { class: `is-${at}`, "aria-current": at === "running" ? "step" : false },
    element("span", { class: "mark", "aria-hidden": "true", text: sign }), element("span", { text: title }),
    element("span", { class: "note", text: `${word}${fact ? `: ${fact}` : ""}` }));
}

const planView = ({ table }) => [tableOf(table)];

function outcomeView() {
  const [level, word] = OUTCOMES[run.outcome], { change } = run;
  return [
    element("p", { class: `ruling ${level}`, id: "outcome", text: run.outcome === "kept" ? `${word}: ${change.join(" → ")}` : word }),
    element("p", { text: run.sentences.filter((sentence) => !sentence.startsWith("Undo: ")).join(" ") }),
    run.undo && element("p", { class: "note" }, "Undo in a terminal: ", element("code", { text: run.undo })),
  ];
}

function recordPicture({ word, unit, keys, curves: [time, ...signals] }) {
  const label = keys[1] === "with" ? `${word} without and with the feedforward` : `${word}, record ${record.name.replaceAll("_", " ")}`;
  return pictureOf(label, (canvas, theme) => {
    const frame = frameOn(canvas, theme, { word: "time", unit: "s", values: time }, { word, unit, values: signals.flat() });
    signals.forEach((values, i) => frame.curve(time, values, { colour: theme[KEYS[keys[i]] ?? "with"], width: i + 1 < signals.length ? 2.4 : 1.2 }));
  }, ...keys.map((key) => [KEYS[key], key]));
}

async function showRun() {
  const job = machineJob(), watched = state.machine && !byId("tune").hidden;
  if (watched) ({ run, record } = await json("GET", pathTo("/machine")));
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
  const key = record ? `${record.name} ${record.revision}` : "";
  if (!watched || key === drawnRecord) return;
  const found = key ? await json("GET", pathTo(`/machine/records/${record.name}`)) : [];
  drawnRecord = key;
  replace("run-plots", found.map(recordPicture));
}

async function chooseMachine() {
  byId("run-shown").replaceChildren();
  drawnRecord = null;
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
  byId("move").addEventListener("click", () => doing(async () => {
    await start("tune");
    byId("plan-more").open = false;
    byId("run-view").scrollIntoView();
  }));
  byId("undo").addEventListener("click", () => doing(async () => { if (confirm("Restore the machine as before this run?")) await start("undo"); }));
  byId("run-report").addEventListener("click", () => doing(async () => {
    const { address } = await json("POST", pathTo("/machine/ticket"));
    replace("run-shown", [element("iframe", { src: address, title: "Report of the run" })]);
    byId("run-shown").scrollIntoView();
  }));
}
