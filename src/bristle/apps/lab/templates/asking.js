// Long computations in a worker of the shared script, one at a time; of waiting requests only the newest is kept.

class Asked {
  // `name` is that of a function of the shared script, `compute` the function; `answer` is called with its result.
  constructor(name, compute, answer) { Object.assign(this, { name, compute, answer, worker: null, busy: false, next: null, found: null }); }

  async put(question) {
    this.next = question;
    if (this.busy) return;
    this.busy = true;
    while (this.next) {
      const asked = this.next;
      this.next = null;
      this.answer(this.found = await this.result(asked));
    }
    this.busy = false;
  }

  // If the host forbids a worker, the page computes.
  async result(question) {
    try {
      if (this.worker !== "none") return await this.inWorker(question);
    } catch { this.worker = "none"; }
    await new Promise((resolve) => setTimeout(resolve, 0)); // draw first
    return this.compute(question);
  }

  inWorker(question) {
    const code = [byId("shared").textContent, `onmessage = async ({ data }) => postMessage(await ${this.name}(data));`];
    this.worker ??= new Worker(URL.createObjectURL(new Blob(code, { type: "text/javascript" })));
    return new Promise((resolve, reject) => {
      Object.assign(this.worker, { onmessage: ({ data }) => resolve(data), onerror: reject });
      this.worker.postMessage(question);
    });
  }
}
