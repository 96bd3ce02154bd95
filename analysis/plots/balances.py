"""The describing function of a hint: where the curve of a block meets the locus of a law."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from analysis.criteria.describing import DescribingHint, HarmonicBalance, amplitudes
from analysis.criteria.describing_function import real_describing_function
from analysis.graphical.axis import axis_values
from analysis.plots.responses import axes_cross, curve_with_arrow, window
from analysis.plots.style import LEGEND, PURPLE, VERMILLION, axes_or_new, finish_axes, note, number
from lure.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_WORDS = {True: "perhaps attracting", False: "perhaps repelling", None: "of unknown kind"}
_MARKERS = "ov^sD"


def plot_hint(hint: DescribingHint, *, ax: Axes | None = None) -> Axes:
    r"""``H(i omega)``, the locus ``-1/N(A)`` on the real axis, and the harmonic balances where the two meet.

    A hint, not a verdict, as the title says: harmonics are neglected without a bound on them.

    Parameters
    ----------
    hint : DescribingHint
        From :func:`analysis.describing_hint`.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.  Balances of one gain lie on one point; the legend has the amplitude of each.

    Raises
    ------
    InputError
        The hint does not come from ``describing_hint``, so that it has no block and no law.
    """
    if hint.block is None or hint.law is None:
        raise InputError("the hint has no block and no law to draw; take it from describing_hint(block, law)")
    values = axis_values(hint.block, None)[1]
    gains = real_describing_function(hint.law, amplitudes(hint.law))
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
    axes.set_xlabel("Re H(iω) [unit of σ / unit of μ]")
    axes.set_ylabel("Im H(iω) [unit of σ / unit of μ]")
    finish_axes(axes)
    axes.legend(loc="upper right", **LEGEND)
    return axes


def _locus(axes: Axes, locus: NDArray[np.float64]) -> None:
    """The values of ``-1/N`` as stretches of the real axis, on either side of 0; a law of one gain has one point."""
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
