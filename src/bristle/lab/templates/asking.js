// Long computations in a worker of the shared script, one at a time; of waiting requests only the newest is kept.

class Asked {
  // `name` is that of a function of the shared script, `compute` the function; `answer` is called with its result.
  constructor(name, compute, answer) {
    Object.assign(this, { name, compute, answer, worker: null, busy: false, next: null, found: null });
  }

  put(question) {
    this.next = question;
    this.ask();
  }

  ask() {
    if (this.busy || !this.next) return;
    const question = this.next;
    this.busy = true;
    this.worker ??= this.newWorker();
    if (this.worker === "none") setTimeout(async () => this.take(question, await this.compute(question)), 0);
    else {
      this.worker.onmessage = ({ data: found }) => this.take(question, found);
      this.worker.postMessage(question);
    }
  }

  take(question, found) {
    this.busy = false;
    if (found) {
      Object.assign(this, { found, next: this.next === question ? null : this.next });
      this.answer(found);
    }
    this.ask();
  }

  // "none" if the host forbids a worker; then the page computes.
  newWorker() {
    try {
      const code = [byId("shared").textContent, `onmessage = async ({ data }) => postMessage(await ${this.name}(data));`];
      const worker = new Worker(URL.createObjectURL(new Blob(code, { type: "text/javascript" })));
      worker.onerror = () => {
        this.worker = "none";
        this.take(this.next, null);
      };
      return worker;
    } catch { return "none"; }
  }
}
