"""Figures of a data set with many points: verdict and criterion as maps, a variable in colours with its contours."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lure.analysis.plots.style import BLUE, GREEN, GREY, LEGEND, PURPLE, VERMILLION, axes_or_new, finish_axes

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection
    from matplotlib.colors import Normalize

LOOKS = (("PROVED", BLUE, "o"), ("INCONCLUSIVE", "#c8c8c8", "s"), ("REFUTED", VERMILLION, "x"))
_FAILED = ("failed", PURPLE, "+")
_CRITERIA = (BLUE, VERMILLION, GREEN, PURPLE, GREY, "#e69f00", "#56b4e9", "#111111")
_MANY = 200  # from so many values on colours leave the largest hundredth out
FILLED = 2000  # from so many points on a map has cells in place of marks
_FEW = 400  # up to so many points have large marks
_ENDLESS = "#c8c8c8"
_LEVELS = 4
_WORDS, _LONGEST_WORD = 7, 16  # along an axis whose values are no numbers


class Plane(NamedTuple):
    """What is drawn against one or two dimensions: a slice of the data set, and where it was cut."""

    data: xarray.Dataset
    along: tuple[str, ...]
    cut: str


def planes(data: xarray.Dataset) -> Iterator[Plane]:
    """The slices that are drawn: for each question, along the two longest dimensions.

    The others are in their middle; and, one after the other, at both ends.

    ``data``: the data set of a store.
    """
    for question in list(data["question"].values) if "question" in data.dims else [None]:
        part = data if question is None else data.sel(question=question)
        sizes = {str(name): int(size) for name, size in part["verdict"].sizes.items()}
        along = tuple(sorted(sorted(sizes, key=lambda name: -sizes[name])[:2], key=list(sizes).index))
        middle = {name: size // 2 for name, size in sizes.items() if name not in along}
        ends = [middle | {name: end} for name in middle for end in (0, sizes[name] - 1) if end != middle[name]]
        for cut in (middle, *ends):
            said = [f"{name} = {_place(part, name, place)}" for name, place in cut.items()]
            said += [] if question is None else [f"asked: {question}"]
            yield Plane(part.isel(cut), along, ", ".join(said))


def curve(plane: Plane) -> Plane:
    """The slice along the longer dimension of a plane, through the middle of the other.

    ``plane``: with two dimensions.
    """
    sizes = [plane.data.sizes[name] for name in plane.along]
    kept, other = plane.along if sizes[0] >= sizes[1] else plane.along[::-1]
    place = plane.data.sizes[other] // 2
    said = f"{other} = {_place(plane.data, other, place)}"
    return Plane(plane.data.isel({other: place}), (kept,), ", ".join(filter(None, (said, plane.cut))))


def verdicts_drawn(plane: Plane, more: Sequence[xarray.Dataset] = (), *, ax: Axes | None = None) -> Axes:
    """The verdict of each point: along two dimensions as a map, else against the number of the point.

    Only along boxes a colour covers what was asked; between two points, or two bars of boxes, nothing was.

    Parameters
    ----------
    plane : Plane
        What is drawn.
    more : sequence of Dataset
        Points that were put where the verdict changes, drawn over it.
    ax : Axes, optional
        Where; by default a new figure.
    """
    axes = axes_or_new(ax)
    verdicts = plane.data["verdict"].values
    x, y = _coordinates(plane)
    looks = [(name.lower(), colour, marker, verdicts == name) for name, colour, marker in LOOKS]
    looks.append((*_FAILED, (verdicts == "") & (plane.data["error"].values != "")))
    if _is_map(plane):
        _cells(axes, plane, [(name, colour, chosen) for name, colour, _, chosen in looks])
    else:
        few = verdicts.size <= FILLED
        for name, colour, marker, chosen in looks:
            at = chosen.ravel()
            if at.any():
                axes.plot(x[at], y[at], marker, color=colour, label=name, ms=3, rasterized=not few)
    for data in more if len(_names(plane)) == 2 else ():
        a, b = (np.asarray(data[name].values, dtype=float) for name in _names(plane))
        for name, colour, marker in LOOKS:
            chosen = data["verdict"].values.ravel() == name
            axes.plot(
                a[chosen], b[chosen], marker, color=colour, ms=2.5, mec="white" if marker != "x" else None, mew=0.4
            )
    _labelled(axes, plane, x, y)
    _legend(axes)
    return axes


def criteria_drawn(plane: Plane, *, ax: Axes | None = None) -> Axes:
    """The theorem behind the verdict of each point of a map.

    ``plane``: with two dimensions.  ``ax``: where; by default a new figure.
    """
    axes = axes_or_new(ax)
    criteria, proved = plane.data["criterion"].values, plane.data["verdict"].values == "PROVED"
    names = sorted({str(name) for name in criteria[proved].ravel()})
    looks = zip(names, _CRITERIA * (1 + len(names) // len(_CRITERIA)), strict=False)
    classes = [(name, colour, proved & (criteria == name)) for name, colour in looks]
    if _is_map(plane):
        _cells(axes, plane, classes)
    else:
        x, y = _coordinates(plane)
        for name, colour, chosen in classes:
            axes.plot(x[chosen.ravel()], y[chosen.ravel()], "o", color=colour, label=name, ms=3)
    _labelled(axes, plane, *_coordinates(plane))
    _legend(axes)
    return axes


def values_drawn(plane: Plane, name: str, *, ax: Axes | None = None) -> Axes:
    """One variable: along two dimensions as colours, of many points or boxes with contours, along one as points.

    Values that are infinite, such as the largest sector where every finite one is proved, are marked as such.

    ``ax``: where; by default a new figure.
    """
    axes = axes_or_new(ax)
    values = np.asarray(plane.data[name].values, dtype=float)
    label = _with_unit(plane.data, name)
    x, y = _coordinates(plane)
    finite, endless = np.isfinite(values.ravel()), np.isposinf(values.ravel())
    if len(plane.along) == 2 and len(_boxed(plane)) == 1:
        known = values.ravel()[finite]
        bars = _bars(axes, plane, finite, array=known, cmap="cividis", norm=_scale(known))
        if endless.any():
            _bars(axes, plane, endless, colors=_fixed(_ENDLESS), label="inf")
        _colour_bar(axes, bars, label)
    elif _is_map(plane):
        if endless.any():
            _cells(axes, plane, [("inf", _ENDLESS, np.isposinf(values))])
        shown = np.ma.masked_invalid(values.T)
        scale = _scale(values[np.isfinite(values)])
        edges = [_edges_of(plane, each) for each in plane.along]
        found = axes.pcolormesh(*edges, shown, cmap="cividis", norm=scale, rasterized=True)
        if values.size >= FILLED and min(shown.shape) > 2:
            lines = axes.contour(
                *(_numbers(plane.data[each].values) for each in plane.along),
                shown,
                levels=_levels(scale),
                colors=_fixed("#ffffff"),
                linewidths=0.8,
            )
            axes.clabel(lines, fontsize=7, fmt="%.3g")
        _colour_bar(axes, found, label)
    elif len(plane.along) == 2 or drawn_keys(plane.data):
        known = values.ravel()[finite]
        size = 9 if values.size > _FEW else 30
        rim = GREY if size > 9 else "face"  # so that the darkest is seen on a dark page
        at = (x[finite], y[finite])
        marks = axes.scatter(*at, size, known, cmap="cividis", norm=_scale(known), edgecolors=rim, rasterized=True)
        if endless.any():
            axes.plot(x[endless], y[endless], "o", mfc="none", color=GREY, ms=math.sqrt(size), label="inf")
        _colour_bar(axes, marks, label)
    else:
        axes.plot(x, values.ravel(), ".", color=BLUE, ms=3 if values.size > _FEW else 6)
        if _is_log(values.ravel()[finite]):
            axes.set_yscale("log")
        top, above = np.ones(int(endless.sum())), axes.get_xaxis_transform()
        axes.plot(x[endless], top, "^", color=GREY, ms=4, label="inf", transform=above, clip_on=False)
        y = np.array([])
    _labelled(axes, plane, x, y)
    if len(_names(plane)) == 1:
        axes.set_ylabel(label)
    if endless.any():
        _legend(axes)
    return axes


def covered(plane: Plane) -> str:
    """What a colour of a map covers, and what it leaves open, as a sentence; empty where there is no map.

    ``plane``: what is drawn.
    """
    boxes = _boxed(plane)
    if boxes and len(plane.along) == 1:
        return f"Each mark is about a whole interval of {boxes[0]}, at whose middle it stands."
    if len(plane.along) < 2 or len(boxes) == 2:
        return ""
    if boxes:
        point = next(name for name in plane.along if name not in boxes)
        return f"Each bar is one interval of {boxes[0]} at one value of {point}: nothing is said of what lies between."
    return "Each colour is the answer at one point: nothing is said of what lies between."


def drawn_keys(data: xarray.Dataset) -> list[str]:
    """The keys whose values were drawn; empty for a grid.

    ``data``: the data set of a store.
    """
    return [str(name) for name in data.coords if data[name].dims == ("sample",) and name != "sample"]


def _colour_bar(axes: Axes, drawn: ScalarMappable, label: str) -> None:
    """Beside the axes, with room for its label."""
    _roomy(axes)
    values: np.ndarray[Any, Any] = np.ma.asarray(drawn.get_array()).compressed()
    axes.figure.colorbar(drawn, ax=axes, label=label, extend="max" if (values > drawn.norm.vmax).any() else "neither")


def _roomy(axes: Axes) -> None:
    """Room for what stands beside axes that are the only ones of their figure."""
    if len(axes.figure.axes) == 1 and axes.figure.get_layout_engine() is None:
        axes.figure.set_layout_engine("constrained")  # type: ignore[union-attr]  # no SubFigure is drawn on


def _legend(axes: Axes) -> None:
    """Above the map, which is full."""
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, handletextpad=0.2, **LEGEND)


def _place(data: xarray.Dataset, name: str, place: int) -> str:
    """The value at a place of a dimension, or the interval there."""
    if f"{name} bounds" in data:
        return f"[{', '.join(_short(float(end)) for end in data[f'{name} bounds'].values[place])}]"
    return _short(data[name].values[place])


def _with_unit(data: xarray.Dataset, name: str) -> str:
    unit = data[name].attrs.get("units", "1")
    return name if unit in ("1", "-") else f"{name} [{unit}]"


def _short(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _is_map(plane: Plane) -> bool:
    """Whether a plane is filled with cells: one with two dimensions that has many points, or boxes for points."""
    return len(plane.along) == 2 and (plane.data["verdict"].size >= FILLED or bool(_boxed(plane)))


def _boxed(plane: Plane) -> list[str]:
    """The dimensions that were cut into boxes."""
    return [name for name in plane.along if f"{name} bounds" in plane.data]


def _bars(axes: Axes, plane: Plane, chosen: np.ndarray[Any, Any], **look: Any) -> LineCollection:  # noqa: ANN401  (for matplotlib)
    """Of one dimension with boxes and one with points: thin bars along the boxes, each at its point."""
    from matplotlib.patheffects import withStroke

    boxes = _boxed(plane)[0]
    first = plane.along[0] == boxes
    low, high = np.asarray(plane.data[f"{boxes} bounds"].values, dtype=float).T
    at = _numbers(plane.data[plane.along[first]].values)
    grids = [np.meshgrid(*((ends, at) if first else (at, ends)), indexing="ij") for ends in (low, high)]
    start, end = (grid[not first].ravel()[chosen] for grid in grids)
    lines, width = axes.hlines if first else axes.vlines, max(min(4.0, 80 / len(at)), 0.2)
    rim = [withStroke(linewidth=1.25 * width, foreground=GREY)]  # so that the darkest is seen on a dark page
    return lines(grids[0][first].ravel()[chosen], start, end, linewidth=width, path_effects=rim, **look)


def _cells(axes: Axes, plane: Plane, classes: Sequence[tuple[str, str, np.ndarray[Any, Any]]]) -> None:
    """The cells of each class in its colour, and a legend entry for those that there are."""
    from matplotlib.colors import ListedColormap

    classes = [(name, _fixed(colour), chosen) for name, colour, chosen in classes]
    if len(_boxed(plane)) == 1:
        for name, colour, chosen in classes:
            if chosen.any():
                _bars(axes, plane, chosen.ravel(), colors=colour, label=name)
        return
    kind = np.full(classes[0][2].shape, np.nan)
    for number, (name, colour, chosen) in enumerate(classes):
        kind[chosen] = number
        if chosen.any():
            axes.plot([], [], "s", color=colour, label=name)
    edges = [_edges_of(plane, each) for each in plane.along]
    colours = ListedColormap([colour for _, colour, _ in classes])
    shown = np.ma.masked_invalid(kind.T)
    axes.pcolormesh(*edges, shown, cmap=colours, vmin=-0.5, vmax=len(classes) - 0.5, rasterized=True)


def _fixed(colour: str) -> str:
    """The colour, told apart by no eye, that a dark page does not change, as it leaves a picture what it is."""
    return f"#{int(colour[1:], 16) ^ 1:06x}"


def _edges_of(plane: Plane, name: str) -> np.ndarray[Any, Any]:
    """The ends of the cells along a dimension: those of the boxes, where it was cut into boxes."""
    bounds = f"{name} bounds"
    if bounds in plane.data:
        both = np.asarray(plane.data[bounds].values, dtype=float)
        return np.append(both[:, 0], both[-1, 1])
    return _edges(_numbers(plane.data[name].values))


def _edges(values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """The ends of the cells about ascending or descending values: halfway, on a scale of logarithms where they are.

    The first and the last cell end at their values, beyond which nothing was asked.
    """
    if len(values) == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    log = _is_log(values)
    at = np.log(values) if log else values
    middle = (at[1:] + at[:-1]) / 2
    whole = np.concatenate([at[:1], middle, at[-1:]])
    return np.exp(whole) if log else whole


def _is_log(values: np.ndarray[Any, Any]) -> bool:
    """Whether values of one sign spread over more than a decade and a half."""
    positive = values[values > 0]
    return len(positive) == len(values) > 0 and bool(positive.max() > 50 * positive.min())


def _scale(values: np.ndarray[Any, Any]) -> Normalize:
    """Of the colours: up to what all but a hundredth of the values reach, where the largest are ten times that."""
    from matplotlib.colors import LogNorm, Normalize

    if not values.size:
        return Normalize()
    low, most, high = (float(end) for end in np.quantile(values, [0.0, 0.99, 1.0], method="lower"))
    top = most if values.size >= _MANY and max(low, 0.0) < most < high / 10 else high
    return LogNorm(low, top) if _is_log(values[values <= top]) else Normalize(low, top)


def _levels(scale: Normalize) -> list[float]:
    """Round numbers between the ends of a scale that has them."""
    from matplotlib.colors import LogNorm
    from matplotlib.ticker import LogLocator, MaxNLocator

    low, high = scale.vmin or 0.0, scale.vmax or 0.0
    ticks = LogLocator(numticks=_LEVELS) if isinstance(scale, LogNorm) else MaxNLocator(_LEVELS)
    return [float(each) for each in ticks.tick_values(low, high) if low < each < high] or [(low + high) / 2]


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
        if _is_log(values):
            scale("log")
        label(_with_unit(plane.data, name) if name else "")
    if len(names) == 1 and len(y):
        axes.set_yticks([])
    finish_axes(axes)
    for name, axis in zip(names, (axes.xaxis, axes.yaxis), strict=False):
        values = plane.data[name].values
        if values.dtype.kind not in "if":
            _worded(axis, [str(each) for each in values])


def _worded(axis: Axis, words: Sequence[str]) -> None:
    """Ticks with words in place of numbers, as many as have room, the beginning of those that are long."""
    from matplotlib.ticker import NullLocator

    places = range(0, len(words), -(-len(words) // _WORDS))
    shown = [each if len(each) <= _LONGEST_WORD else f"{each[: _LONGEST_WORD - 1]}…" for each in words]
    axis.set_ticks(list(places), [shown[i] for i in places])
    axis.set_minor_locator(NullLocator())
    if axis is axis.axes.xaxis and sum(len(shown[i]) for i in places) > 2 * _LONGEST_WORD:
        for each in axis.get_ticklabels():
            each.set(rotation=20, ha="right")
    _roomy(axis.axes)
