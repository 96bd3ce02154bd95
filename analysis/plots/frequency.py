"""Nyquist plot with the region the circle criterion forbids, Popov plot with its line, and the Popov expression."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.analysis.graphical.axis import drawing_frequencies
from lure.analysis.plots.style import (
    BLUE,
    GREEN,
    GREY,
    axes_or_new,
    finish_axes,
    ink,
    note,
    number,
    padded,
    room_below,
)
from lure.analysis.verdict import CriterionResult
from lure.classes import Sector
from lure.errors import InputError
from lure.plants.block import Plant

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Popov plot with the Popov line, and the Popov expression against frequency.

# What Nyquist and Popov plots share: the curve, its unit, and the arrow that shows a margin.

FAR = 30.0
"""A boundary further away than so many widths of the curve is named in the plot, not drawn."""

NAMED = 0.08
"""Of the width, room for the name of a boundary left of it, besides the margin."""

_ROUNDING = 1e-13
"""An imaginary part that is a smaller share of its value is drawn as 0."""


def curve(block: Plant, omega: ArrayLike | None) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Frequencies [rad/s] and ``H(i omega)`` there, nan at a pole so that the drawn curve breaks."""
    frequencies = drawing_frequencies(block) if omega is None else np.asarray(omega, dtype=float)
    if frequencies.ndim != 1 or frequencies.size < 2 or not frequencies[0] > 0:
        raise InputError("omega must be a list of at least two positive frequencies [rad/s]")
    values = block.transfer(1j * frequencies)
    values = np.where(np.abs(values.imag) < _ROUNDING * np.abs(values), values.real, values)
    return frequencies, np.where(np.isfinite(values), values, complex(np.nan, np.nan))


def unit(block: object, *, per_second: bool = False) -> str:
    """Unit of ``H``, or of ``omega H``."""
    units: tuple[str, str] | None = getattr(block, "response_units", None)
    if units is not None:
        return units[per_second]
    return "unit of σ / (unit of μ · s)" if per_second else "unit of σ / unit of μ"


def upper_end(block: object) -> str:
    """The letter of the sector's upper end: ``k``, but for the rod, whose ``k`` is the dashpot."""
    return str(getattr(block, "gain_letter", "k"))


def boundary_name(axes: Axes, boundary: float, letter: str, *, above: bool) -> None:
    """The name of the point on the real axis, on the forbidden side of it unless that is too narrow."""
    low, high = axes.get_xlim()
    room = (boundary - low) / (high - low) * axes.bbox.width * 72 / axes.figure.dpi  # on the left, in points
    text = f"−1/{letter}" if boundary else "0"
    tight = room < 5 + 0.6 * len(text) * float(axes.xaxis.label.get_fontsize())
    offset = (5 if tight else -5, 4 if above else -5)
    axes.annotate(text, (boundary, 0.0), xytext=offset, textcoords="offset points", color=ink(axes),
                  ha="left" if tight else "right", va="bottom" if above else "top")  # fmt: skip


def margin_arrow(axes: Axes, ends: tuple[float, float], height: float, *, named: bool = True) -> None:
    """A double arrow from the boundary to the curve, unless they are too close to see it, or out of the picture."""
    (low, high), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    inside = low <= min(ends) and max(ends) <= high and bottom <= height <= top
    if not inside or abs(ends[1] - ends[0]) < 0.03 * (high - low):
        return
    arrow = {"arrowstyle": "<->", "color": GREEN, "lw": 1.0, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (ends[0], height), xytext=(ends[1], height), arrowprops=arrow)
    if named:
        middle, label = (0.5 * (ends[0] + ends[1]), height), "margin" if ends[1] > ends[0] else "short by"
        axes.annotate(label, middle, xytext=(0, 3), textcoords="offset points", ha="center", color=GREEN)


def popov_line(axes: Axes, boundary: float, theta: float, label: str, letter: str = "k") -> None:
    """The line ``Re H = theta omega Im H + boundary`` on axes whose limits are settled, and what lies left of it."""
    low, ends = axes.get_xlim()[0], np.array(axes.get_ylim())
    line = theta * ends + boundary
    axes.plot(line, ends, color=ink(axes), lw=1.3, label=label)
    axes.fill_betweenx(ends, np.minimum(low, line), line, color=GREY, alpha=0.2, lw=0)
    axes.plot([boundary], [0.0], marker="D", ms=4.5, ls="", color=ink(axes), zorder=4)
    boundary_name(axes, boundary, letter, above=theta >= 0)


