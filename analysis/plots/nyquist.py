"""Nyquist plot with the region the circle criterion forbids."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from lure.analysis.plots.popov import FAR, curve, margin_arrow, unit
from lure.analysis.plots.style import (
    BLUE,
    GREEN,
    GREY,
    LEGEND,
    VERMILLION,
    axes_or_new,
    finish_axes,
    note,
    number,
    padded,
    room_below,
)
from lure.classes import Sector
from lure.errors import InputError
from lure.plants.block import Plant

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_nyquist(
    block: Plant,
    sector: Sector,
    *,
    worst: float | None = None,
    omega: ArrayLike | None = None,
    ax: Axes | None = None,
) -> Axes:
    r"""Nyquist plot of ``H(i omega)`` with the region the circle criterion forbids to it.

    For ``mu = -phi(sigma)`` with ``phi`` in ``[0, kappa]`` that is the half-plane ``Re H <= -1/kappa``; for
    ``[alpha, beta]`` with ``alpha > 0`` the disk with diameter ``[-1/alpha, -1/beta]``, and then the curve for
    ``omega < 0`` is drawn too.

    Parameters
    ----------
    block : Block
        The linear part.
    sector : Sector
        ``[alpha, beta]``, ``alpha >= 0`` [unit of phi / unit of sigma].
    worst : float, optional
        Frequency of the least margin [rad/s], from the criterion; marked as the witness.  Zero marks the limit.
    omega : array_like, optional
        Positive frequencies [rad/s], increasing; by default those of :func:`drawing_frequencies`.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.  A forbidden region too far away for the scale of the curve is named, not drawn.

    Raises
    ------
    InputError
        ``alpha < 0``: shift the loop first.

    Notes
    -----
    An illustration: that the drawn curve stays out of the region proves nothing between the points drawn.
    """
    if sector.lower < 0:
        raise InputError(f"sector {sector} has a negative lower bound; shift the loop so that it starts at zero")
    axes = axes_or_new(ax)
    frequencies, values = curve(block, omega)
    x, y = values.real, values.imag
    boundary = 0.0 if math.isinf(sector.upper) else -1.0 / float(sector.upper)
    left = -1.0 / float(sector.lower) if sector.lower > 0 else boundary
    reach = float(np.nanmax(x) - min(np.nanmin(x), 0.0))
    near = -left <= FAR * reach
    low, high = padded(min(float(np.nanmin(x)), left if near else 0.0), max(float(np.nanmax(x)), 0.0), 0.12)
    missing = 2.0 * float(np.nanmedian(np.abs(y))) - (high - low)
    if missing > 0:  # a curve along the imaginary axis
        low, high = low - 0.5 * missing, high + 0.5 * missing
    axes.plot(x, y, color=BLUE, lw=1.2, label="H(iω), ω > 0")
    if sector.lower > 0:
        axes.plot(x, -y, color=BLUE, lw=0.8, ls="--", label="ω < 0")
    axes.axhline(0.0, color=GREY, lw=0.6)
    axes.axvline(0.0, color=GREY, lw=0.6)
    bottom = min(float(np.nanmin(y)), 0.0)
    bottom = bottom if -bottom <= 3.0 * (high - low) else -0.8 * (high - low)
    bottom = min(bottom, -0.1 * (high - low))  # a curve along the real axis
    axes.set_xlim(low, high)
    top = -bottom if sector.lower > 0 else max(float(np.nanmax(y)), 0.0)
    bottom, top = padded(bottom, top, 0.08 if near else 0.15)
    axes.set_ylim(room_below(bottom, top, 3 if near else 0), top)
    if not near:
        note(axes, f"forbidden: Re H ≤ {number(boundary)}, far to the left")
    elif sector.lower > 0:
        _disk(axes, left, boundary)
    else:
        axes.axvspan(low, boundary, color=VERMILLION, alpha=0.18, lw=0, label=f"forbidden: Re H ≤ {number(boundary)}")
        axes.axvline(boundary, color=VERMILLION, lw=1.0)
    if worst is not None and near and sector.lower == 0:
        _nyquist_witness(axes, block, worst, (float(frequencies[0]), boundary))
    axes.set_xlabel(f"Re H(iω) [{unit(block)}]")
    axes.set_ylabel(f"Im H(iω) [{unit(block)}]")
    finish_axes(axes)
    axes.legend(loc="best" if near else "upper right", **LEGEND)
    return axes


def _disk(axes: Axes, left: float, right: float) -> None:
    from matplotlib.patches import Circle

    centre, radius = (0.5 * (left + right), 0.0), 0.5 * (right - left)
    axes.add_patch(Circle(centre, radius, color=VERMILLION, alpha=0.3, label="forbidden disk"))
    axes.set_aspect("equal", adjustable="datalim")


def _nyquist_witness(axes: Axes, block: Plant, worst: float, ends: tuple[float, float]) -> None:
    lowest, boundary = ends
    value = complex(block.transfer(np.array([1j * max(worst, lowest)]))[0]) if math.isfinite(worst) else 0j
    bottom, top = axes.get_ylim()
    height = min(max(value.imag, bottom + 0.35 * (top - bottom)), top)
    if worst <= lowest:
        axes.axvline(value.real, color=GREEN, lw=1.0, ls=":", label=f"ω → 0: Re H → {number(value.real)}")
    else:
        axes.plot([value.real], [value.imag], marker="o", ms=5, color=GREEN, label=f"least at {number(worst)} rad/s")
    margin_arrow(axes, (boundary, value.real), height)
