"""The map of the upper bounds of two nonlinearities."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lure.analysis.plots.style import BLUE, GREY, LEGEND, VERMILLION, axes_or_new, finish_axes
from lure.analysis.questions.channel_map import StabilityMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ROOM = 1.2  # of the farthest corner that is drawn
SIZE = (4.8, 4.2)


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
        ends.append(low[i] + _ROOM * (_typical(seen) - low[i]))
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
    axes.set_xlabel(found.bounded[0])
    axes.set_ylabel(found.bounded[1])
    finish_axes(axes)
    axes.legend(loc="upper right", **LEGEND)
    return axes


def _typical(seen: list[float]) -> float:
    """The end of an axis: the farthest corner, without those many times as far as the middle one."""
    ordered = sorted(seen)
    most = 4 * ordered[len(ordered) // 2] if ordered[len(ordered) // 2] > 0 else ordered[-1]
    return max(v for v in ordered if v <= most) if most > 0 else 1.0
