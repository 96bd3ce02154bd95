"""Sweeps of a parameter, and the resting places of the rod."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from analysis.plots.export import INK
from analysis.plots.response import shortened
from analysis.plots.style import BLUE, GREY, LEGEND, VERMILLION, axes_or_new, finish_axes, padded

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from analysis.response import Basin, Bifurcation

_FINE = 16


def plot_bifurcation(bifurcation: Bifurcation, *, ax: Axes | None = None) -> Axes:
    """``z`` at whole periods of the force against the parameter.

    Parameters
    ----------
    bifurcation : Bifurcation
        A sweep; one that was interrupted is drawn as far as it went, over the whole range.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on: values at which transients were not over in grey.
    """
    axes = axes_or_new(ax)
    late = {"still approaching", "still changing"}
    for waiting, colour, label in ((False, BLUE, "whole periods"), (True, GREY, "transients not over")):
        chosen = [point for point in bifurcation.points if (point.trend in late) is waiting]
        if chosen:
            x = np.concatenate([np.full(len(point.poincare), point.value) for point in chosen])
            z = np.concatenate([point.poincare[:, 0] for point in chosen])
            size = 2.2 if len(bifurcation.points) > 100 else 3.0
            axes.plot(x, z, ".", ms=size, mew=0.0, color=colour, label=label, rasterized=x.size > 5000)
    failed = [point.value for point in bifurcation.points if point.problem]
    if failed:
        axes.plot(failed, [0.0] * len(failed), "x", color=VERMILLION, ms=4, label="not followed")
    if axes.get_ylim()[1] > 0.0:
        axes.axhline(0.0, color=VERMILLION, lw=1.0, label="obstacle", zorder=1)
    axes.set_xlim(*padded(min(bifurcation.values), max(bifurcation.values), 0.02))
    axes.set_xlabel(bifurcation.parameter)
    axes.set_ylabel("z at whole periods [m]")
    finish_axes(axes)
    if axes.lines:
        axes.legend(loc="lower left", markerscale=3.0, **LEGEND)
    start = {"separate": "each value from the same start", "up": "swept up", "down": "swept down"}[bifurcation.order]
    axes.set_title(f"g = {shortened(bifurcation.force)}, {start}", fontsize="medium", loc="left")
    return axes


def plot_basin(basin: Basin, *, ax: Axes | None = None) -> Axes:
    """Resting places over the grid of initial data, with the number of impacts as contours.

    Parameters
    ----------
    basin : Basin
        Resting places.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on: upper bounds where the place is not known, marked with a dot.
    """
    axes = axes_or_new(ax)
    x, y = np.array(basin.offsets), np.array(basin.velocities)
    mesh = axes.pcolormesh(x, y, basin.high, cmap="viridis", shading="nearest", rasterized=True)
    bar = axes.figure.colorbar(mesh, ax=axes, pad=0.02, fraction=0.2)
    bar.set_label("resting place z [m]")
    finish_axes(bar.ax)
    lines = min(x.size, y.size) > 1 and basin.impacts.max() > 0
    if lines:
        _impact_lines(axes, basin)
    rows, columns = np.nonzero((basin.impacts >= 0) & ~basin.known)
    if rows.size:
        axes.plot(x[columns], y[rows], ".", ms=2.0, color=VERMILLION, label="upper bound only")
        axes.legend(loc="upper right", **LEGEND)
    said = f"the rod itself, {int(basin.known.sum())} of {basin.known.size} resting places known"
    said += "\nblack lines: the number of impacts changes" if lines else ""
    axes.set_title(said, fontsize="small", loc="left")
    axes.set_xlabel("displacement added to u0 [m]")
    axes.set_ylabel("velocity added to u1 [m/s]")
    finish_axes(axes)
    return axes


def _impact_lines(axes: Axes, basin: Basin) -> None:
    """Lines along the edges of the cells between which the number of impacts changes."""
    ((left, right), (low, high)) = (
        (0.5 * (3 * v[0] - v[1]), 0.5 * (3 * v[-1] - v[-2])) for v in (basin.offsets, basin.velocities)
    )
    fine = np.kron(np.maximum(basin.impacts, 0), np.ones((_FINE, _FINE)))
    rows, columns = fine.shape
    x = left + (right - left) * (np.arange(columns) + 0.5) / columns
    y = low + (high - low) * (np.arange(rows) + 0.5) / rows
    axes.contour(x, y, fine, np.arange(0.5, min(fine.max(), 9.0)), colors=INK, linewidths=0.9)
