"""What a room above adds to the types of one below, such as their drawings: found by name when it is first asked for.

So a result has its plot without importing the plots, and the general part serves the plants of an example that it does
not know.  The top packages write down who serves whom, ``lure/__init__.py`` and ``lure/analysis/__init__.py``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

SERVED: dict[str, dict[str, str]] = {}
"""For each task, ``module:name`` of what does it, by ``module:name`` of the type it does it for."""


def extend(task: str, places: Mapping[str, str]) -> None:
    """Write down who does a task for which types; nothing is imported.

    ``task``: such as ``drawing``; ``places``: ``module:name`` by ``module:name`` of the type.
    """
    SERVED.setdefault(task, {}).update(places)


def extensions(task: str) -> list[Any]:
    """What is registered for a task, of every type, in the order of registration."""
    return [_found(place) for place in dict.fromkeys(SERVED.get(task, {}).values())]


def extension(task: str, served: object) -> Callable[..., Any] | None:
    """What does a task for an object: that of its type or of the nearest base; None where there is none."""
    places = SERVED.get(task, {})
    for kind in type(served).__mro__:
        place = places.get(f"{kind.__module__}:{kind.__qualname__}")
        if place is not None:
            found: Callable[..., Any] = _found(place)
            return found
    return None


def _found(place: str) -> Any:  # noqa: ANN401  (whatever stands there)
    module, name = place.split(":")
    return getattr(import_module(module), name)
