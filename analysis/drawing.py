"""Drawings as a result sees them: it asks for its own, and imports neither the plots nor matplotlib."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

from lure.extensions import extension

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes


class Draw(Protocol):
    """A plot function with its results bound, e.g. ``partial(plot_spectrum, scheme)``."""

    def __call__(self, *, ax: Axes) -> object:
        """Draw on ``ax``."""


def drawing(of: object, *, task: str = "drawing") -> Callable[..., Any]:
    """The function that draws a result, or does another task of a drawing for it.

    ``task``: ``drawing``, or ``file`` for a picture of what a :class:`Draw` draws.

    Raises
    ------
    TypeError
        No room says how to draw it.
    """
    found = extension(task, of)
    if found is None:
        raise TypeError(f"there is no {task} of a {type(of).__name__}")
    return found


def drawn(says: str) -> Callable[..., Any]:
    """The method ``plot`` of a result: it draws by the function that is registered for its type.

    ``says``: what is drawn, the first line of its docstring.
    """

    def plot(self: object, ax: Axes | None = None) -> Any:  # noqa: ANN401  (the axes, or all of them)
        """Replaced by the text below."""
        return drawing(self)(self, ax=ax)

    plot.__doc__ = (
        f"{says}\n\nParameters\n----------\nax : Axes, optional\n    Where to draw; by default a new figure.\n"
    )
    return plot
