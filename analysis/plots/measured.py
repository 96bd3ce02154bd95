"""Measured data with the mean nonlinearity, its sector, the fitted compliance law, and the residuals below."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lure.analysis.plots.style import (
    BLUE,
    GREEN,
    GREY,
    LEGEND,
    PURPLE,
    VERMILLION,
    axes_or_new,
    finish_axes,
    ink,
    note,
    number,
    padded,
    panels,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes

    from lure.analysis.measured import ComplianceFit, MeasuredSector, Measurements, Outlier

Array = NDArray[np.float64]
SIZE = (6.2, 5.0)
_POINTS = 801
_MANY = 20_000
_SCORES = 6.5
_BELOW = 0.38
_LOADS = {"N": "force", "Pa": "stress", "N m": "torque"}


def plot_measured(
    found: MeasuredSector, *, fit: ComplianceFit | None = None, ax: Axes | None = None
) -> tuple[Axes, Axes]:
    """Data, mean nonlinearity with its band, the wedge of the sector, outliers marked; residuals below.

    Parameters
    ----------
    found : MeasuredSector
        The bounds.
    fit : ComplianceFit, optional
        A fitted nonlinearity to draw too.
    ax : Axes, optional
        Where to draw; by default a new figure.  The place is shared out between it and new axes below it.

    Returns
    -------
    tuple of Axes
        Above and below.  With hysteresis there are two nonlinearities, and loading is told from unloading.
    """
    above, below = panels(ax, _BELOW)
    data, (low, high) = found.measurements, found.domain
    sigma = data.displacement - found.origin
    limits = padded(float(data.load.min()), float(data.load.max()), 0.08)
    x = np.linspace(min(low, 0.0), max(high, 0.0), _POINTS)
    if found.memoryless and (math.isfinite(found.lower.bound) or math.isfinite(found.upper.bound)):
        _wedge(above, x, found, limits)
    rows = [np.arange(len(data))] if found.memoryless else [data.rows("loading"), data.rows("unloading")]
    names = ("mean nonlinearity",) if found.memoryless else ("loading", "unloading")
    colours = (ink(above), PURPLE)
    for nonlinearity, part, name, colour, multiplier in zip(
        found.nonlinearities, rows, names, colours[: len(rows)], found.multipliers, strict=True
    ):
        _points(above, sigma[part], data.load[part], GREY if found.memoryless else colour)
        inside = x[(x >= nonlinearity.knots[0]) & (x <= nonlinearity.knots[-1])]
        mean, error = nonlinearity(inside), multiplier * nonlinearity.error(inside)
        above.fill_between(inside, mean - error, mean + error, color=colour, alpha=0.25, lw=0)
        above.plot(inside, mean, color=colour, lw=1.4, label=name, zorder=3)
        _points(below, sigma[part], nonlinearity.scores, GREY if found.memoryless else colour)
    if fit is not None:
        above.plot(x, fit(x + found.origin), color=GREEN, lw=1.3, ls="--", label="fitted compliance", zorder=3.5)
    places = {o.index: sigma[o.index] for o in found.outliers}
    _outliers(above, below, found.outliers, (np.array(list(places.values())), data.load[list(places)]))
    above.set_ylim(*limits)
    _finish(above, below, (float(x[0]), float(x[-1])), f"σ [{data.displacement_unit}]", data)
    confidence = f"{100 * found.confidence:g} %" if found.stated else "no confidence stated"
    if found.memoryless:
        said = (
            f"{confidence}, if the assumptions hold"
            if found.stated
            else f"{confidence}:\n{found.doubt.partition(',')[0]}"
        )
        note(above, said, corner="lower right")
    else:
        note(above, f"a loop: the element has memory;\n{confidence}", corner="lower right")
    return above, below


def plot_measurements(data: Measurements, *, ax: Axes | None = None) -> Axes:
    """Load against displacement; loading is told from unloading where the rows form branches.

    Parameters
    ----------
    data : Measurements
        The rows.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.
    """
    axes = axes_or_new(ax)
    parts = [("loading", data.rows("loading"), ink(axes)), ("unloading", data.rows("unloading"), PURPLE)]
    for name, rows, colour in parts if data.branches else [("measured", np.arange(len(data)), GREY)]:
        axes.plot([], [], ".", color=colour, label=f"{name}, {rows.size} rows")
        _points(axes, data.displacement[rows], data.load[rows], colour)
    axes.axhline(0.0, color=GREY, lw=0.6, zorder=1)
    return finish_axes(
        axes, f"u [{data.displacement_unit}]", f"{_LOADS.get(data.unit, 'load')} [{data.unit}]", legend="upper left"
    )


def plot_compliance(found: ComplianceFit, *, ax: Axes | None = None) -> tuple[Axes, Axes]:
    """Data, fitted compliance law, the interval of the gap, outliers marked; residuals below.

    Parameters
    ----------
    found : ComplianceFit
        The fit.
    ax : Axes, optional
        Where to draw; by default a new figure.  The place is shared out between it and new axes below it.

    Returns
    -------
    tuple of Axes
        Above and below.
    """
    above, below = panels(ax, _BELOW)
    data, gap = found.measurements, found.parameters["gap"]
    u = data.displacement
    x = np.linspace(float(u.min()), float(u.max()), _POINTS)
    _points(above, u, data.load, GREY)
    above.plot(x, found(x), color=GREEN, lw=1.5, label=f"fit, m = {number(found.parameters['m'].value)}", zorder=3)
    ends = [min(max(end, float(x[0])), float(x[-1])) for end in gap.joint]
    above.axvspan(ends[0], ends[1], color=BLUE, alpha=0.2, lw=0, label="interval of the gap")
    _points(below, u, found.scores, GREY)
    rows = {int(line): i for i, line in enumerate(data.lines)}
    places = [rows[o.line] for o in found.outliers]
    _outliers(above, below, found.outliers, (u[places], data.load[places]))
    above.set_ylim(*padded(float(data.load.min()), float(data.load.max()), 0.08))
    _finish(above, below, (float(x[0]), float(x[-1])), "u [m]", data)
    return above, below


def _wedge(axes: Axes, x: Array, found: MeasuredSector, limits: tuple[float, float]) -> None:
    """The sector between its two lines; an infinite bound reaches to the edge."""
    edges = []
    for bound in (found.lower.bound, found.upper.bound):
        finite = math.isfinite(bound)
        line = bound * x if finite else np.where((x > 0) == (bound > 0), limits[1], limits[0])
        edges.append(np.clip(line, limits[0] - 1, limits[1] + 1))
        if finite:
            unit = found.measurements.stiffness_unit
            axes.plot(x, bound * x, color=BLUE, lw=1.0, label=f"slope {number(bound)} {unit}", zorder=1.5)
    axes.fill_between(x, edges[0], edges[1], color=BLUE, alpha=0.13, lw=0, label="sector", zorder=0.5)


def _points(axes: Axes, x: Array, y: Array, colour: str) -> None:
    every = max(1, x.size // _MANY)
    axes.plot(x[::every], y[::every], ".", color=colour, ms=4.0, alpha=0.6, mew=0, zorder=2, rasterized=x.size > 2000)


def _outliers(above: Axes, below: Axes, outliers: tuple[Outlier, ...], places: tuple[Array, Array]) -> None:
    """Crosses; those whose residual is out of the panel below become triangles at its edge."""
    if not outliers:
        return
    label = "1 outlier" if len(outliers) == 1 else f"{len(outliers)} outliers"
    above.plot(*places, "x", color=VERMILLION, ms=6, mew=1.4, label=label, zorder=4, ls="")
    for x, outlier in zip(places[0], outliers, strict=True):
        edge = abs(outlier.score) > _SCORES
        marker = ("^" if outlier.score > 0 else "v") if edge else "x"
        score = math.copysign(_SCORES - 0.6, outlier.score) if edge else outlier.score
        below.plot([x], [score], marker, color=VERMILLION, ms=5, mew=1.4, zorder=4)


def _finish(above: Axes, below: Axes, ends: tuple[float, float], label: str, data: Measurements) -> None:
    for axes in (above, below):
        axes.axhline(0.0, color=GREY, lw=0.6, zorder=1)
    for level in (-2.0, 2.0):
        below.axhline(level, color=GREY, lw=0.6, ls=":", zorder=1)
    below.set_ylim(-_SCORES, _SCORES)
    below.set_yticks([-4, -2, 0, 2, 4])
    above.set_xlim(*padded(*ends, 0.03))
    above.set_ylabel(f"{_LOADS.get(data.unit, 'load')} [{data.unit}]")
    below.set_ylabel("residual [std. dev.]")
    below.set_xlabel(label)
    above.tick_params(labelbottom=False)
    above.legend(loc="upper left", **LEGEND)
    finish_axes(above)
    finish_axes(below)
    above.xaxis.get_offset_text().set_visible(False)
