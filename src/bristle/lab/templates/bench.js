// A model on the bench: its values, those that it began with, and the path that it is led along.

function newBench(theme, recorded = null) {
  return {
    model: null, contact: null, values: {}, first: {}, preset: "triangle", turns: [0], moment: 1, theme, settings: [], recorded,
    all() { return [...this.model.variables, ...this.settings]; },
    setAll(values) {
      for (const [name, list] of Object.entries(values)) this.contact.set(name, list);
    },
    isMoved() {
      return this.model.variables.some(({ name }) => this.values[name].some((value, i) => value !== this.first[name][i]));
    },
    take(model, contact, settings) {
      Object.assign(this, { model, contact, settings, ghost: null, moment: 1 });
      this.first = Object.fromEntries(this.all().map(({ name, values }) => [name, numbersOf(values)]));
      this.values = Object.fromEntries(Object.entries(this.first).map(([name, values]) => [name, [...values]]));
    },
    // Move the contact along another path, which begins with an amplitude of its own.
    aim(preset) {
      Object.assign(this, { preset, moment: 1 });
      this.first.amplitude = [round(PRESETS[preset].amplitude * this.model.scales.reach)];
      this.values.amplitude = [...this.first.amplitude];
    },
    // A value that was moved, and where it is one of several shares the others with it.
    move(name, index, value) {
      const moved = this.values[name].map((old, i) => (i === index ? value : old));
      this.values[name] = this.model.shares.includes(name) && moved.length > 1 ? shared(moved, index) : moved;
      this.contact.set(name, this.values[name]);
    },
  };
}
