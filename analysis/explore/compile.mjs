/* Run by Node.js when the page is built: Python for the browser opens the loop of the page once, and compiles what that
   imported.  In place of their sources `core.zip` and `python_stdlib.zip` then hold these modules as bytecode without
   positions in the source.  The argument is the folder of all files. */
import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [, , folder] = process.argv;
const { loadPyodide } = await import(pathToFileURL(`${folder}/pyodide.mjs`).href);
const python = await loadPyodide({ indexURL: `${folder}/`, fullStdLib: false });
const bytes = (name) => new Uint8Array(readFileSync(`${folder}/${name}`));
const site = python.runPython("import sysconfig; sysconfig.get_paths()['purelib']");
for (const name of ["flint.zip", "core.zip"]) python.unpackArchive(bytes(name), "zip", { extractDir: site });
const respond = python.runPython("from lure.analysis.explore.served import respond\nrespond");
for (const ask of ["plant", "largest", "line", "class"]) {
  const { error } = JSON.parse(respond(JSON.stringify({ ask, num: "1", den: "1 3 2 0", k: "5", theta: "3/2" })));
  if (error) throw new Error(error);
}
python.globals.set("imported", python.runPython("import sys; [str(getattr(one, '__file__', '')) for one in sys.modules.values()]"));
python.runPython(`
import zipfile
from importlib._bootstrap_external import _code_to_hash_pyc

def compiled(source, name):
    return bytes(_code_to_hash_pyc(placeless(compile(source, name, "exec", dont_inherit=True)), bytes(8), False))

def placeless(code):
    """The code with the shortest table of positions: each entry says of eight instructions that they have none."""
    whole, rest = divmod(len(code.co_code) // 2, 8)
    table = bytes([0xFF] * whole + ([0xF8 | (rest - 1)] if rest else []))
    inner = tuple(placeless(one) if hasattr(one, "co_code") else one for one in code.co_consts)
    return code.replace(co_linetable=table, co_consts=inner)

def packed(name):
    with zipfile.ZipFile(f"/{name}") as full, zipfile.ZipFile(f"/compiled-{name}", "w") as kept:
        for one in full.namelist():
            if any(file.endswith(f"/{one}") for file in imported) and one.endswith(".py"):
                kept.writestr(zipfile.ZipInfo(one + "c"), compiled(full.read(one), one))
            else:
                kept.writestr(zipfile.ZipInfo(one), full.read(one))
`);
for (const name of ["core.zip", "python_stdlib.zip"]) {
  python.FS.writeFile(`/${name}`, bytes(name));
  python.runPython(`packed("${name}")`);
  writeFileSync(`${folder}/compiled-${name}`, python.FS.readFile(`/compiled-${name}`));
}
