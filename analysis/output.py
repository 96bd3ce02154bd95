"""Files and directories written aside and moved into place in one step.

At any moment, also after ``kill -9``, the target holds the old results or the new ones or nothing, never a mixture.
Where the system can exchange two names atomically (Linux) the old report is there until the new one is.  Elsewhere the
old one is moved aside first: killed between the two moves, a run leaves no report, and the next moves the old one back.
The hidden directory that holds the new results, and for a moment the old ones, is locked while it is in use.  The lock
dies with its owner, and the next run into the same target removes what is not locked.  Nothing is promised about a loss
of power.
"""

from __future__ import annotations

import errno
import json
import os
import re
import secrets
import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from lure.errors import InputError

# The two things the standard library lacks for moving directories: exchanging names in one step, and locking one.

_NOT_HERE = {errno.ENOSYS, errno.EINVAL, errno.EOPNOTSUPP, errno.EPERM}
_AT_FDCWD, _RENAME_EXCHANGE = -100, 2


def exchange(first: Path, second: Path) -> bool:
    """Exchange what two names stand for, atomically; False, and nothing done, where the system cannot (not Linux).

    Raises
    ------
    OSError
        The system can, but not with these.
    """
    if sys.platform != "linux":
        return False
    import ctypes

    rename = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if rename is None:
        return False
    done = rename(_AT_FDCWD, os.fsencode(first), _AT_FDCWD, os.fsencode(second), _RENAME_EXCHANGE)
    code = ctypes.get_errno()
    if done != 0 and code not in _NOT_HERE:
        raise OSError(code, os.strerror(code), str(first), None, str(second))
    return bool(done == 0)


