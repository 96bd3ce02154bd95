"""The eigenvalues of linear members of a class, and what bounds every decay."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from lure.analysis.certificates.boxes import plants
from lure.analysis.counterexamples.channel_switching import GainsAround
from lure.analysis.plots.style import BLUE, GREY, LEGEND, VERMILLION, axes_or_new, finish_axes, room_below
from lure.analysis.questions.decay import RateBound
from lure.plants.multivariable import MultivariablePlant
from lure.plants.rational import RationalPlant
from lure.record import rounded

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lure.arrays import Reals

_MEMBERS, _SEED, _ROOM = 400, 5, 0.12


def plot_rate(found: RateBound, *, ax: Axes | None = None) -> Axes:
    """The eigenvalues of loops with constant gains of the class, the rate that is proved and the one that is refuted.

    In discrete time the rates are circles, in continuous time lines ``Re s = -rate``.  The eigenvalues are drawn in
    floating point; blue is certified for every member, red is a rate that a member does not exceed.

    Parameters
    ----------
    found : RateBound
        The answer.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.
    """
    axes, discrete = axes_or_new(ax), found.time == "discrete"
    shown = found.proof or found.refutation
    if shown is not None:
        values = _eigenvalues(shown.certificate)
        axes.plot(values.real, values.imag, ".", color=GREY, ms=2, label="constant gains of the class")
    low, high = found.rate.low, found.rate.high
    proved, refuted = (high, low) if discrete else (low, high)
    if math.isfinite(proved):
        text = rounded(proved, "above" if discrete else "below", 4)
        look = {"color": BLUE, "ls": "-", "label": f"every member: {text}, certified"}
        _rate(axes, proved, look, discrete=discrete)
    if found.refutation is not None:
        text = rounded(refuted, "below" if discrete else "above", 4)
        look = {"color": VERMILLION, "ls": "--", "label": f"a member: no better than {text}"}
        _rate(axes, refuted, look, discrete=discrete)
    if discrete:
        turn = np.linspace(0, 2 * np.pi, 200)
        axes.plot(np.cos(turn), np.sin(turn), color="black", lw=0.7)
        axes.set_aspect("equal", adjustable="datalim")
    else:
        axes.axvline(0, color="black", lw=0.7)
    axes.margins(_ROOM)
    bottom, top = axes.get_ylim()
    axes.set_ylim(room_below(bottom, top, len(axes.get_legend_handles_labels()[1])), top)
    axes.set_xlabel("Re z [1]" if discrete else "Re s [1/s]")
    axes.set_ylabel("Im z [1]" if discrete else "Im s [rad/s]")
    finish_axes(axes)
    axes.legend(loc="lower left", **LEGEND)
    return axes


def _rate(axes: Axes, rate: float, look: dict[str, Any], *, discrete: bool) -> None:
    if discrete:
        turn = np.linspace(0, 2 * np.pi, 200)
        axes.plot(rate * np.cos(turn), rate * np.sin(turn), lw=1.8, **look)
    else:
        axes.axvline(-rate, lw=1.8, **look)


def _eigenvalues(certificate: Mapping[str, Any]) -> Reals:
    """The eigenvalues with gains of the class: one gain from end to end, several at random."""
    system, classes = certificate["system"], certificate["laws"]
    if system["kind"] == "family":  # the plant in the middle of the box
        H = plants(dict(system))
        system = H.at([(low + high) / 2 for low, high in H.box])
    if system["kind"] == "transfer":
        top, bottom = ([Fraction(c) for c in system[name]] for name in ("numerator", "denominator"))
        plant = MultivariablePlant.of_one_channel(RationalPlant(top, bottom))
    else:
        A, B, C, D = (tuple(tuple(map(Fraction, row)) for row in system[side]) for side in "ABCD")
        plant = MultivariablePlant(A, B, C, D, None)
    each = classes.get("channels", [classes])
    ends = [[float(Fraction(end)) for end in one["sector"]] for one in each]
    shares = np.random.default_rng(_SEED).uniform(0, 1, (_MEMBERS, len(ends)))
    if len(ends) == 1:
        shares = np.linspace(0, 1, _MEMBERS)[:, None]
    elif classes["repeated"] is True:
        shares[:] = shares[:, :1]
    low, high = np.array(ends).T
    return np.asarray(np.linalg.eigvals(GainsAround(*plant.doubles()).closed_by(low + shares * (high - low))).ravel())
