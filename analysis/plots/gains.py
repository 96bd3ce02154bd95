"""The gain of linear members over the frequencies, and what no member exceeds."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import islice, product
from typing import TYPE_CHECKING

import numpy as np

from lure.analysis.plots.style import BLUE, GREY, LEGEND, VERMILLION, axes_or_new, finish_axes
from lure.analysis.questions.gain import GainBound
from lure.record import rounded

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lure.arrays import Reals

_MOST, _POINTS, _DECADES, _ROOM = 32, 600, 2, 1.45


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
    blocks = found.classes.blocks
    ends = [[float(found.classes.lower[b[0]]), float(found.classes.upper[b[0]])] for b in blocks]
    omega = _frequencies(found)
    label: str | None = "pieces of the ReLUs" if found.classes.rectified else "gains at the ends of the class"
    for corner in islice(product(*ends), _MOST):
        values = _gain(found, np.repeat(corner, [len(block) for block in blocks]), omega)
        if values is not None:
            axes.plot(omega, values, color=GREY, lw=0.9, label=label)
            label, top = None, max(top, float(values.max()))
    member = None if found.refutation is None else found.refutation.certificate["proof"]
    if member is not None and math.isfinite(low) and "gains" in member and not member.get("operators"):
        gains = np.array([float(Fraction(v)) for v in member["gains"][: len(found.classes.classes)]])
        values = _gain(found, gains, omega)
        if values is not None:
            axes.plot(omega, values, color="black", lw=1.6, label=f"a member with more than {rounded(low, 'below', 4)}")
    if math.isfinite(high):
        axes.axhline(high, color=BLUE, lw=2, label=f"no member has more than {rounded(high, 'above', 4)}, certified")
    else:
        axes.plot([], [], color=VERMILLION, label="no bound is proved")
    if H.dt is None:
        axes.set_xscale("log")
    axes.set_ylim(0, _ROOM * max(top, low if math.isfinite(low) else 0.0, high if math.isfinite(high) else 0.0) or 1.0)
    axes.set_xlim(omega[0], omega[-1])
    axes.set_xlabel("ω [rad/s]" if H.dt is None else "ω [rad per sample]")
    axes.set_ylabel("largest gain from w to z")
    finish_axes(axes)
    axes.legend(loc="upper left", **LEGEND)
    return axes


def _frequencies(found: GainBound) -> Reals:
    H = found.plant
    if H.dt is not None:
        return np.linspace(0, np.pi, _POINTS)
    poles = np.abs(np.linalg.eigvals(H.doubles()[0]))
    seen = poles[poles > 1e-9] if (poles > 1e-9).any() else np.ones(1)
    return np.geomspace(seen.min() / 10**_DECADES, seen.max() * 10**_DECADES, _POINTS)


def _gain(found: GainBound, gains: Reals, omega: Reals) -> Reals | None:
    """The largest singular value of the closed loop from ``w`` to ``z``; None where it is not stable."""
    A, B, C, D = found.plant.doubles()
    m, count = len(gains), len(A)
    G = np.diag(gains)
    whole = np.eye(m) + D[:m, :m] @ G
    if abs(np.linalg.det(whole)) < 1e-12:
        return None
    turn = G @ np.linalg.inv(whole)  # mu = -turn (C x + D_w w) on the channels
    Ac, Bw = A - B[:, :m] @ turn @ C[:m], B[:, m:] - B[:, :m] @ turn @ D[:m, m:]
    Cz, Dzw = C[m:] - D[m:, :m] @ turn @ C[:m], D[m:, m:] - D[m:, :m] @ turn @ D[:m, m:]
    poles, discrete = np.linalg.eigvals(Ac), found.plant.dt is not None
    if (np.abs(poles).max() - 1 if discrete else poles.real.max()) >= 0:
        return None
    points = np.exp(1j * omega) if discrete else 1j * omega
    states = np.linalg.solve(points[:, None, None] * np.eye(count) - Ac, Bw.astype(complex))
    return np.asarray(np.linalg.norm(Cz @ states + Dzw, 2, axis=(1, 2)))