def half_plane(axes: Axes, boundary: float, *, left: bool = True) -> None:
    """The half-plane that the circle criterion forbids, on axes whose limits are settled."""
    low, high = axes.get_xlim()
    axes.axvspan(*((low, boundary) if left else (boundary, high)), color=GREY, alpha=0.2, lw=0)
    label = f"forbidden: Re H {'≤' if left else '≥'} {number(boundary)}"
    axes.axvline(boundary, color=ink(axes), lw=1.3, label=label)


def disc(axes: Axes, ends: tuple[float, float], *, inside: bool = False) -> None:
    """The disc whose diameter is an interval of the real axis, forbidden or the only place where the curve may be."""
    from matplotlib.patches import Circle

    centre, radius = (0.5 * (ends[0] + ends[1]), 0.0), 0.5 * (ends[1] - ends[0])
    words = "the curve belongs inside" if inside else "forbidden disc"
    axes.add_patch(
        Circle(centre, radius, facecolor=(GREY, 0.0 if inside else 0.2), lw=1.3, edgecolor=ink(axes), label=words)
    )  # fmt: skip


def axes_cross(axes: Axes, limits: tuple[float, float, float, float]) -> None:
    """The two axes through the origin, within limits as :func:`window` gives them."""
    axes.axhline(0.0, color=GREY, lw=0.6)
    axes.axvline(0.0, color=GREY, lw=0.6)
    axes.set(xlim=limits[:2], ylim=limits[2:])


def plot_popov(
    block: Plant, result: CriterionResult, *, omega: ArrayLike | None = None, ax: Axes | None = None
) -> Axes:
    r"""Popov plot: ``omega Im H`` over ``Re H``, with the Popov line through ``-1/kappa`` and slope ``1/theta``.

    ``1/kappa + Re[(1 + i omega theta) H] > 0`` says that the curve lies to the right of the line
    ``Re H = theta omega Im H - 1/kappa``; the horizontal distance of a point from the line is its value, least at the
    witness.

    Parameters
    ----------
    block : Block
        The linear part.
    result : CriterionResult
        A criterion with a multiplier, for this block.
    omega : array_like, optional
        Positive frequencies [rad/s], increasing; by default those of :func:`drawing_frequencies`.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.  A line too far away for the scale of the curve is named, not drawn.

    Raises
    ------
    InputError
        The result has no multiplier: the criterion did not apply.
    """
    theta = _multiplier(result)
    axes = axes_or_new(ax)
    frequencies, values = curve(block, omega)
    x, y = values.real, frequencies * values.imag
    boundary = _boundary(result)
    reach = float(np.nanmax(x) - min(np.nanmin(x), 0.0))
    near = -boundary <= FAR * reach
    room = boundary - NAMED * max(reach, -boundary) if near else 0.0
    low, high = padded(min(float(np.nanmin(x)), room), max(float(np.nanmax(x)), 0.0), 0.12)
    bottom, top = padded(min(float(np.nanmin(y)), 0.0), max(float(np.nanmax(y)), 0.0), 0.12)
    bottom = room_below(bottom, top, 3 if near else 0)
    axes.plot(x, y, color=BLUE, lw=1.2, marker=".", markevery=[0, -1], label="H(iω), ω > 0")
    axes_cross(axes, (low, high, bottom, top))
    if near:
        popov_line(axes, boundary, theta, f"Popov line, θ = {number(theta)} s", upper_end(block))
        _popov_witness(axes, block, result, float(frequencies[0]))
    else:
        note(axes, f"Popov line through Re H = {number(boundary)}, far to the left")
    return finish_axes(
        axes,
        f"Re H(iω) [{unit(block)}]",
        f"ω Im H(iω) [{unit(block, per_second=True)}]",
        legend="best" if near else "upper right",
    )


