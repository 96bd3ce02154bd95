"""The two things the standard library lacks for moving directories: exchanging names in one step, and locking one."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Callable
from pathlib import Path

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
