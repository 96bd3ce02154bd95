"""A directory written aside and moved into place in one step.

At any moment, also after ``kill -9``, the target holds the old results or the new ones or nothing, never a mixture.
Where the system can exchange two names atomically (Linux) the old report is there until the new one is.  Elsewhere the
old one is moved aside first: killed between the two moves, a run leaves no report, and the next moves the old one back.
The hidden directory that holds the new results, and for a moment the old ones, is locked while it is in use.  The lock
dies with its owner, and the next run into the same target removes what is not locked.  Nothing is promised about a loss
of power.
"""

from __future__ import annotations

import errno
import re
import secrets
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from analysis.output.system import exchange, lock
from analysis.output.target import checked_target, unwritable
from lure.errors import InputError

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
