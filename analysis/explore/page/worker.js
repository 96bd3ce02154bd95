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
  const next = (share, progress) => postMessage({ share, progress });
  next(0.45, "Python starts");
  const python = await loadPyodide({
    indexURL: "https://page.invalid/", lockFileContents: lock, createPyodideModule, fullStdLib: false });
  next(0.6, "Python is ready; the exact arithmetic is loaded");
  const site = python.runPython("import sysconfig; sysconfig.get_paths()['purelib']");
  for (const name of ["flint.zip", "core.zip"]) python.unpackArchive(await file(name).bytes, "zip", { extractDir: site });
  // Forty libraries that share one: known to each other at once, not copied into the scope of each, in half the time.
  python.runPython("import os, sys; sys.setdlopenflags(os.RTLD_NOW | os.RTLD_GLOBAL); import flint");
  next(0.8, "The arithmetic is ready; both checkers are loaded");
  const respond = python.runPython("from lure.analysis.explore.served import respond\nrespond");
  next(0.95, "The checkers are ready; the first proof is looked for");
  return respond;
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