def plot_popov_expression(
    block: Plant, result: CriterionResult, *, omega: ArrayLike | None = None, ax: Axes | None = None
) -> Axes:
    r"""The Popov expression ``1/kappa + Re[(1 + i omega theta) H(i omega)]`` against frequency, with its margin.

    Triangles at the ends mark the limits ``omega -> 0`` and ``omega -> inf``; for the rod itself, which has no limit at
    infinity, the bar on the right marks the range in which the expression keeps moving.

    Parameters
    ----------
    block : Block
        The linear part.
    result : CriterionResult
        A criterion with a multiplier, for this block.
    omega : array_like, optional
        Positive frequencies [rad/s], increasing; by default those of :func:`drawing_frequencies`.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.

    Raises
    ------
    InputError
        The result has no multiplier: the criterion did not apply.
    """
    theta = _multiplier(result)
    axes = axes_or_new(ax)
    frequencies, values = curve(block, omega)
    start = -_boundary(result)
    expression = start + values.real - theta * frequencies * values.imag
    axes.semilogx(frequencies, expression, color=BLUE, lw=1.2, label=f"θ = {number(theta)} s")
    axes.plot([frequencies[0]], [expression[0]], marker="<", ms=6, color=BLUE, clip_on=False)
    ends = _limits_at_infinity(block, start, theta, float(frequencies[-1]))
    axes.plot([frequencies[-1]] * len(ends), ends, marker=">", ms=6, lw=3, alpha=0.7, color=BLUE, clip_on=False)
    shown = [*expression[np.isfinite(expression)], *ends]
    if result.margin is not None and math.isfinite(result.margin.low):
        margin = result.margin.low
        axes.axhline(margin, color=GREEN, lw=1.0, ls="--", label=f"margin {number(margin)} {unit(block)}")
        shown.append(margin)
        worst = result.worst_frequency
        if worst is not None:
            place = min(max(worst, float(frequencies[0])), float(frequencies[-1]))
            axes.plot([place], [margin], marker="o", ms=5, color=GREEN, clip_on=False)
    low, high = padded(min(shown), max(shown), 0.1)
    low = min(low, 0.0) if low <= 0.6 * high else low
    axes.set(xlim=(frequencies[0], frequencies[-1]), ylim=(low, high))
    if low < 0.0:
        axes.axhspan(low, 0.0, color=GREY, alpha=0.2, lw=0, label="forbidden")
    return finish_axes(axes, "ω [rad/s]", f"1/{upper_end(block)} + Re[(1 + iωθ)H] [{unit(block)}]", legend="best")


def _multiplier(result: CriterionResult) -> float:
    if result.theta is None:
        about = f" for the {result.model}" if result.model else ""
        raise InputError(f"the {result.criterion} criterion gave no multiplier{about}: {result.reason}")
    return result.theta


def _boundary(result: CriterionResult) -> float:
    return 0.0 if math.isinf(result.sector.upper) else -1.0 / float(result.sector.upper)


def _popov_witness(axes: Axes, block: Plant, result: CriterionResult, lowest: float) -> None:
    worst, theta = result.worst_frequency, result.theta
    if worst is None or theta is None or math.isinf(worst):
        return
    omega = max(worst, lowest)
    value = complex(block.transfer(np.array([1j * omega]))[0])
    height = omega * value.imag
    place = "least as ω → 0" if worst <= lowest else f"least at {number(worst)} rad/s"
    axes.plot([value.real], [height], marker="o", ms=5, ls="", color=GREEN, label=place)
    margin_arrow(axes, (theta * height + _boundary(result), value.real), height)


def _limits_at_infinity(block: Plant, start: float, theta: float, fastest: float) -> list[float]:
    special = getattr(block, "speeds_at_infinity", None)
    if special is not None:
        return [start + theta * speed for speed in special]
    far = 1e6 * fastest
    value = complex(block.transfer(np.array([1j * far]))[0])
    return [start + value.real - theta * far * value.imag]


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
    bottom = min(float(np.nanmin(y)), 0.0)
    bottom = bottom if -bottom <= 3.0 * (high - low) else -0.8 * (high - low)
    bottom = min(bottom, -0.1 * (high - low))  # a curve along the real axis
    top = -bottom if sector.lower > 0 else max(float(np.nanmax(y)), 0.0)
    bottom, top = padded(bottom, top, 0.08 if near else 0.15)
    axes_cross(axes, (low, high, room_below(bottom, top, 3 if near else 0), top))
    if not near:
        note(axes, f"forbidden: Re H ≤ {number(boundary)}, far to the left")
    elif sector.lower > 0:
        disc(axes, (left, boundary))
        axes.set_aspect("equal", adjustable="datalim")
    else:
        half_plane(axes, boundary)
    if worst is not None and near and sector.lower == 0:
        _nyquist_witness(axes, block, worst, (float(frequencies[0]), boundary))
    return finish_axes(
        axes, f"Re H(iω) [{unit(block)}]", f"Im H(iω) [{unit(block)}]", legend="best" if near else "upper right"
    )


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
