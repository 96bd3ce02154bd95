"""A text file written without overwriting anything by mistake."""

from __future__ import annotations

import os
import secrets
from contextlib import suppress
from pathlib import Path

from lure.errors import InputError


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
    label = repr(str(path))
    if path.is_dir():
        raise InputError(f"{label} is a directory; give the name of a file, such as {str(path / 'rod.toml')!r}")
    if not force and os.path.lexists(path):
        raise InputError(f"{label} exists; give another name, or --force to replace it")
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
