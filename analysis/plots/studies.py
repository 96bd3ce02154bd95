"""Figures of a data set with many points: the verdict of each, and a variable in colours or as a curve."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lure.analysis.plots.style import BLUE, GREY, LEGEND, VERMILLION, axes_or_new, finish_axes

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

LOOKS = (("PROVED", BLUE, "o"), ("INCONCLUSIVE", GREY, "s"), ("REFUTED", VERMILLION, "x"))


class Plane(NamedTuple):
    """What is drawn against one or two dimensions: a slice of the data set, and where it was cut."""

    data: xarray.Dataset
    along: tuple[str, ...]
    cut: str


def planes(data: xarray.Dataset) -> Iterator[Plane]:
    """The slices that are drawn: for each question, along the two longest dimensions, the others in their middle.

    Parameters
    ----------
    data : Dataset
        The data set of a store.
    """
    questions = list(data["question"].values) if "question" in data.dims else [None]
    for question in questions:
        part = data if question is None else data.sel(question=question)
        sizes = {str(name): int(size) for name, size in part["verdict"].sizes.items()}
        along = tuple(sorted(sorted(sizes, key=lambda name: -sizes[name])[:2], key=list(sizes).index))
        cut = {name: size // 2 for name, size in sizes.items() if name not in along}
        said = [f"{name} = {part[name].values[place]}" for name, place in cut.items()]
        said += [] if question is None else [f"asked: {question}"]
        yield Plane(part.isel(cut), along, ", ".join(said))


def verdicts_drawn(plane: Plane, *, ax: Axes | None = None) -> Axes:
    """The verdict of each point: along two dimensions as a map, else against the number of the point.

    Parameters
    ----------
    plane : Plane
        What is drawn.
    ax : Axes, optional
        Where; by default a new figure.
    """
    axes = axes_or_new(ax)
    verdicts = plane.data["verdict"]
    x, y = _coordinates(plane)
    flat = verdicts.values.ravel()
    for name, colour, marker in LOOKS:
        chosen = flat == name
        if chosen.any():
            axes.plot(x[chosen], y[chosen], marker, color=colour, ms=3, label=name.lower(), rasterized=flat.size > 2000)
    _labelled(axes, plane, x, y)
    axes.legend(loc="upper left", **LEGEND)
    return axes


def values_drawn(plane: Plane, name: str, *, ax: Axes | None = None) -> Axes:
    """One variable: along two dimensions as colours, along one as a curve.

    Parameters
    ----------
    plane : Plane
        What is drawn.
    name : str
        The variable.
    ax : Axes, optional
        Where; by default a new figure.
    """
    axes = axes_or_new(ax)
    values = np.asarray(plane.data[name].values, dtype=float)
    label = f"{name} [{plane.data[name].attrs.get('units', '1')}]"
    x, y = _coordinates(plane)
    if len(plane.along) == 2 or drawn_keys(plane.data):
        finite = np.isfinite(values.ravel())
        found = axes.scatter(x[finite], y[finite], c=values.ravel()[finite], s=9, cmap="cividis", rasterized=True)
        axes.figure.colorbar(found, ax=axes, label=label)
        _labelled(axes, plane, x, y)
        return axes
    axes.plot(x, values.ravel(), ".-", color=BLUE, ms=3)
    _labelled(axes, plane, x, np.array([]))
    axes.set_ylabel(label)
    return axes


def drawn_keys(data: xarray.Dataset) -> list[str]:
    """The keys whose values were drawn; empty for a grid.

    Parameters
    ----------
    data : Dataset
        The data set of a store.
    """
    return [str(name) for name in data.coords if data[name].dims == ("sample",) and name != "sample"]


def _names(plane: Plane) -> list[str]:
    return drawn_keys(plane.data)[:2] or list(plane.along)


def _coordinates(plane: Plane) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Where each point stands, the second 0 where there is one dimension."""
    names = _names(plane)
    if drawn_keys(plane.data):
        columns = [np.asarray(plane.data[name].values, dtype=float) for name in names]
    else:
        grids = [_numbers(plane.data[name].values) for name in names]
        columns = [each.ravel() for each in np.meshgrid(*grids, indexing="ij")]
    return columns[0], columns[1] if len(columns) > 1 else np.zeros(len(columns[0]))


def _numbers(values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    return values.astype(float) if values.dtype.kind in "if" else np.arange(len(values), dtype=float)


def _labelled(axes: Axes, plane: Plane, x: np.ndarray[Any, Any], y: np.ndarray[Any, Any]) -> None:
    names = _names(plane)
    for values, scale, label, name in (
        (x, axes.set_xscale, axes.set_xlabel, names[0]),
        (y, axes.set_yscale, axes.set_ylabel, names[1] if len(names) > 1 else ""),
    ):
        positive = values[values > 0]
        if len(positive) == len(values) > 0 and positive.max() > 50 * positive.min():
            scale("log")
        label(name)
    if len(names) == 1:
        axes.set_yticks([])
    finish_axes(axes)
