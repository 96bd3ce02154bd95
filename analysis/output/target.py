"""Where results may be written, and what they may replace there: only a directory that is visibly ours."""

from __future__ import annotations

import json
import re
import secrets
from contextlib import suppress
from pathlib import Path

from lure.errors import InputError

MARKERS = {"report.json": "lure-report/", "paper.json": "lure-paper/"}
_MARKER_BYTES = 64 * 1024 * 1024
_FIGURE = re.compile(r"[\w.-]+\.(svg|png)", re.ASCII)
_CERTIFICATE = re.compile(r"\d+-[\w-]+\.json", re.ASCII)
_PAGE = re.compile(r"(report|paper)\.(html|json)|report\.pdf", re.ASCII)
_LITTER = {".DS_Store", "Thumbs.db", "desktop.ini"}  # left by file managers in any folder they show


def checked_target(directory: Path) -> Path:
    """Absolute path of a directory that results may be written to; the check leaves nothing behind.

    Parameters
    ----------
    directory : Path
        The directory, which need not exist.

    Raises
    ------
    InputError
        It is a file, a symbolic link, a mount point, or the current directory or above it; it holds something that is
        not part of a report; or it cannot be created there.
    """
    try:
        return _checked(directory)
    except InputError:
        raise
    except (OSError, RuntimeError, ValueError) as error:  # RuntimeError: links in a circle; ValueError: a NUL byte
        raise InputError(unwritable(directory, error)) from None


def unwritable(directory: Path, error: Exception) -> str:
    """Sentence on a system call that failed."""
    reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return f"{str(directory)!r} cannot be written ({reason}); give another directory with -o"


def _checked(directory: Path) -> Path:
    named = directory.name not in ("", "..")
    target = directory.parent.resolve() / directory.name if named else directory.resolve()
    label = repr(str(directory))
    if Path.cwd().is_relative_to(target):
        raise InputError(f"{label} is the current directory or above it; give a new directory with -o")
    if target.is_symlink():
        raise InputError(f"{label} is a symbolic link; give the directory itself, or a new one, with -o")
    if target.exists():
        _check_replaceable(target, label)
    ancestor = target.parent
    while not ancestor.exists() and not ancestor.is_symlink():
        ancestor = ancestor.parent
    if not ancestor.is_dir():
        raise InputError(f"{label} cannot be created, since {str(ancestor)!r} is not a directory; give another with -o")
    # named as the next run's leftovers are, which clears it away if this run is killed on this line
    probe = ancestor / f".{target.name}.lure-{secrets.token_hex(4)}"
    probe.mkdir()
    with suppress(FileNotFoundError):  # another run has cleared it away already
        probe.rmdir()
    return target


def _check_replaceable(target: Path, label: str) -> None:
    if not target.is_dir():
        raise InputError(f"{label} is a file; give a directory with -o")
    if target.is_mount():
        raise InputError(f"{label} is a mount point, which cannot be replaced; give a directory inside it with -o")
    stranger = _stranger(target)
    if stranger:
        raise InputError(f"{label} holds {stranger!r}, which is not part of a report; give another directory with -o")


def _stranger(directory: Path) -> str | None:
    """Something in the directory that no report has; None for an empty one and for a report, ours to replace."""
    paths = sorted(path for path in directory.iterdir() if path.name not in _LITTER)
    ours = not paths or any(_is_marker(directory / name, schema) for name, schema in MARKERS.items())
    for path in paths:
        if not ours or path.is_symlink() or not (_is_folder(path) if path.is_dir() else _is_page(path)):
            return path.name
    return None


def _is_page(path: Path) -> bool:
    return path.is_file() and bool(_PAGE.fullmatch(path.name) or _FIGURE.fullmatch(path.name))


def _is_folder(path: Path) -> bool:
    pattern = {"figures": _FIGURE, "certificates": _CERTIFICATE}.get(path.name)
    return pattern is not None and all(
        entry.name in _LITTER or (pattern.fullmatch(entry.name) and entry.is_file()) for entry in path.iterdir()
    )


def _is_marker(path: Path, schema: str) -> bool:
    try:
        if not path.is_file() or path.stat().st_size > _MARKER_BYTES:
            return False
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(content, dict) and str(content.get("schema")).startswith(schema)
