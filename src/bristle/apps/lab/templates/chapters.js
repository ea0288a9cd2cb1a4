// Six chapters: each is a model, a path and values, a task, and a check of measured quantities at the present moment.

const HELD = 0.02, DRIFTS = 0.05, STAYS = 0.01, CURED = 0.5; // shares: of the speed of the spring, of the pre-sliding distance, of the error

const CHAPTERS = [
  { word: "Stick", task: "The spring pulls below break-away. The block holds: its bristles only bend.",
    state: "model=lugre&path=hold&k=5e6&v_e=1e-6&time=10",
    check({ x, force, dt }, k) {
      const before = k - Math.round(1 / dt), moved = Math.abs(x[k] - x[before]);
      return before > 0.65 * x.length && moved < HELD * valueOf(lab, "v_e") && force[k] > 0.3 * lab.level
        && `The block holds ${told(force[k], lab.model.units.force)} at standstill, bent by ${told(x[k], lab.model.units.position)}.`;
    } },
  { word: "Break away", task: "Pull harder. At the break-away force the bristles slip and the block jumps.",
    state: "model=lugre&path=pulled&v_e=2e-4&sigma_2=20&time=7",
    check({ x, force }, k) {
      const most = extent(force.subarray(0, k + 1))[1];
      return x[k] > 10 * lab.model.scales.reach && force[k] < 0.95 * most && `It breaks away at ${told(most, lab.model.units.force)}.`;
    } },
  { word: "Slide", task: "Keep pulling with a soft spring. The block sticks and slips: it squeals.",
    state: "model=lugre&path=pulled&time=9",
    check({ x, dt }, k) {
      let slips = 0, fast = false;
      for (let i = 1; i <= k; i++) {
        const speed = (x[i] - x[i - 1]) / dt / valueOf(lab, "v_e");
        if (!fast && speed > 5) slips++;
        fast = speed > 5 || fast && speed > 0.5;
      }
      return slips >= 3 && `${slips} slips, with rests between them.`;
    } },
  { word: "Inner loops", task: "Reverse and return. LuGre misses its old force by the red gap; Preisach closes.",
    state: "model=lugre&path=minor&amplitude=2.25e-6&with=preisach_lugre",
    check({ at, force }, k) {
      if (k < at[5]) return false;
      const own = closingOf(lab, at, force), other = lab.pin && closingOf(lab.pin, at, runOf(lab.pin).force);
      return !own.closes && other?.closes && `${lab.model.model} misses ${withDigits(100 * own.share, 2)} % of friction; ${lab.pin.model.model} closes.`;
    } },
  { word: "Drift", task: "The force ripples below break-away. LuGre walks with each cycle; Preisach stays.",
    state: "model=lugre&path=ripple&time=16&with=preisach_lugre",
    check({ x }, k) {
      const cycle = Math.round(PULLED / CYCLES_PULLED), first = Math.round(PULLED / 16) + cycle, cycles = Math.floor((k - first) / cycle);
      if (cycles < 4 || !lab.pin) return false;
      const [own, other] = [x, runOf(lab.pin).x].map((each) => (each[first + cycles * cycle] - each[first]) / cycles), { reach } = lab.model.scales;
      return own > DRIFTS * reach && Math.abs(other) < STAYS * reach && `${lab.model.model} walks ${told(own, lab.model.units.position)} a cycle; ${lab.pin.model.model} stays.`;
    } },
  { word: "Cure the spike", task: "At each reversal friction throws a controlled axis off. Feedforward of friction removes the error.",
    state: "model=lugre&path=tracked&loop_A=2e-4&loop_f=0.5&loop_gain=60", tab: "track",
    check({ x }, k) {
      if (!lab.tracked || k < 0.5 * x.length) return false;
      const [alone, fed] = ["none", "model"].map((way) => widthOf(lab.tracked.errors[way]));
      return fed < CURED * alone && `Error at reversals: ${told(alone, lab.model.units.position)} without, ${told(fed, lab.model.units.position)} with feedforward.`;
    } },
];
const done = new Map();

function buildChapters() {
  byId("chapters").append(...CHAPTERS.map(({ word }, i) => element("button", { type: "button", value: i + 1, onclick: () => openAndPlay(`chapter=${i + 1}`) },
    element("span", { class: "mark", text: i + 1 }), element("span", { text: word }))));
  tellChapter();
}

// Open a chapter, or any other state of the page, and play it from its beginning.
async function openAndPlay(text) {
  play(false);
  await go(text);
  keep();
  lab.moment = 0;
  play(true);
}

// Another model or path is no longer the chapter.
function leaveChapter() {
  lab.chapter = 0;
  tellChapter();
}

function tellChapter() {
  const { task } = CHAPTERS[lab.chapter - 1] ?? {}, found = done.get(lab.chapter);
  const text = !task ? "Drag the block or the end of the spring, drag a handle on a curve, or play a chapter." : `${task}${found ? ` ✓ ${found}` : ""}`;
  if (byId("task").textContent !== text) byId("task").textContent = text;
  byId("task").classList.toggle("done", Boolean(task && found));
  for (const button of byId("chapters").children) {
    const number = Number(button.value), earned = done.has(number);
    button.setAttribute("aria-pressed", String(number === lab.chapter));
    button.classList.toggle("done", earned);
    button.firstChild.textContent = earned ? "✓" : number;
    button.setAttribute("aria-label", `Chapter ${number}: ${CHAPTERS[number - 1].word}${earned ? ", done" : ""}`);
  }
}

function checkChapter() {
  const chapter = CHAPTERS[lab.chapter - 1];
  if (!chapter || !clock.plays) return;
  const run = runOf(lab), found = chapter.check(run, Math.round((run.x.length - 1) * lab.moment));
  if (!found || done.get(lab.chapter) === found) return;
  done.set(lab.chapter, found);
  tellChapter();
}
