"""A law that leaves its sector or its slope bounds, with the point where it does."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from analysis.plots.style import BLUE, GREY, LEGEND, VERMILLION, axes_or_new, finish_axes
from analysis.testing.ascii_plot import heights, values_where_defined
from analysis.testing.message import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from analysis.testing.result import Violation

_POINTS = 1201


def plot_violation(violation: Violation, *, ax: Axes | None = None) -> Axes:
    """Draw a law, the lines that bound it and the point or pair at which it breaks what was asserted of it.

    Parameters
    ----------
    violation : Violation
        From a :class:`analysis.testing.LawViolation`.
    ax : matplotlib Axes, optional
        Where to draw; a new figure if not given.

    Returns
    -------
    Axes
        The axes, for further labels.
    """
    axes = axes_or_new(ax)
    low, high = violation.window
    x = np.linspace(low, high, _POINTS)
    phi = values_where_defined(violation, x)
    lines = [y0 + slope * (x - x0) for x0, y0, slope in violation.lines()]
    axes.axhline(0.0, color=GREY, lw=0.6)
    axes.axvline(0.0, color=GREY, lw=0.6)
    allowed = f"[{number(violation.lower)}, {number(violation.upper)}]".replace("inf", "∞")
    what = f"sector {allowed}" if violation.kind == "sector" else f"slopes {allowed}, from the first point"
    if len(lines) == 2:
        axes.fill_between(x, np.minimum(*lines), np.maximum(*lines), color=GREY, alpha=0.2, lw=0, label=what)
    for i, line in enumerate(lines):
        axes.plot(x, line, color=GREY, lw=1.0, ls="--", label=what if len(lines) == 1 and i == 0 else None)
    if violation.kind == "odd":
        axes.plot(x, -values_where_defined(violation, -x), color=GREY, ls="--", lw=1.2, label="−φ(−σ)")
    axes.plot(x, phi, color=BLUE, lw=1.5, label="φ(σ)")
    places = " and ".join(map(number, violation.sigma))
    axes.plot(violation.sigma, violation.phi, "X", color=VERMILLION, ms=8, ls="none", label=f"fails at σ = {places}")
    axes.set_xlim(low, high)
    axes.set_ylim(*heights(violation, phi))
    axes.set_xlabel("σ [unit of σ]")
    axes.set_ylabel("φ [unit of φ]")
    axes.legend(**LEGEND)
    finish_axes(axes)
    return axes
