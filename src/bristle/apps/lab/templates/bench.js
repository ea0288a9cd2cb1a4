// A model on the bench: its values, its initial values, and its path.

function newBench(theme) {
  return {
    model: null, contact: null, pin: null, level: 1, tracked: null, live: null, values: {}, first: {}, preset: "triangle", turns: [0], moment: 1, theme, settings: [],
    samples: SAMPLES, ghosts: new Map(),
    all() { return [...this.model.variables, ...this.settings]; },
    setAll(values) {
      this.run = this.swept = null;
      this.contact.hold();
      for (const [name, list] of Object.entries(values)) this.contact.set(name, list);
    },
    // Compute in the middle of the axis, without any variation along it.
    inTheMiddle(compute) {
      const { placed } = this.model;
      if (!placed?.size) return compute();
      this.contact.hold();
      for (const [name, list] of Object.entries(this.values)) if (!placed.has(name)) this.contact.set(name, list);
      const result = compute();
      this.setAll(this.values);
      return result;
    },
    isMoved() {
      const { variables, around = [] } = this.model;
      return this.start.model.model !== this.model.model
        || [...variables, ...around].some(({ name }) => this.values[name].some((value, i) => value !== this.first[name][i]));
    },
    // `start` is the initial model of the page, before slots were added or removed.
    take(model, contact, settings, start = { model, contact }) {
      Object.assign(this, { model, contact, settings, start, level: model.scales.force, ghosts: new Map(), moment: 1 });
      this.first = Object.fromEntries(this.all().map(({ name, values }) => [name, numbersOf(values)]));
      this.values = structuredClone(this.first);
    },
    // Compute with the initial values.
    atStart(compute) {
      const { model, contact } = this.start;
      contact.hold();
      for (const { name, values } of model.variables) contact.set(name, numbersOf(values));
      for (const { name } of this.settings) contact.set(name, this.values[name]);
      const result = compute(contact);
      this.setAll(this.values);
      return result;
    },
    // Move the contact along another path, with the initial amplitude of that path.
    aim(preset) {
      Object.assign(this, { preset, moment: 1 });
      this.first.amplitude = [round(PRESETS[preset].amplitude * this.model.scales.reach)];
      this.values.amplitude = [...this.first.amplitude];
    },
    // Set a value; if it is one of several shares, adjust the others.
    move(name, index, value) {
      const moved = this.values[name].map((old, i) => (i === index ? value : old));
      this.values[name] = this.model.shares.includes(name) && moved.length > 1 ? shared(moved, index) : moved;
      this.contact.set(name, this.values[name]);
    },
  };
}
