"""Names that a package exports and loads only when they are used."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

EXPORT = re.compile(r"^from ([\w.]+) import (\w+) as \2$", re.MULTILINE)


def lazy_exports(package: str, file: str) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]:
    """``__getattr__``, ``__dir__`` and ``__all__`` of a package, as its stub ``__init__.pyi`` lists them.

    The stub is what type checkers read, so that a name and its module are written once.

    ``package``: its ``__name__``; ``file``: its ``__file__``.

    Returns
    -------
    tuple
        The two functions and the list, to be bound to these names.
    """
    exported = EXPORT.findall(Path(file).with_suffix(".pyi").read_text("utf-8"))
    homes = {name: module for module, name in exported if module != package}  # without the packages inside this one

    def attribute(name: str) -> object:
        """The name, from its module; or the package of that name."""
        if name in homes:
            return getattr(import_module(homes[name]), name)
        if name.startswith("_") or find_spec(f"{package}.{name}") is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return import_module(f"{package}.{name}")

    def names() -> list[str]:
        """What the package has and exports."""
        return sorted({*vars(sys.modules[package]), *homes})

    return attribute, names, [*homes]
