"""The drawings of responses: a curve, the line or region of a sector, and the least distance seen."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lure.analysis.describing import DescribingHint, HarmonicBalance, amplitudes, real_describing_function
from lure.analysis.graphical.axis import axis_values
from lure.analysis.inequality.checks import check_plant
from lure.analysis.numerics.doubles import text_below
from lure.analysis.plots.frequency import (
    FAR,
    NAMED,
    axes_cross,
    boundary_name,
    disc,
    half_plane,
    margin_arrow,
    popov_line,
    unit,
)
from lure.analysis.plots.style import (
    BLUE,
    GREEN,
    PURPLE,
    VERMILLION,
    axes_or_new,
    finish_axes,
    ink,
    note,
    number,
    padded,
)
from lure.errors import AssumptionError, InputError
from lure.plants.delay import DelayPlant
from lure.plants.rational import RationalPlant

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes

    from lure.analysis.graphical import NyquistResponse, PopovResponse

# The describing function of a hint: where the curve of a block meets the locus of a nonlinearity.

_WORDS = {True: "perhaps attracting", False: "perhaps repelling", None: "of unknown kind"}
_MARKERS = "ov^sD"


def plot_hint(hint: DescribingHint, *, ax: Axes | None = None) -> Axes:
    r"""``H(i omega)``, the locus ``-1/N(A)`` on the real axis, and the harmonic balances where the two meet.

    A hint, not a verdict, as the title says: harmonics are neglected without a bound on them.

    Parameters
    ----------
    hint : DescribingHint
        From :func:`lure.analysis.describing.describing_hint`.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.  Balances of one gain lie on one point; the legend has the amplitude of each.

    Raises
    ------
    InputError
        The hint does not come from ``describing_hint``, so that it has no block and no nonlinearity.
    """
    if hint.block is None or hint.nonlinearity is None:
        raise InputError(
            "the hint has no block and no nonlinearity to draw; take it from describing_hint(block, nonlinearity)"
        )
    values = axis_values(hint.block, None)[1]
    gains = real_describing_function(hint.nonlinearity, amplitudes(hint.nonlinearity))
    with np.errstate(divide="ignore"):
        locus = -1.0 / gains
    locus = locus[np.isfinite(locus)]
    axes = axes_or_new(ax)
    nearest = float(locus[np.abs(locus).argmin()]) if locus.size else None
    limits = window(values.real, values.imag, nearest, *(-1.0 / b.gain for b in hint.balances))
    axes_cross(axes, (*limits[:3], limits[3] + 0.35 * (limits[3] - limits[2])))  # room for the legend
    curve_with_arrow(axes, values.real, values.imag, "H(iω), ω > 0")
    _locus(axes, locus)
    _mark(axes, hint.balances)
    axes.set_title("harmonic balance: a hint, not a verdict", fontsize="medium")
    return finish_axes(
        axes, "Re H(iω) [unit of σ / unit of μ]", "Im H(iω) [unit of σ / unit of μ]", legend="upper right"
    )


def _locus(axes: Axes, locus: NDArray[np.float64]) -> None:
    """The values of ``-1/N`` as stretches of the real axis, on either side of 0; one gain has one point."""
    low, high = axes.get_xlim()
    label = "−1/N(A)"
    for part in (locus[locus < 0], locus[locus > 0]):
        part = part[(part >= low) & (part <= high)] if part.size and np.ptp(part) == 0 else np.clip(part, low, high)
        if not part.size or part.min() == part.max() in (low, high):
            continue
        mark = "x" if part.min() == part.max() else ""
        axes.plot([part.min(), part.max()], [0.0, 0.0], color=VERMILLION, lw=4, alpha=0.5, marker=mark, label=label,
                  solid_capstyle="butt")  # fmt: skip
        label = "_"
    if label != "_" and locus.size:
        nearest = float(locus[np.abs(locus).argmin()])
        note(axes, f"−1/N(A) begins at {number(nearest)}, out of the picture", corner="lower right")


def _mark(axes: Axes, balances: tuple[HarmonicBalance, ...]) -> None:
    """A marker for each balance, one around the other where they share a point."""
    if not balances:
        axes.plot([], [], " ", label="no balance was found, which excludes no oscillation")
    shown = balances[: len(_MARKERS)]
    for i, (balance, marker) in enumerate(zip(shown, _MARKERS, strict=False)):
        words = f"A = {balance.amplitude:.4g}, ω = {balance.frequency:.4g} rad/s, {_WORDS[balance.stable_guess]}"
        size = 5 + 4 * sum(abs(b.gain - balance.gain) <= 1e-9 * abs(b.gain) for b in shown[:i])
        axes.plot([-1.0 / balance.gain], [0.0], marker, ms=size, color=PURPLE, mfc="none", mew=1.5, label=words)
    if len(balances) > len(shown):
        axes.plot([], [], " ", label=f"and {len(balances) - len(shown)} more balances")


_HEADROOM = 0.38  # of the height, above the curve: the legend and the sector stand there
_WIDE = 1.45  # width by height of axes with equal units
_TALL = 3.0  # a curve that runs off to infinity is cut where it is this many widths tall
Floats = NDArray[np.float64]


def plot_popov_response(response: PopovResponse, *, ax: Axes | None = None) -> Axes:
    r"""Popov plot: ``omega Im H`` over ``Re H``, the line of the sector, its forbidden side, and the least distance.

    Parameters
    ----------
    response : PopovResponse
        From :func:`lure.analysis.popov_response`.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.  A line too far away for the scale of the curve is named, not drawn.
    """
    axes = axes_or_new(ax)
    x, y = response.values.real, response.omega * response.values.imag
    k, theta = response.k, response.theta
    boundary = None if k is None or theta is None else -1.0 / k + 0.0
    low, high, bottom, top = window(x, y, boundary)
    near = boundary is not None and low <= boundary
    if near and theta is not None and theta < 0:  # room for the name below the axis
        bottom = min(bottom, -0.12 * (top - bottom))
    top += _HEADROOM * (top - bottom) / (1 - _HEADROOM)
    axes_cross(axes, (low, high, bottom, top))
    curve_with_arrow(axes, x, y, "H(iω), ω > 0")
    if boundary is not None and theta is not None:
        if near:
            popov_line(axes, boundary, theta, f"line of slope 1/θ, θ = {number(theta)} s")
            _least(axes, response.worst, (x, y), response.omega, response.margin_seen)
            if response.worst is not None:
                height = float(y[response.worst])
                margin_arrow(axes, (theta * height + boundary, float(x[response.worst])), height, named=False)
        else:
            note(axes, f"line through Re H = {number(boundary)}, far to the left")
        axes.set_title(_title(response, 0.0, f"θ = {number(theta)} s"), fontsize="medium")
    block = response.block
    return finish_axes(axes, f"Re H(iω) [{unit(block)}]", f"ω Im H(iω) [{unit(block, per_second=True)}]", legend="best")


def plot_nyquist_response(response: NyquistResponse, *, ax: Axes | None = None) -> Axes:
    r"""Nyquist plot: the curve for ``omega > 0`` and its mirror image, the forbidden region, and the least distance.

    Parameters
    ----------
    response : NyquistResponse
        From :func:`lure.analysis.nyquist_response`.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.  A region too far away for the scale of the curve is named, not drawn.
    """
    axes = axes_or_new(ax)
    x, y = response.values.real, response.values.imag
    ends, k = response.disc, response.k
    boundary = None if k is None else -1.0 / k + 0.0 if response.lower == 0 else -1.0 / response.lower
    marks = [] if k is None else list(ends) if ends is not None else [boundary]
    low, high, bottom, top = window(x, y, *[mark for mark in marks if mark is not None])
    half = max(-bottom, top, 0.5 * (ends[1] - ends[0]) * 1.15 if ends is not None and low <= ends[0] else 0.0)
    bottom, top = (-half, half) if ends is not None else (bottom, top)
    top += _HEADROOM * (top - bottom) / (1 - _HEADROOM)
    if ends is not None:  # a circle looks like one
        more = 0.5 * (_WIDE * (top - bottom) - (high - low))
        low, high = (low - more, high + more) if more > 0 else (low, high)
        axes.set_aspect("equal", adjustable="box")
    axes_cross(axes, (low, high, bottom, top))
    discrete = getattr(response.block, "dt", None) is not None
    curve_with_arrow(axes, x, y, "H(exp iωΔt), ω > 0" if discrete else "H(iω), ω > 0")
    if ends is not None:
        axes.plot(x, -y, color=BLUE, lw=0.9, ls="--", label="ω < 0")
    near = k is not None and all(low <= mark <= high for mark in marks if mark is not None)
    if near and ends is not None:
        disc(axes, ends, inside=response.inside)
    elif near and boundary is not None:
        half_plane(axes, boundary, left=response.lower == 0)
        axes.plot([boundary], [0.0], marker="D", ms=4.5, ls="", color=ink(axes), zorder=4)
        boundary_name(axes, boundary, "k", above=True)
    elif k is not None:
        note(axes, f"forbidden region from Re H = {number(min(m for m in marks if m is not None))}, out of the picture")
    if near:
        _least(axes, response.worst, (x, y), response.omega, response.margin_seen)
    if k is not None:
        axes.set_title(_title(response, response.lower, ""), fontsize="medium")
    block, argument = response.block, "exp iωΔt" if discrete else "iω"
    return finish_axes(axes, f"Re H({argument}) [{unit(block)}]", f"Im H({argument}) [{unit(block)}]", legend="best")


def window(x: Floats, y: Floats, *marks: float | None) -> tuple[float, float, float, float]:
    """Limits that show the curve, the origin and the marks, unless a mark is too far away or a pole runs off."""
    good = np.isfinite(x) & np.isfinite(y)
    x, y = (x[good], y[good]) if good.any() else (np.zeros(1), np.zeros(1))
    kept = _kept(np.abs(x))
    left, right = min(float(np.min(x[kept])), 0.0), max(float(np.max(x[kept])), 0.0)
    reach = (right - left) or 1.0
    for mark in marks:
        if mark is not None and abs(mark) <= FAR * reach:
            left, right = min(left, mark - NAMED * max(reach, abs(mark))), max(right, mark)
    tall = 2.0 * float(np.median(np.abs(y[kept])))
    if right - left < tall:  # a curve along the imaginary axis
        left, right = left - 0.25 * (tall - right + left), right + 0.25 * (tall - right + left)
    low, high = padded(left, right, 0.12)
    width = high - low
    bottom = max(min(float(np.min(y[kept])), 0.0), -_TALL * width)
    top = min(max(float(np.max(y[kept])), 0.0), _TALL * width)
    if top - bottom < 0.1 * width:  # a curve along the real axis
        bottom, top = bottom - 0.05 * width, top + 0.05 * width
    return low, high, *padded(bottom, top, 0.08)


def _kept(size: Floats) -> NDArray[np.bool_]:
    """All points, unless the curve runs off to infinity at an end of the frequencies, or at a pole on the axis."""
    typical, place = float(np.median(size)) or 1.0, int(np.argmax(size))
    inwards = min(size.size // 20, size.size - 1) * (1 if place == 0 else -1)
    at_an_end = place in (0, size.size - 1) and size[place] > 2 * size[place + inwards]
    runs_off = size[place] > 1e3 * typical and at_an_end
    return size <= 50 * typical if runs_off or size[place] > 1e8 * typical else size >= 0


def curve_with_arrow(axes: Axes, x: Floats, y: Floats, label: str) -> None:
    """The curve with an arrow in the direction of growing frequency, in the middle of what is seen of it."""
    axes.plot(x, y, color=BLUE, lw=1.4, label=label)
    (low, high), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    seen = np.isfinite(x) & np.isfinite(y) & (x > low) & (x < high) & (y > bottom) & (y < top)
    steps = np.hypot(np.diff(x) / (high - low), np.diff(y) / (top - bottom))
    steps = np.where(seen[1:] & seen[:-1], steps, 0.0)
    way = np.cumsum(steps)
    if not way.size or way[-1] < 0.2:
        return
    place = int(np.searchsorted(way, 0.5 * way[-1]))
    start = max(int(np.searchsorted(way, way[place] - 0.02)) - 1, 0)
    if start < place and steps[start : place + 1].all():
        arrow = {"arrowstyle": "-|>", "color": BLUE, "lw": 0.0, "mutation_scale": 14, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (x[place + 1], y[place + 1]), xytext=(x[start], y[start]), arrowprops=arrow)


def _least(axes: Axes, worst: int | None, curve: tuple[Floats, Floats], omega: Floats, margin: float | None) -> None:
    """The point drawn that comes closest, with its distance."""
    if worst is None or margin is None:
        return
    label = f"least distance seen: {number(margin, 3)}\nat {number(float(omega[worst]), 3)} rad/s"
    axes.plot([curve[0][worst]], [curve[1][worst]], marker="o", ms=5, ls="", color=GREEN, label=label, zorder=5)


def _title(response: PopovResponse | NyquistResponse, lower: float, more: str) -> str:
    """The sector, and where no criterion applies, wherever the curve lies, that the picture shows nothing."""
    end = math.inf if response.k is None else response.k
    bracket = ")" if math.isinf(end) else "]"
    short = f"{end:.7g}"  # the double 1.2 is less than 1.2, and 1.199999 is not what was asked about
    named = short if float(short) == end else text_below(end, 7)
    words = f"sector [{number(lower)}, {named.replace('inf', '∞').replace('-', '−')}{bracket}"
    return "\n".join([f"{words}, {more}" if more else words, *_not_stable(response.block, lower)])


def _not_stable(block: object, lower: float) -> Iterator[str]:
    """A line where the loop with the lower gain is known not to be stable, which every criterion drawn assumes."""
    if isinstance(block, DelayPlant) and not block.feedback and lower == 0:
        block = RationalPlant([1], block.denominator)  # its poles, of which one at 0 has a positive residue
    if isinstance(block, RationalPlant) and math.isfinite(lower):
        try:
            check_plant(block, lower=Fraction(lower))
        except AssumptionError:
            loop = f"the loop with the gain {number(lower)}" if lower else "the plant"
            yield f"{loop} is not stable: this picture shows nothing"
