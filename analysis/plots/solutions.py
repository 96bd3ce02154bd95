"""Simulated solutions of a loop from several first states, on one figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from analysis.plots.style import BLUE, GREEN, GREY, LEGEND, PURPLE, VERMILLION, axes_or_new, finish_axes, number
from lure.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from analysis.refutation.trajectories import Trajectory

_LINES = ((BLUE, "-"), (VERMILLION, (0, (5, 1.5))), (GREEN, (0, (1, 1))), (PURPLE, (0, (4, 1.2, 1, 1.2))))
_UNSEEN = 1e-9  # share of the largest |sigma| of all below which a solution is rounding
_ROOM = 0.5  # of the height of the curves, above them: the legend stands there


def plot_solutions(trajectories: Sequence[Trajectory], *, ax: Axes | None = None) -> Axes:
    """``sigma`` over time for the first few trajectories, each divided by its own largest ``|sigma|``.

    Simulated, hence OBSERVED: what one solution does proves nothing about another.

    Parameters
    ----------
    trajectories : sequence of Trajectory
        Of one loop, such as ``report.trajectories``; at most four are drawn, and none that ``sigma`` hardly shows.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.

    Raises
    ------
    InputError
        There is no trajectory.
    """
    if not trajectories:
        raise InputError("there is no trajectory to draw; give at least one")
    axes = axes_or_new(ax)
    seen_at_all = _UNSEEN * max(map(_largest, trajectories))
    shown = [one for one in trajectories if _largest(one) >= seen_at_all][: len(_LINES)]
    discrete = shown[0].discrete
    for (colour, dashes), one in zip(_LINES, shown, strict=False):
        seen, largest = np.isfinite(one.sigma), _largest(one)
        look: dict[str, Any] = {"marker": ".", "ms": 3, "lw": 0.7} if discrete else {"lw": 1.2}
        label = f"{one.finding}, largest |σ| {number(largest, 3)}"
        axes.plot(one.t[seen], one.sigma[seen] / (largest or 1.0), color=colour, ls=dashes, label=label, **look)
    axes.axhline(0.0, color=GREY, lw=0.6, zorder=1)
    axes.set_ylim(-1.1, 1.1 + _ROOM * 2.2)
    axes.set_yticks([-1, -0.5, 0, 0.5, 1])
    end = max(float(one.t[-1]) for one in shown)
    axes.set_xlim(0.0, end or 1.0)
    axes.set_xlabel("t [s]")
    axes.set_ylabel("σ / largest |σ|")
    finish_axes(axes)
    axes.legend(loc="upper right", **LEGEND)
    return axes


def _largest(one: Trajectory) -> float:
    return float(np.max(np.abs(one.sigma[np.isfinite(one.sigma)]), initial=0.0))
