// A model in a notebook: the views of the lab in a separate root, with the values of a Python model.

const SHOWN = ["triangle", "loops", "minor", "presliding"];
const SETTINGS = { loop: ["amplitude", "period"], speed: ["top"] };

function plainValues(bench) {
  const told_ = (value) => (Number.isFinite(value) ? value : typed(value) === "inf" ? "Infinity" : "-Infinity");
  return Object.fromEntries(bench.model.variables.map(({ name }) => [name, bench.values[name].map(told_)]));
}

// The theme of JupyterLab or VS Code; in other hosts that of the system.
function themeOf({ dataset: { jpThemeLight }, classList }) {
  if (jpThemeLight === "true" || classList.contains("vscode-light")) return "light";
  return jpThemeLight === "false" || classList.contains("vscode-dark") ? "dark" : "";
}

class Bench {
  constructor(model, el) {
    this.host = element("div");
    el.append(this.host);
    this.root = this.host.attachShadow({ mode: "open" });
    Object.assign(this, { model, bench: null, shown: {}, waits: 0, turn: 0, moved: false });
    this.root.append(element("style", { text: STYLE }), this.layout());
    this.observer = new ResizeObserver((entries) => {
      entries.forEach(resized);
      this.later();
    });
    for (const canvas of this.root.querySelectorAll("canvas")) this.observer.observe(canvas);
    this.themes = new MutationObserver(() => this.later());
    this.themes.observe(document.body, { attributeFilter: ["class", "data-jp-theme-light"] });
    this.listeners = { "change:_described": () => this.build(), "change:_values": () => this.read(), "change:_problem": () => this.tellProblem() };
    for (const [event, listener] of Object.entries(this.listeners)) model.on(event, listener);
  }

  layout() {
    const view = (name, title, label) => element("section", { class: "view", id: `view-${name}` }, element("h2", { text: title, id: `${name}-title` }),
      name === "loop" ? element("div", { class: "presets", role: "group", "aria-label": "Path" }) : null,
      element("canvas", { id: name, role: "img", "aria-label": label, "aria-describedby": `${name}-reading` }),
      element("p", { class: "reading", id: `${name}-reading` }),
      SETTINGS[name] ? element("div", { class: "settings", id: `${name}-settings` }) : null);
    const card = element("div", { class: "bristle" });
    card.innerHTML = this.model.get("_card") ?? "";
    return element("div", { class: "host" }, card,
      element("p", { class: "problem", role: "alert" }), element("ul", { class: "broken", role: "status" }),
      element("div", { class: "bench" },
        element("div", { class: "cards", role: "group", "aria-label": "Parameters" }),
        view("loop", "Force over position", "Friction force over position"),
        view("speed", "Friction over velocity", "Friction force over velocity"),
        view("plane", "Memory", "Memory of the model")));
  }

  at(name) { return this.root.getElementById(name); }

  // Once for each model; Python may set another model.
  async build() {
    const turn = ++this.turn, described = this.model.get("_described"), contact = await loaded(described);
    if (turn !== this.turn) return;
    const bench = newBench(colours(this.host)), names = Object.values(SETTINGS).flat();
    bench.take(described, contact, settingsOf(described).filter(({ name }) => names.includes(name)));
    this.bench = bench;
    bench.aim("triangle");
    this.buildCards();
    this.buildPaths();
    this.at("view-plane").hidden = !described.stack && !described.elements;
    this.read();
  }

  cardsFor(variable) {
    const { bench } = this, handlers = (i) => ({ input: (value, from) => this.set(variable, i, value, from), change: () => {}, start: () => bench.first[variable.name][i] });
    this.shown[variable.name] = cardsOf(variable, bench.values[variable.name].length, handlers);
    return this.shown[variable.name].map(({ root }) => root);
  }

  buildCards() {
    this.shown = {};
    this.root.querySelector(".cards").replaceChildren(...this.bench.model.variables.flatMap((variable) => this.cardsFor(variable)));
    for (const [view, names] of Object.entries(SETTINGS)) {
      const settings = this.bench.settings.filter(({ name }) => names.includes(name));
      this.at(`${view}-settings`).replaceChildren(...settings.flatMap((variable) => this.cardsFor(variable)));
    }
  }

  buildPaths() {
    this.root.querySelector(".presets").replaceChildren(...SHOWN.map((name) =>
      element("button", { type: "button", value: name, text: PRESETS[name].word, onclick: () => { this.bench.aim(name); this.showAll(); } })));
  }

  // After a slider move the page draws at once, and Python gets the values once a frame.
  set(variable, index, value, from) {
    const { bench } = this;
    bench.move(variable.name, index, value);
    showIn(this.shown[variable.name], bench.values[variable.name], index, from);
    this.moved ||= bench.model.variables.includes(variable);
    this.later();
  }

  // Python or the page set values; those of the page are the same.
  read() {
    const { bench } = this, given = this.model.get("_values");
    // Values of another model belong to the bench under construction.
    if (!bench || !bench.model.variables.every(({ name }) => given[name]?.length === bench.values[name].length)) return;
    for (const { name } of bench.model.variables) bench.values[name] = numbersOf(given[name]);
    this.tellProblem();
    this.showAll();
  }

  tellProblem() { this.root.querySelector(".problem").textContent = this.model.get("_problem") ?? ""; }

  showAll() {
    const { bench } = this;
    bench.setAll(bench.values);
    for (const { name } of bench.all()) showIn(this.shown[name], bench.values[name]);
    for (const button of this.root.querySelector(".presets").children) button.setAttribute("aria-pressed", String(button.value === bench.preset));
    this.later();
  }

  later() { this.waits ||= requestAnimationFrame(() => this.draw()); }

  draw() {
    const { bench } = this;
    this.waits = 0;
    if (!bench || !this.host.isConnected) return;
    this.host.className = themeOf(document.body);
    bench.theme = colours(this.host);
    const memory = bench.model.stack ? planeView : bench.model.elements ? elementsView : null;
    for (const [name, view] of Object.entries({ loop: loopView, speed: speedView, plane: memory })) {
      if (!view) continue;
      const { words, alert } = view(bench, this.at(name));
      tell(this.at(`${name}-reading`), words, Boolean(alert));
    }
    const lines = brokenLines(bench.model, bench.values), list = this.root.querySelector(".broken");
    if (list.innerHTML !== lines) list.innerHTML = lines;
    if (this.moved) this.save();
  }

  save() {
    this.moved = false;
    this.model.set("_values", plainValues(this.bench));
    this.model.save_changes();
  }

  gone() {
    this.observer.disconnect();
    this.themes.disconnect();
    cancelAnimationFrame(this.waits);
    for (const [event, listener] of Object.entries(this.listeners)) this.model.off(event, listener);
    this.host.remove();
  }
}

async function render({ model, el }) {
  const bench = new Bench(model, el);
  await bench.build();
  return () => bench.gone();
}
