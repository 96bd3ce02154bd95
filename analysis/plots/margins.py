"""Boxes of parameters: what is given, what is proved, and plants that refute."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING

from lure.analysis.plots.style import BLUE, GREY, LEGEND, VERMILLION, axes_or_new, finish_axes
from lure.analysis.questions.margins import Margin, Tolerances

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.patches import Rectangle

    from lure.plants.family import Box

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
    finish_axes(axes)
    axes.legend(loc="upper right", **LEGEND)
    return axes


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
