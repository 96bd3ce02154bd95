/* The worker: Python with the exact core and both checkers.  A classic worker, since a page opened as a file may start no
   module worker; Pyodide refuses those that have importScripts, which this one does without. */
"use strict";
self.importScripts = undefined;

const native = self.fetch.bind(self);
const held = /** @type {Record<string, {bytes: Promise<Uint8Array>, arrived: (bytes: Promise<Uint8Array>) => void}>} */ ({});

/** A file of the page, which may still be on its way. @param {string} name */
function file(name) {
  if (!held[name]) {
    let arrived = (_) => {};
    held[name] = { bytes: new Promise((done) => { arrived = done; }), arrived: (bytes) => arrived(bytes) };
  }
  return held[name];
}

/** @param {string} text base64 of gzip @returns {Promise<Uint8Array>} */
async function unpacked(text) {
  const packed = await (await native("data:application/octet-stream;base64," + text)).blob();
  const stream = packed.stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** @param {Record<string, unknown>} lock */
async function started(lock) {
  const imported = async (name) => import(URL.createObjectURL(new Blob([await file(name).bytes], { type: "text/javascript" })));
  self.fetch = async (address) => {  // nothing is fetched: what Python asks for is part of the page, or nowhere
    const name = String(address.url ?? address).split("/").pop();
    const type = name.endsWith(".wasm") ? "application/wasm" : "application/octet-stream";
    return new Response(await file(name).bytes, { headers: { "content-type": type } });
  };
  const [{ loadPyodide }, { default: createPyodideModule }] = await Promise.all(
    ["pyodide.mjs", "pyodide.asm.mjs"].map(imported));
  const python = await loadPyodide({
    indexURL: "https://page.invalid/", lockFileContents: lock, createPyodideModule, fullStdLib: false });
  postMessage({ progress: "Python is ready; the arithmetic and the checkers follow." });
  const site = python.runPython("import sysconfig; sysconfig.get_paths()['purelib']");
  for (const name of ["flint.zip", "core.zip"]) python.unpackArchive(await file(name).bytes, "zip", { extractDir: site });
  return python.runPython("from lure.analysis.explore.served import respond\nrespond");
}

let respond;
self.onmessage = async ({ data }) => {
  if (data.file) {
    file(data.file).arrived(unpacked(data.text));
    return;
  }
  if (data.lock) {
    try {
      respond = await started(data.lock);
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
