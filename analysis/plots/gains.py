"""The gain of linear members over the frequencies, and what no member exceeds."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import islice, product
from typing import TYPE_CHECKING

import numpy as np

from lure.analysis.plots.style import BLUE, GREY, LEGEND, axes_or_new, finish_axes
from lure.analysis.questions.gain import GainBound
from lure.analysis.verdict import Verdict
from lure.classes import DELAYS
from lure.plants.multivariable import MultivariablePlant
from lure.record import rounded

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lure.arrays import Reals

_MOST, _POINTS, _DECADES, _ROOM, _ROUNDING = 32, 600, 2, 1.45, 1e-9


def plot_gain(found: GainBound, *, ax: Axes | None = None) -> Axes:
    """The largest singular value from ``w`` to ``z`` of the loops with extreme gains, and the bound for all members.

    Grey: each channel at one end of its class, as far as that loop is stable; black: the member of ``gain.low``.  All
    this is drawn in floating point; the line at ``gain.high`` is what is certified.

    Parameters
    ----------
    found : GainBound
        The answer.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.
    """
    axes, H = axes_or_new(ax), found.plant
    low, high, top = found.gain.low, found.gain.high, 0.0
    omega = _frequencies(found)
    extremes, largest = gain_curves(found, omega)
    label: str | None = "pieces of the ReLUs" if found.classes.rectified else "gains at the ends of the class"
    for values in extremes:
        axes.plot(omega, values, color=GREY, lw=0.9, label=label)
        label, top = None, max(top, float(values.max()))
    if largest is not None:
        axes.plot(omega, largest, color="black", lw=1.6, label=f"a member with more than {rounded(low, 'below', 4)}")
    if math.isfinite(high):
        axes.axhline(high, color=BLUE, lw=2, label=f"no member has more than {rounded(high, 'above', 4)}, certified")
    else:
        unstable = found.verdict is Verdict.REFUTED
        axes.plot([], [], " ", label="a member is unstable: no bound" if unstable else "no bound is proved")
    if H.dt is None:
        axes.set_xscale("log")
    axes.set_ylim(0, _ROOM * max(top, low if math.isfinite(low) else 0.0, high if math.isfinite(high) else 0.0) or 1.0)
    axes.set_xlim(omega[0], omega[-1])
    axes.set_xlabel("ω [rad/s]" if H.dt is None else "ω [rad per sample]")
    axes.set_ylabel("largest gain from w to z")
    finish_axes(axes)
    axes.legend(loc="upper left", **LEGEND)
    return axes


def gain_curves(found: GainBound, omega: Reals | None = None) -> tuple[list[Reals], Reals | None]:
    """What :func:`plot_gain` draws of stable members: with extreme gains, and that of ``gain.low`` if there is one.

    Parameters
    ----------
    found : GainBound
        The answer.
    omega : ndarray (k,), optional
        Frequencies [rad/s], in discrete time [rad per sample]; by default those of the figure.
    """
    omega = _frequencies(found) if omega is None else omega
    classes = found.classes
    ends = [
        [1.0] if classes.classes[b[0]].operator in DELAYS else [float(classes.lower[b[0]]), float(classes.upper[b[0]])]
        for b in classes.blocks
    ]
    sizes = [len(block) for block in classes.blocks]
    extremes = [_gain(found, np.repeat(corner, sizes), omega) for corner in islice(product(*ends), _MOST)]
    member = None if found.refutation is None else found.refutation.certificate["proof"]
    member = member["proof"] if member and member["method"] == "member" else member
    largest = None
    if member is not None and math.isfinite(found.gain.low) and "gains" in member and not member.get("operators"):
        gains = np.array([float(Fraction(v)) for v in member["gains"][: len(classes.classes)]])
        largest = _gain(found, gains, omega)
    return [values for values in extremes if values is not None], largest


def _plant(found: GainBound) -> MultivariablePlant:
    """The plant; of those of a box that with the largest gain found, or the one in the middle."""
    if isinstance(found.plant, MultivariablePlant):
        return found.plant
    shown = None if found.refutation is None else found.refutation.certificate["proof"]
    return found.plant.central if shown is None else found.plant.at([Fraction(v) for v in shown["at"]])


def _frequencies(found: GainBound) -> Reals:
    H = _plant(found)
    if H.dt is not None:
        return np.linspace(0, np.pi, _POINTS)
    poles = np.abs(np.linalg.eigvals(H.doubles()[0]))
    seen = poles[poles > 1e-9] if (poles > 1e-9).any() else np.ones(1)
    return np.geomspace(seen.min() / 10**_DECADES, seen.max() * 10**_DECADES, _POINTS)


def _gain(found: GainBound, gains: Reals, omega: Reals) -> Reals | None:
    """The largest singular value of the closed loop from ``w`` to ``z``; None where it is not stable."""
    A, B, C, D = _plant(found).doubles()
    m, count = len(gains), len(A)
    G = np.diag(gains)
    whole = np.eye(m) + D[:m, :m] @ G
    if abs(np.linalg.det(whole)) < 1e-12:
        return None
    turn = G @ np.linalg.inv(whole)  # mu = -turn (C x + D_w w) on the channels
    Ac, Bw = A - B[:, :m] @ turn @ C[:m], B[:, m:] - B[:, :m] @ turn @ D[:m, m:]
    Cz, Dzw = C[m:] - D[m:, :m] @ turn @ C[:m], D[m:, m:] - D[m:, :m] @ turn @ D[:m, m:]
    poles, discrete = np.linalg.eigvals(Ac), found.plant.dt is not None
    size = np.abs(poles).max(initial=0.0)  # a pole on the axis may be rounded to either side
    if (size - 1 if discrete else poles.real.max(initial=-1.0)) >= -_ROUNDING * size:
        return None
    points = np.exp(1j * omega) if discrete else 1j * omega
    states = np.linalg.solve(points[:, None, None] * np.eye(count) - Ac, Bw.astype(complex))
    return np.asarray(np.linalg.norm(Cz @ states + Dzw, 2, axis=(1, 2)))
