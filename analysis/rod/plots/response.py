"""Sweeps of a parameter, and the resting places of the rod."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lure.analysis.plots.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    LEGEND,
    VERMILLION,
    axes_or_new,
    finish_axes,
    note,
    number,
    padded,
)
from lure.analysis.rod.plots.run import shade
from lure.arrays import Reals as Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lure.analysis.rod.response import Basin, Bifurcation, Response

# Long runs: the watched motion, its stroboscopic points, spectrum and impacts.

_SHOWN = 6
_DECADES = 6
_FEW = 12
_LONGEST = 44
_SIZE, _PLACE = (9.6, 7.2), (0.17, 0.12, 0.8, 0.8)


def plot_response(response: Response, *, ax: Axes | None = None) -> Axes:
    """All four figures of a long run, as insets of the axes.

    Parameters
    ----------
    response : Response
        A long run.
    ax : Axes, optional
        Where to draw; by default a new figure with room for all four.

    Returns
    -------
    Axes
        The axes drawn on, themselves invisible.
    """
    axes = _page() if ax is None else ax
    axes.set_axis_off()
    width, height = 0.47, 0.42
    for draw, (left, bottom) in (
        (plot_history, (-0.1, 0.58)),
        (plot_poincare, (0.53, 0.58)),
        (plot_response_spectrum, (-0.1, -0.04)),
        (plot_impulses, (0.53, -0.04)),
    ):
        draw(response, ax=axes.inset_axes((left, bottom, width, height)))
    return axes


def _page() -> Axes:
    """The axes of a new figure with room for four."""
    from matplotlib import pyplot

    return pyplot.figure(figsize=_SIZE).add_axes(_PLACE)


def plot_history(response: Response, *, ax: Axes | None = None) -> Axes:
    """Contact coordinate over the last periods watched, contact shaded, with the force on an axis of its own.

    Parameters
    ----------
    response : Response
        A long run.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on; a twin on the right shows the force.
    """
    axes = axes_or_new(ax)
    periods = min(len(response.poincare) - 1, max(_SHOWN, 2 * (response.regime.multiple or 1)))
    first = response.t.size - 1 - periods * response.plan.samples
    t, z = response.t[first:] / response.period, response.z[first:]
    spans = [(max(a / response.period, t[0]), b / response.period) for a, b in response.contacts]
    shade(axes, [(a, b) for a, b in spans if b > a], "contact", height=0.66)
    axes.plot(t, z, color=BLUE, lw=1.2, label="z = u(t, L) − gap")
    strobe = slice(None, None, response.plan.samples)
    axes.plot(t[strobe], z[strobe], "o", ms=3.5, mfc="white", color=BLUE, label="whole periods")
    if z.max() + np.ptp(z) > 0.0:
        axes.axhline(0.0, color=VERMILLION, lw=0.8)
    low, high = padded(float(z.min()), float(z.max()), 0.05)
    axes.set_ylim(low, low + (high - low) / 0.64)
    axes.set_xlim(float(t[0]), float(t[-1]))
    finish_axes(axes, f"t / period of {number(response.period)} s", "z [m]")
    axes.set_yticks([tick for tick in axes.get_yticks() if low <= tick <= high])
    _force(axes, response, t)
    axes.set_title(f"g = {shortened(str(response.scenario.force))}", fontsize="medium", loc="left")
    axes.legend(loc="upper left", ncols=2, columnspacing=1.0, labelspacing=0.2, **LEGEND)
    return axes


def _force(axes: Axes, response: Response, t: Array) -> None:
    """The force in a band above the motion, with its least and largest value at the right."""
    fine = np.linspace(float(t[0]), float(t[-1]), 1500)
    force = response.scenario.force(t=fine * response.period)
    least, largest = float(force.min()), float(force.max())
    low, high = axes.get_ylim()
    share = 0.69 + 0.13 * (force - least) / ((largest - least) or 1.0)
    axes.plot(fine, low + share * (high - low), color=GREY, lw=0.9, ls="--", label="force g [N]")
    for value, level in {least: 0.69, largest: 0.69 + 0.13 * (largest > least)}.items():
        label = axes.text(0.995, level, number(value, 3), transform=axes.transAxes, ha="right", va="center")
        label.set(color=GREY, size="small", bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 0.5})


def plot_poincare(response: Response, *, ax: Axes | None = None) -> Axes:
    """Points ``(z, z')`` at whole periods of the force.

    Parameters
    ----------
    response : Response
        A long run.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on, with the orbit between the points in grey if the motion repeats.
    """
    axes = axes_or_new(ax)
    multiple = response.regime.multiple
    points = response.poincare
    if multiple is not None and response.regime.kind == "periodic":
        last = slice(response.t.size - 1 - multiple * response.plan.samples, None)
        axes.plot(response.z[last], response.v[last], color=GREY, lw=0.8, label="orbit")
        points = points[-min(response.regime.seen, len(points)) :]
    axes.plot(points[:, 0], points[:, 1], "o", ms=4 if len(points) < 400 else 1.5, color=BLUE, label="whole periods")
    if axes.get_xlim()[1] > 0.0:
        axes.axvline(0.0, color=VERMILLION, lw=1.0, label="obstacle")
    finish_axes(axes, "z [m]", "z′ [m/s]", legend="best")
    axes.set_title(_kind(response), fontsize="medium", loc="left")
    return axes


def plot_response_spectrum(response: Response, *, ax: Axes | None = None) -> Axes:
    """Amplitudes of ``z`` against frequency in multiples of that of the force.

    Parameters
    ----------
    response : Response
        A long run.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on: lines for a motion that repeats, a curve for one that does not.
    """
    axes = axes_or_new(ax)
    found = response.spectrum
    order = found.frequency[1:] * response.period
    amplitude = found.amplitude[1:]
    top = float(amplitude.max(initial=0.0)) or 1.0
    shown = order <= _FEW
    floor = top * 10.0**-_DECADES
    if response.regime.kind in ("periodic", "rest"):
        kept = shown & (amplitude > floor)
        axes.vlines(order[kept], floor, amplitude[kept], color=BLUE, lw=1.2)
        whole = kept & (np.abs(order - np.round(order)) < 1e-9)
        axes.plot(order[kept], amplitude[kept], "o", ms=3, mfc="white", color=BLUE, label="between harmonics")
        axes.plot(order[whole], amplitude[whole], "o", ms=3.5, color=BLUE, label="harmonics of the force")
    else:
        axes.plot(order[shown], np.maximum(amplitude[shown], floor), color=BLUE, lw=0.9, label="Hann window")
    axes.set_yscale("log")
    axes.set_ylim(floor, 3.0 * top)
    axes.set_xlim(0.0, _FEW + 0.3)
    return finish_axes(axes, "frequency / frequency of the force", "amplitude of z [m]", legend="upper right")


def plot_impulses(response: Response, *, ax: Axes | None = None) -> Axes:
    """Histogram of the impulses of the impacts that begin and end during the watch.

    Parameters
    ----------
    response : Response
        A long run.
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    from matplotlib.ticker import MaxNLocator

    axes = axes_or_new(ax)
    found = response.impact_impulses
    axes.set_xlabel("impulse of an impact [N s]")
    axes.set_ylabel("impacts")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    if not found.size:
        axes.text(0.5, 0.5, "no impact during the watch", transform=axes.transAxes, ha="center", color=GREY)
        return axes
    top = float(found.max())
    axes.hist(found, bins=np.linspace(0.0, 1.04 * top, 41).tolist(), color=BLUE)
    axes.axvline(float(found.mean()), color=GREEN, lw=1.2, ls="--", label=f"mean {number(float(found.mean()))} N s")
    axes.set_xlim(0.0, 1.04 * top)
    finish_axes(axes, legend="best")
    axes.set_title(f"impacts a period: {number(response.impulses.per_period)}", fontsize="medium", loc="left")
    return axes


def _kind(response: Response) -> str:
    regime = response.regime
    if regime.multiple is None:
        return regime.kind
    return f"{regime.kind}, {regime.multiple} × period of the force"


def shortened(text: str) -> str:
    """A formula for a title; ``text``: the formula; from its 44th character on it is left out."""
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"


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
    finish_axes(axes, bifurcation.parameter, "z at whole periods [m]")
    if axes.lines:
        axes.legend(loc="lower left", markerscale=3.0, **LEGEND)
    start = {"separate": "each value from the same start", "up": "swept up", "down": "swept down"}[bifurcation.order]
    axes.set_title(f"g = {shortened(bifurcation.force)}, {start}", fontsize="medium", loc="left")
    if not bifurcation.complete:
        note(axes, f"only {len(bifurcation.points)} of {len(bifurcation.values)} values done", corner="lower right")
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
    done = "" if basin.complete else f", only {int((basin.impacts >= 0).sum())} motions done"
    said = f"the rod itself, {int(basin.known.sum())} of {basin.known.size} resting places known{done}"
    said += "\nblack lines: the number of impacts changes" if lines else ""
    axes.set_title(said, fontsize="small", loc="left")
    return finish_axes(axes, "displacement added to u0 [m]", "velocity added to u1 [m/s]")


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
