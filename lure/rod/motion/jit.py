"""Compilation by numba, where it is installed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """The function compiled with the one that calls it; the function itself without numba."""
    try:
        from numba import njit
    except ImportError:
        return function
    made: Any = njit(error_model="numpy")(function)
    return cast(F, made)


def inlined(function: F) -> F:
    """The function compiled into each place where it is called; the function itself without numba."""
    try:
        from numba import njit
    except ImportError:
        return function
    made: Any = njit(error_model="numpy", forceinline=True)(function)
    return cast(F, made)


def kept(function: F) -> F:
    """The function compiled at its first call, with all it calls, and kept on disk; itself without numba."""
    try:
        from numba import njit
    except ImportError:
        return function
    try:
        made: Any = njit(cache=True, error_model="numpy")(function)
    except RuntimeError:  # there is no place on disk to keep it
        made = njit(error_model="numpy")(function)
    forget_old(on_disk(made))
    return cast(F, made)


def plain(function: F) -> F:
    """The function as it was written."""
    return cast(F, getattr(function, "py_func", function))


def on_disk(function: Callable[..., object]) -> list[Path]:
    """Index files of what earlier processes compiled."""
    place = getattr(getattr(function, "stats", None), "cache_path", None)
    return list(Path(str(place)).glob(f"*.{function.__name__}-*.nbi")) if place else []


def forget_old(indices: list[Path]) -> None:
    """Remove what was compiled before a part of the engine changed: numba looks at the file of the function only."""
    newest = max(path.stat().st_mtime for path in Path(__file__).parent.glob("kernel_*.py"))
    for path in indices:
        if path.stat().st_mtime < newest:
            path.unlink(missing_ok=True)
