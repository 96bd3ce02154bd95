"""The names listed on a reference page, by group, and the objects behind them."""

from __future__ import annotations

import functools
import importlib
import inspect
import re
from collections.abc import Iterable
from pathlib import Path


def groups(lines: Iterable[str]) -> list[tuple[str, list[str]]]:
    """The groups of an ``api`` directive: a title at the margin, its names indented below it.

    Parameters
    ----------
    lines : iterable of str
        The content of the directive.

    Raises
    ------
    ValueError
        A name stands before the first title.
    """
    found: list[tuple[str, list[str]]] = []
    for line in lines:
        if not line.strip():
            continue
        if not line[0].isspace():
            found.append((line.strip(), []))
        elif found:
            found[-1][1].append(line.strip())
        else:
            raise ValueError(f"{line.strip()} stands before the first title")
    return found


def resolved(path: str) -> object:
    """The object at a dotted path, through modules and then attributes.

    Parameters
    ----------
    path : str
        Such as ``lure.LinearPlant`` or ``lure.Expression.parse``.

    Raises
    ------
    LookupError
        There is no such object.
    """
    parts = path.split(".")
    if not all(part.isidentifier() for part in parts):
        raise LookupError(f"{path} is no path")
    for count in (*range(len(parts) - 1, 0, -1), len(parts)):  # a function before a module of its name
        try:
            found: object = importlib.import_module(".".join(parts[:count]))
            for attribute in parts[count:]:
                found = getattr(found, attribute)
        except (ModuleNotFoundError, AttributeError):
            continue
        return found
    raise LookupError(f"there is no {path}")


def kind(found: object) -> str:
    """What autodoc calls an object: ``exception``, ``class``, ``function`` or ``data``.

    Parameters
    ----------
    found : object
        The object.
    """
    if inspect.isclass(found):
        return "exception" if issubclass(found, BaseException) else "class"
    return "function" if inspect.isroutine(found) else "data"


def home(found: object) -> str | None:
    """Where an object is defined, ``lure.classes.Sector``; None for what does not know it.

    Parameters
    ----------
    found : object
        The object.
    """
    module, name = getattr(found, "__module__", None), getattr(found, "__qualname__", None)
    return f"{module}.{name}" if isinstance(module, str) and isinstance(name, str) else None


@functools.cache
def listed() -> frozenset[str | None]:
    """Where everything is defined that some reference page has an entry for."""
    pages = (Path(__file__).parents[2] / "reference").glob("*.rst")
    names = (re.findall(r"^ {6}(lure\.[\w.]+)$", page.read_text("utf-8"), re.MULTILINE) for page in pages)
    return frozenset(home(resolved(name)) for found in names for name in found)
