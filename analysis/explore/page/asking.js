/** The worker's client: asks one question at a time, and of each kind only the newest. */

/** @typedef {{ask: string} & Record<string, string>} Question */

export class Asking {
  /** @param {(share: number, text: string) => void} progress told how much of the loading is done, and what comes next */
  constructor(progress) {
    /** @type {Map<string, {question: Question, answered: (answer: any) => void}>} */
    this.waiting = new Map();
    this.busy = /** @type {((answer: any) => void) | null} */ (null);
    this.open = false;
    this.id = 0;
    this.ready = this.#start(progress);
  }

  /** @param {(share: number, text: string) => void} progress */
  async #start(progress) {
    let [share, text] = [0, ""];
    await new Promise((done, failed) => {
      window.lure.listen((data) => {
        if (data.progress) [share, text] = [data.share, data.progress];
        else if (data.loaded) share = Math.max(share, (0.4 * data.loaded) / data.of);
        if (data.progress || data.loaded) progress(share, share > 0.4 ? text : `Part ${data.loaded} of ${data.of} has arrived`);
        else if (data.failed) failed(new Error(data.failed));
        else if (data.ready) done(undefined);
        else this.#arrived(data);
      });
    });
    this.open = true;
    this.#next();
  }

  /** Ask; an older question of the same kind that still waits is dropped, and never answered.
   * @param {Question} question @returns {Promise<any>} */
  ask(question) {
    return new Promise((answered) => {
      this.waiting.delete(question.ask);
      this.waiting.set(question.ask, { question, answered });
      this.#next();
    });
  }

  /** Whether something is asked and not answered. */
  get working() { return this.busy !== null || this.waiting.size > 0; }

  #next() {
    const first = this.waiting.entries().next();
    if (!this.open || this.busy || first.done) return;
    const [kind, { question, answered }] = first.value;
    this.waiting.delete(kind);
    this.busy = answered;
    window.lure.ask({ id: ++this.id, question });
  }

  /** @param {{id: number, answer: any}} data */
  #arrived(data) {
    const answered = this.busy;
    this.busy = null;
    answered?.(data.answer);
    this.#next();
  }
}