def lock(directory: Path, *, wait: bool) -> Callable[[], None] | None:
    """Lock a directory for as long as this process lives, or until the function returned is called.

    Without ``wait``, None if another process holds the lock, or if there is no telling (Windows, some network disks).

    Raises
    ------
    OSError
        The directory cannot be opened.
    """
    if sys.platform == "win32":
        return (lambda: None) if wait else None
    import fcntl

    handle = os.open(directory, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except OSError:
        if not wait:
            os.close(handle)
            return None
    return lambda: os.close(handle)


# A text file written without overwriting anything by mistake.


def write_new(path: Path, text: str, *, force: bool) -> None:
    """Write a text file; one that exists is replaced only with ``force``, and then in one step.

    Parameters
    ----------
    path : Path
        The file; its directory must exist.
    text : str
        What to write, in UTF-8.
    force : bool
        Whether an existing file may be replaced.

    Raises
    ------
    InputError
        The file exists and ``force`` is false, or it cannot be written.
    """
    label = f"{str(path)!r:.200}"
    if os.path.isdir(path):  # which is quiet about names that no file may have
        raise InputError(f"{label} is a directory; give the name of a file, such as {str(path / 'rod.toml')!r}")
    if not force and os.path.lexists(path):
        raise InputError(f"{label} exists; give another name, or --force to replace it")
    if not os.path.isdir(path.parent):
        raise InputError(f"{str(path.parent)!r:.200} is no directory; give a file in one that exists")
    temporary = path.with_name(f".lure-{secrets.token_hex(4)}") if force else path
    try:
        with temporary.open("x", encoding="utf-8") as file:
            file.write(text)
        if force:
            temporary.replace(path)
    except FileExistsError:
        raise InputError(f"{label} exists; give another name, or --force to replace it") from None
    except OSError as error:
        if force:
            with suppress(OSError):
                temporary.unlink()
        raise InputError(f"{label} cannot be written ({error.strerror}); give another place") from None


# Where results may be written, and what they may replace there: only a directory that is visibly ours.

MARKERS = {"report.json": "lure-report/", "paper.json": "lure-paper/", "explore.json": "lure-explore/"}
_MARKER_BYTES = 64 * 1024 * 1024
_FIGURE = re.compile(r"[\w.-]+\.(svg|png)", re.ASCII)
_CERTIFICATE = re.compile(r"\d+-[\w-]+\.json", re.ASCII)
_ASSET = re.compile(r"[\w.-]+\.js", re.ASCII)
_PAGE = re.compile(r"(report|paper)\.(html|json)|report\.pdf|index\.html|explore\.json", re.ASCII)
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


def unwritable(path: Path, error: Exception, instead: str = "another directory with -o") -> str:
    """Sentence on a system call that failed."""
    reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return f"{str(path)!r:.200} cannot be written ({reason}); give {instead}"


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
    pattern = {"figures": _FIGURE, "certificates": _CERTIFICATE, "assets": _ASSET}.get(path.name)
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


_SPENT = {errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EFBIG, errno.EIO}
_OCCUPIED = {errno.ENOTEMPTY, errno.EEXIST}
_NEW, _OLD = "new", "old"


@contextmanager
def replaced(directory: Path) -> Iterator[Path]:
    """A new empty directory to write into, which takes the place of ``directory`` when the block ends.

    When an exception ends the block, ``KeyboardInterrupt`` included, it is removed and ``directory`` is as it was.

    Parameters
    ----------
    directory : Path
        Where the results shall be; one that :func:`checked_target` accepts.

    Raises
    ------
    InputError
        As for :func:`checked_target`, before or after the block; or the disk is full.
    OSError
        The block raised it, about something else than the directory.
    """
    target = checked_target(directory)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        _clean(target)
        hidden, release = _hidden(target)
    except OSError as error:
        raise InputError(unwritable(directory, error)) from None
    try:
        new = hidden / _NEW
        new.mkdir()
        yield new
        _place(new, checked_target(directory))
    except OSError as error:
        if error.errno in _SPENT or str(error.filename).startswith(str(target.parent)):
            raise InputError(unwritable(directory, error)) from error
        raise
    finally:
        _discard(hidden, target)
        release()


def _hidden(target: Path) -> tuple[Path, Callable[[], None]]:
    """A locked directory beside the target; another run may remove it before the lock is taken."""
    while True:
        path = target.with_name(f".{target.name}.lure-{secrets.token_hex(4)}")
        with suppress(FileExistsError, FileNotFoundError):
            path.mkdir()
            release = lock(path, wait=True)
            if release is not None and path.exists():
                return path, release


def _clean(target: Path) -> None:
    """Remove what killed runs left; move a report back that one of them had moved aside."""
    ours = re.compile(rf"\.{re.escape(target.name)}\.lure-[0-9a-f]{{8}}")
    for path in sorted(target.parent.iterdir()):
        if not ours.fullmatch(path.name) or path.is_symlink() or not path.is_dir():
            continue
        with suppress(OSError):
            release = lock(path, wait=False)
            if release is not None:
                _discard(path, target)
                release()


def _discard(hidden: Path, target: Path) -> None:
    """Remove a hidden directory with what was not placed or was replaced; an old report is moved back first."""
    with suppress(OSError):
        old = hidden / _OLD
        if old.is_dir() and not target.exists():
            old.rename(target)
        shutil.rmtree(hidden, ignore_errors=True)


def _place(new: Path, target: Path) -> None:
    try:
        new.rename(target)  # nothing there, or an empty directory
    except OSError as error:
        if error.errno not in _OCCUPIED:
            raise
        if not exchange(new, target):
            target.rename(new.with_name(_OLD))
            new.rename(target)  # should this fail, what is old is moved back by _discard


# Files and folders that appear together when all is done, or not at all.


def check_targets(paths: Sequence[Path], *, replace: bool) -> None:
    """Refuse places that cannot be written to, before anything is computed; a name without a suffix is a folder.

    ``paths``: files, and folders to come; ``replace``: whether files that exist may be replaced.

    Raises
    ------
    InputError
        Two are the same; one exists, is a directory, or lies in a directory that does not exist or is read-only.
    """
    require_distinct(paths)
    for path in paths:
        try:
            _check_target(path, replace=replace)
            probe = _aside(path)
            probe.touch(exist_ok=False)
            probe.unlink()
        except InputError:
            raise
        except (OSError, ValueError) as error:  # ValueError: a NUL byte
            raise InputError(unwritable(path, error, "another place")) from None


def require_distinct(paths: Sequence[Path]) -> None:
    """Refuse one file for two results.

    Raises
    ------
    InputError
        Two are the same.
    """
    if len({os.path.abspath(path) for path in paths}) < len(paths):
        raise InputError(f"{str(paths[-1])!r} is given for two results; give each a name of its own")


def _check_target(path: Path, *, replace: bool) -> None:
    label = repr(str(path))
    if not path.parent.is_dir():
        raise InputError(f"{str(path.parent)!r} is no directory; give a file in one that exists")
    if not path.suffix:
        if _exists(path) and not (path.is_dir() and not any(path.iterdir())):
            raise InputError(f"{label} exists; frames go to a folder that is new or empty, give another name")
    elif path.is_dir():
        raise InputError(f"{label} is a directory; give the name of a file")
    elif _exists(path) and not replace:
        raise InputError(f"{label} exists; give another name, or --replace to replace it")


def _exists(path: Path) -> bool:
    try:
        path.lstat()
    except FileNotFoundError:
        return False
    return True


@contextmanager
def written(paths: Sequence[Path], *, replace: bool) -> Iterator[dict[Path, Path]]:
    """Places beside the targets to write to; all are moved into place when the block ends well, and removed if not.

    ``paths``: as for :func:`check_targets`; ``replace``: whether files that exist may be replaced.

    Yields
    ------
    dict of Path to Path
        For each target the file, not there yet, or the folder, empty, to write to.

    Raises
    ------
    InputError
        A target appeared meanwhile, or the system refuses to write.
    """
    aside = {path: _aside(path) for path in paths}
    try:
        for path, place in aside.items():
            if not path.suffix:
                place.mkdir()
        yield aside
        check_targets(paths, replace=replace)
        for path, place in aside.items():
            place.replace(path)
    except OSError as error:
        place = paths[0] if len(paths) == 1 else paths[0].parent
        raise InputError(unwritable(place, error, "another place")) from error
    finally:
        for place in aside.values():
            with suppress(OSError):
                shutil.rmtree(place) if place.is_dir() else place.unlink(missing_ok=True)


def _aside(path: Path) -> Path:
    return path.with_name(f".lure-{secrets.token_hex(4)}{path.suffix}")
