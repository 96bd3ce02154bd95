"""Names that a package hands out and loads only when they are used."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module


def handing_out(package: str, homes: Mapping[str, str]) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """``__getattr__`` and ``__dir__`` of a package whose names live in modules inside it.

    Parameters
    ----------
    package : str
        Its ``__name__``.
    homes : Mapping
        The module of each name, relative to the package.

    Returns
    -------
    tuple of callable
        The two functions, to be bound to these names.
    """

    def attribute(name: str) -> object:
        """The name, from its module."""
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f"{package}.{homes[name]}"), name)

    def names() -> list[str]:
        """What the package has and hands out."""
        return sorted({*vars(sys.modules[package]), *homes})

    return attribute, names
