"""What is proved and refuted in a plane: of the upper bounds of two nonlinearities, or of parameters of the plant."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from lure.analysis.plots.style import BLUE, GREY, VERMILLION, axes_or_new, finish_axes
from lure.analysis.questions.channel_map import StabilityMap
from lure.analysis.questions.margins import Margin, Tolerances

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.patches import Rectangle

    from lure.plants.family import Box

# The map of the upper bounds of two nonlinearities.

_FARTHEST = 1.2  # of the farthest corner that is drawn


def plot_map(found: StabilityMap, *, ax: Axes | None = None) -> Axes:
    """The plane of the upper bounds ``(k1, k2)``: proved, refuted, and hatched what is open.

    Each region is a union of rectangles: a proof for a pair holds for all smaller ones, a counterexample for all
    larger ones.

    Parameters
    ----------
    found : StabilityMap
        The map, such as ``analyse(loop).map``.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.
    """
    axes = axes_or_new(ax)
    proved, refuted = found.proved, found.refuted
    low = [float(v) for v in found.lower]
    ends = []
    for i in range(2):
        asked = float(found.asked[i])
        seen = [asked, *(c[i] for c in refuted)] if refuted else [asked, 4 * asked]
        ends.append(low[i] + _FARTHEST * (_typical(seen) - low[i]))
    x, y = [
        np.unique([low[i], ends[i], *(c[i] for c in (*proved, *refuted) if low[i] < c[i] < ends[i])]) for i in (0, 1)
    ]
    middle = [(axis[:-1] + axis[1:]) / 2 for axis in (x, y)]
    known = np.zeros((len(middle[1]), len(middle[0])))
    for j, b in enumerate(middle[1]):
        for i, a in enumerate(middle[0]):
            known[j, i] = any(a <= c and b <= d for c, d in proved) - any(a >= c and b >= d for c, d in refuted)
    looks = ((1, BLUE, "", "proved"), (0, "white", "////", "open"), (-1, VERMILLION, "xx", "refuted"))
    for value, colour, hatch, label in looks:
        if not (known == value).any():
            continue
        for j, i in zip(*np.nonzero(known == value), strict=True):
            corners = ([x[i], x[i + 1]], y[j], y[j + 1])
            axes.fill_between(*corners, facecolor=colour, alpha=0.75, hatch=hatch, edgecolor=GREY, linewidth=0.0)
        axes.fill_between(
            [], [], [], facecolor=colour, alpha=0.75, hatch=hatch, edgecolor=GREY, linewidth=0.0, label=label
        )
    inside = [float(found.asked[i]) for i in (0, 1)]
    if all(v < end for v, end in zip(inside, ends, strict=True)):
        axes.plot(*inside, "o", color="black", mfc="white", ms=6, label="asked about", zorder=4)
    axes.set_xlim(low[0], ends[0])
    axes.set_ylim(low[1], ends[1])
    return finish_axes(axes, found.bounded[0], found.bounded[1], legend="upper right")


def _typical(seen: list[float]) -> float:
    """The end of an axis: the farthest corner, without those many times as far as the middle one."""
    ordered = sorted(seen)
    most = 4 * ordered[len(ordered) // 2] if ordered[len(ordered) // 2] > 0 else ordered[-1]
    return max(v for v in ordered if v <= most) if most > 0 else 1.0


# Boxes of parameters: what is given, what is proved, and plants that refute.

_ROOM, _LEGEND = 0.12, 0.3


def plot_tolerances(found: Tolerances, *, ax: Axes | None = None) -> Axes:
    """Of two parameters the boxes in their plane, else how wide each interval may be, in widths of the one given.

    Blue is certified for every plant; a red cross is a plant that refutes the class; white is open.

    Parameters
    ----------
    found : Tolerances
        The answer.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.
    """
    axes = axes_or_new(ax)
    (_plane if len(found.family.names) == 2 else _bars)(axes, found)
    return finish_axes(axes, legend="upper right")


def _plane(axes: Axes, found: Tolerances) -> None:
    labelled = False
    for margin in found.margins:
        if margin.proved is not None:
            label = None if labelled else "every plant of it, certified"
            axes.add_patch(_rectangle(margin.proved, facecolor=BLUE, alpha=0.35, lw=0, label=label))
            labelled = True
    points = [[float(v) for v in point] for point in map(_point, found.margins) if point is not None]
    axes.add_patch(_rectangle(found.family.box, fill=False, edgecolor="black", lw=1.4, label="as given"))
    if points:
        axes.plot(*zip(*points, strict=True), "x", color=VERMILLION, mew=1.8, label="a plant that refutes")
    axes.margins(_ROOM)
    axes.autoscale_view()
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + _LEGEND * (top - bottom))
    axes.set_xlabel(found.family.names[0])
    axes.set_ylabel(found.family.names[1])


def _rectangle(box: Box, **look: object) -> Rectangle:
    from matplotlib.patches import Rectangle

    (left, right), (bottom, top) = ([float(end) for end in ends] for ends in box)
    return Rectangle((left, bottom), right - left, top - bottom, **look)  # type: ignore[arg-type]  # as matplotlib has it


def _point(margin: Margin) -> list[Fraction] | None:
    """The parameters of the plant that refutes."""
    return None if margin.refutation is None else [Fraction(v) for v in margin.refutation.certificate["proof"]["at"]]


def _bars(axes: Axes, found: Tolerances) -> None:
    names = [margin.parameters[0] if len(margin.parameters) == 1 else "all" for margin in found.margins]
    for place, margin in enumerate(found.margins):
        label = "every plant, certified" if place == 0 else None
        axes.barh(place, margin.width.low, height=0.5, color=BLUE, alpha=0.6, label=label)
        if math.isfinite(margin.width.high):
            mark = "a plant refutes" if place == 0 else None
            axes.plot(margin.width.high, place, "x", color=VERMILLION, mew=1.8, label=mark)
    axes.axvline(1, color=GREY, lw=1.2, ls="--", label="as given")
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    axes.set_xlabel("width of the interval, times that given")
