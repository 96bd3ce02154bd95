/* In the head of the page, before anything is drawn: the worker starts, and Python is on its way to it.  What the worker
   says before somebody listens is kept. */
"use strict";
window.lure = (() => {
  const text = (id) => document.getElementById(id).textContent;
  const worker = new Worker(URL.createObjectURL(new Blob([text("worker")], { type: "text/javascript" })));
  const kept = [];
  let listener = (data) => kept.push(data);
  worker.onerror = (event) => listener({ failed: event.message || "the browser refused to start the worker" });
  worker.onmessage = ({ data }) => listener(data);
  worker.postMessage({ lock: JSON.parse(text("start")).lock });
  window.lureAsset = (file, packed) => worker.postMessage({ file, text: packed });
  const parts = ["pyodide.mjs", "pyodide.asm.mjs", "pyodide.asm.wasm", "python_stdlib.zip", "core.zip", "flint.zip"];
  let there = 0;
  for (const name of parts) {
    const script = document.createElement("script");  // a page opened as a file may fetch nothing
    script.src = `assets/${name}.js`;
    script.onload = () => {
      script.remove();
      listener({ loaded: ++there, of: parts.length });
    };
    script.onerror = () => listener({ failed: `assets/${name}.js is missing beside this page; keep the folder whole` });
    document.head.append(script);
  }
  return {
    ask: (message) => worker.postMessage(message),
    listen: (wanted) => {
      listener = wanted;
      kept.splice(0).forEach(wanted);
    },
  };
})();
