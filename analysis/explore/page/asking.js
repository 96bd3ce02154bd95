/** The worker's client: loads what it needs, asks one question at a time, and of each kind only the newest. */

/** @typedef {{ask: string} & Record<string, string>} Question */

const FILES = ["pyodide.mjs", "pyodide.asm.mjs", "pyodide.asm.wasm", "python_stdlib.zip", "flint.zip", "core.zip"];

/** Load an asset by a script element: a page opened as a file may fetch nothing. @param {string} name */
function loaded(name) {
  return new Promise((done, failed) => {
    const script = document.createElement("script");
    script.src = `assets/${name}.js`;
    script.onload = () => { script.remove(); done(undefined); };
    script.onerror = () => failed(new Error(`assets/${name}.js is missing beside this page; keep the folder whole`));
    document.head.append(script);
  });
}

export class Asking {
  /** @param {(text: string) => void} progress */
  constructor(progress) {
    /** @type {Map<string, {question: Question, answered: (answer: any) => void}>} */
    this.waiting = new Map();
    this.busy = /** @type {((answer: any) => void) | null} */ (null);
    this.open = false;
    this.id = 0;
    this.ready = this.#start(progress);
  }

  /** @param {(text: string) => void} progress */
  async #start(progress) {
    const source = /** @type {HTMLElement} */ (document.getElementById("worker")).textContent ?? "";
    const worker = new Worker(URL.createObjectURL(new Blob([source], { type: "text/javascript" })));
    this.worker = worker;
    const { lock } = JSON.parse(/** @type {HTMLElement} */ (document.getElementById("start")).textContent ?? "{}");
    await new Promise((done, failed) => {
      worker.onerror = (event) => failed(new Error(event.message || "the browser refused to start the worker"));
      worker.onmessage = ({ data }) => {
        if (data.progress) progress(data.progress);
        else if (data.failed) failed(new Error(data.failed));
        else if (data.ready) done(undefined);
        else this.#arrived(data);
      };
      worker.postMessage({ lock });
      for (const name of FILES) {
        loaded(name).then(() => {  // Python starts while the arithmetic is still on its way
          worker.postMessage({ file: name, text: window.lureAssets[name] });
          delete window.lureAssets[name];  // the worker has its own copy
        }).catch(failed);
      }
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
    this.worker?.postMessage({ id: ++this.id, question });
  }

  /** @param {{id: number, answer: any}} data */
  #arrived(data) {
    const answered = this.busy;
    this.busy = null;
    answered?.(data.answer);
    this.#next();
  }
}
