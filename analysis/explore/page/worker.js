/* The worker: Python with the exact core and both checkers.  A classic worker, since a page opened as a file may start no
   module worker; Pyodide refuses those that have importScripts, which this one does without. */
"use strict";
self.importScripts = undefined;

/** @param {string} text base64 of gzip @returns {Promise<Uint8Array>} */
async function unpacked(text) {
  const packed = await (await fetch("data:application/octet-stream;base64," + text)).blob();
  const stream = packed.stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** @param {Record<string, string>} texts assets by name @param {Record<string, unknown>} lock */
async function started(texts, lock) {
  const held = {};
  await Promise.all(Object.entries(texts).map(async ([name, text]) => { held[name] = await unpacked(text); }));
  const imported = (name) => import(URL.createObjectURL(new Blob([held[name]], { type: "text/javascript" })));
  self.fetch = async (address) => {  // nothing is fetched: what Python asks for is at hand, or nowhere
    const name = String(address.url ?? address).split("/").pop();
    if (!(name in held)) throw new Error(`${name} is not part of this page`);
    const type = name.endsWith(".wasm") ? "application/wasm" : "application/octet-stream";
    return new Response(held[name], { headers: { "content-type": type } });
  };
  const [{ loadPyodide }, { default: createPyodideModule }] = await Promise.all(
    ["pyodide.mjs", "pyodide.asm.mjs"].map(imported));
  const python = await loadPyodide({
    indexURL: "https://page.invalid/", lockFileContents: lock, createPyodideModule, fullStdLib: false });
  postMessage({ progress: "Python is ready; the arithmetic and the checkers follow." });
  const site = python.runPython("import sysconfig; sysconfig.get_paths()['purelib']");
  for (const name of ["flint.zip", "core.zip"]) python.unpackArchive(held[name], "zip", { extractDir: site });
  return python.runPython("from lure.analysis.explore.served import respond\nrespond");
}

let respond;
self.onmessage = async ({ data }) => {
  if (data.start) {
    try {
      respond = await started(data.start, data.lock);
      postMessage({ ready: true });
    } catch (error) {
      postMessage({ failed: String(error) });
    }
    return;
  }
  try {
    postMessage({ id: data.id, answer: JSON.parse(respond(JSON.stringify(data.question))) });
  } catch (error) {
    const lines = String(error).trim().split("\n");
    postMessage({ id: data.id, answer: { error: `the page has a bug: ${lines[lines.length - 1]}`, field: "plant" } });
  }
};
