"""The paper's figures with what the scheme and the rod do drawn together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lure.analysis.plots.style import GREY, LEGEND, VERMILLION, axes_or_new, finish_axes, number
from lure.analysis.rod.plots.run import shade
from lure.record import described, quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@described(frozen=True, kw_only=True, eq=False)
class EndCurve:
    """One curve of the displacement of the contacting end."""

    label: str = quantity("For the legend")
    t: NDArray[np.float64] = quantity("(n,) times", "s")
    u: NDArray[np.float64] = quantity("(n,) ``u(t, L)``", "m")
    colour: str = quantity("A colour of :mod:`lure.analysis.plots.style`")
    dashes: str = quantity("Line style", default="-")
    width: float = quantity("Line width [pt]", default=1.2)


def plot_end_curves(
    curves: Sequence[EndCurve],
    *,
    obstacle: float | None = None,
    contacts: Sequence[tuple[float, float]] = (),
    settling: float | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Displacement ``u(t, L)`` of several models in one picture.

    Parameters
    ----------
    curves : sequence of EndCurve
        What to draw, first at the bottom.
    obstacle : float, optional
        Position of the obstacle to mark [m].
    contacts : sequence of (float, float)
        Intervals to shade [s].
    settling : float, optional
        A settling time to mark [s].
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    axes = axes_or_new(ax)
    for curve in curves:
        axes.plot(curve.t, curve.u, color=curve.colour, ls=curve.dashes, lw=curve.width, label=curve.label)
    shade(axes, contacts, "contact")
    if obstacle is not None:
        axes.axhline(obstacle, color=VERMILLION, lw=1.0, ls=":", label=f"obstacle at {number(obstacle)} m")
    if settling is not None:
        axes.axvline(settling, color=GREY, lw=1.0, ls=":", label=f"printed settling time, {number(settling)} s")
    axes.set_xlim(min(float(curve.t[0]) for curve in curves), max(float(curve.t[-1]) for curve in curves))
    axes.set_xlabel("t [s]")
    axes.set_ylabel("u(t, L) [m]")
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.3 * (high - low))  # room for the legend above the curves
    finish_axes(axes)
    axes.legend(loc="upper center", ncols=2, **LEGEND)
    return axes


def plot_end_envelope(
    t: NDArray[np.float64],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
    curve: EndCurve,
    *,
    ax: Axes | None = None,
) -> Axes:
    """Range over which the ringing end moves, and a curve in front of it.

    Parameters
    ----------
    t, low, high : ndarray
        (n,) times [s] and the least and largest ``u(t, L)`` of the round trip there [m].
    curve : EndCurve
        What to draw in front.
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    axes = axes_or_new(ax)
    axes.fill_between(t, low, high, color=GREY, alpha=0.4, lw=0, label="the rod: range of its ringing")
    return plot_end_curves([curve], ax=axes)


def plot_waves(
    x: NDArray[np.float64], t: NDArray[np.float64], values: NDArray[np.float64], *, title: str, ax: Axes | None = None
) -> Axes:
    """Space-time picture of a wave or a velocity [m/s].

    Parameters
    ----------
    x, t : ndarray
        (n,) places [m] and (k,) times [s].
    values : ndarray
        (k, n) [m/s].
    title : str
        Title.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on, with a colour bar beside them.
    """
    axes = axes_or_new(ax)
    largest = float(np.abs(values).max()) or 1.0
    mesh = axes.pcolormesh(x, t, values, cmap="RdBu_r", vmin=-largest, vmax=largest, shading="nearest", rasterized=True)
    axes.set(xlim=(x[0], x[-1]), ylim=(t[0], t[-1]))
    axes.figure.colorbar(mesh, ax=axes, pad=0.02)
    axes.set_title(f"{title} [m/s]", fontsize="medium")
    return finish_axes(axes, "x [m]", "t [s]")
