"""What a stable loop does: its gain over the frequencies, the eigenvalues of members, the amplitude of its response."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import islice, product
from typing import TYPE_CHECKING, Any

import numpy as np

from lure.analysis.certificates.boxes import CHANNELS, matrices, plants
from lure.analysis.counterexamples.channel_gains import GainsAround
from lure.analysis.counterexamples.late_switching import LateRoots
from lure.analysis.plots.style import BLUE, GREY, VERMILLION, axes_or_new, finish_axes, ink, room_below
from lure.analysis.questions.decay import RateBound, rate_of
from lure.analysis.questions.gain import GainBound
from lure.analysis.questions.steady import SteadyPoint, SteadyResponse
from lure.analysis.verdict import Evidence, Verdict
from lure.classes import DELAYS
from lure.errors import InputError
from lure.plants.delay_matrix import DelayMatrix
from lure.plants.multivariable import MultivariablePlant
from lure.plants.rational import RationalPlant
from lure.record import rounded

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lure.arrays import Reals

# The gain of linear members over the frequencies, and what no member exceeds.

_MOST, _POINTS, _DECADES, _GAIN_ROOM, _ROUNDING = 32, 600, 2, 1.45, 1e-9


def plot_gain(found: GainBound, *, ax: Axes | None = None) -> Axes:
    """The largest singular value from ``w`` to ``z`` of the loops with extreme gains, and the bound for all members.

    Grey: each channel at one end of its class, as far as that loop is stable; in the colour of the text: the member of
    ``gain.low``.  All this is drawn in floating point; the line at ``gain.high`` is what is certified.

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
        axes.plot(omega, largest, color=ink(axes), lw=1.6, label=f"a member with more than {rounded(low, 'below', 4)}")
    if math.isfinite(high):
        axes.axhline(high, color=BLUE, lw=2, label=f"no member has more than {rounded(high, 'above', 4)}, certified")
    else:
        unstable = found.verdict is Verdict.REFUTED
        axes.plot([], [], " ", label="the gain is infinite: no bound" if unstable else "no bound is proved")
    if H.dt is None:
        axes.set_xscale("log")
    axes.set_ylim(
        0, _GAIN_ROOM * max(top, low if math.isfinite(low) else 0.0, high if math.isfinite(high) else 0.0) or 1.0
    )
    axes.set_xlim(omega[0], omega[-1])
    return finish_axes(
        axes, "ω [rad/s]" if H.dt is None else "ω [rad per sample]", "largest gain from w to z", legend="upper left"
    )


def gain_curves(found: GainBound, omega: Reals | None = None) -> tuple[list[Reals], Reals | None]:
    """What :func:`plot_gain` draws of stable members: with extreme gains, and that of ``gain.low`` if there is one.

    ``found``: the answer.  ``omega``: (k,), frequencies [rad/s], in discrete time [rad per sample]; by default those of
    the figure.
    """
    omega = _frequencies(found) if omega is None else omega
    classes = found.classes
    ends = [
        [1.0] if classes.classes[b[0]].operator in DELAYS else [float(classes.lower[b[0]]), float(classes.upper[b[0]])]
        for b in classes.blocks
    ]
    sizes = [len(block) for block in classes.blocks]
    late = isinstance(found.plant, DelayMatrix)  # then which of these loops are stable is not known in floating point
    corners = [] if late and found.verdict is not Verdict.PROVED else islice(product(*ends), _MOST)
    extremes = [_gain(found, np.repeat(corner, sizes), omega) for corner in corners]
    member = None if found.refutation is None else found.refutation.certificate["proof"]
    member = member["proof"] if member and member["method"] == "member" else member
    largest = None
    if member is not None and math.isfinite(found.gain.low) and "gains" in member and not member.get("operators"):
        gains = np.array([float(Fraction(v)) for v in member["gains"][: len(classes.classes)]])
        largest = _gain(found, gains, omega)
    return [values for values in extremes if values is not None], largest


def _plant(found: GainBound) -> MultivariablePlant:
    """The plant, without dead times; of those of a box that with the largest gain found, or the one in the middle."""
    if isinstance(found.plant, MultivariablePlant):
        return found.plant
    if isinstance(found.plant, DelayMatrix):
        return found.plant.base
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
    if isinstance(found.plant, DelayMatrix):
        H, whole = found.plant.transfer(1j * omega), np.eye(len(D))
        whole = whole + H[:, :, :m] @ np.eye(m, len(D)) * np.array([*gains, *np.zeros(len(D) - m)])
        return np.asarray(np.linalg.norm(np.linalg.solve(whole, H)[:, m:, m:], 2, axis=(1, 2)))
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


# The eigenvalues of linear members of a class, and what bounds every decay.

_MEMBERS, _FEW, _SEED, _RATE_ROOM = 400, 8, 5, 0.12  # every eighth beside dead time


def plot_rate(found: RateBound, *, ax: Axes | None = None) -> Axes:
    """The eigenvalues of loops with constant gains of the class, the rate that is proved and the one that is refuted.

    In discrete time the rates are circles, in continuous time lines ``Re s = -rate``.  The eigenvalues are drawn in
    floating point; blue is certified for every member, orange is a rate that a member does not exceed.

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
        text = rounded(rate_of(found.refutation), "below" if discrete else "above", 4)
        look = {"color": VERMILLION, "ls": "--", "label": f"a member: no better than {text}"}
        _rate(axes, refuted, look, discrete=discrete)
    if discrete:
        turn = np.linspace(0, 2 * np.pi, 200)
        axes.plot(np.cos(turn), np.sin(turn), color=ink(axes), lw=0.7)
        axes.set_aspect("equal", adjustable="datalim")
    else:
        axes.axvline(0, color=ink(axes), lw=0.7)
    axes.margins(_RATE_ROOM)
    bottom, top = axes.get_ylim()
    axes.set_ylim(room_below(bottom, top, len(axes.get_legend_handles_labels()[1])), top)
    return finish_axes(
        axes, "Re z [1]" if discrete else "Re s [1/s]", "Im z [1]" if discrete else "Im s [rad/s]", legend="lower left"
    )


def _rate(axes: Axes, rate: float, look: dict[str, Any], *, discrete: bool) -> None:
    if discrete:
        turn = np.linspace(0, 2 * np.pi, 200)
        axes.plot(rate * np.cos(turn), rate * np.sin(turn), lw=1.8, **look)
    else:
        axes.axvline(-rate, lw=1.8, **look)


def _eigenvalues(certificate: Mapping[str, Any]) -> Reals:
    """The eigenvalues with gains of the class: one gain from end to end, several at random."""
    system, classes = certificate["system"], certificate["laws"]
    if system["kind"] in ("family", *CHANNELS):  # the plant in the middle of the box
        H = plants(dict(system)) if system["kind"] == "family" else matrices(dict(system))
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
    gains = low + shares * (high - low)
    if "late" in system:  # the rightmost roots, of which there are infinitely many
        sides = [[tuple(tuple(map(Fraction, row)) for row in side) for side in one[1:]] for one in system["late"]]
        late = tuple((Fraction(one[0]), rows) for one, (rows, *_) in zip(system["late"], sides, strict=True))
        roots = LateRoots(DelayMatrix(plant, late, tuple(back[0] for _, *back in sides if back)))
        return np.concatenate([roots.spectrum(row)[: 2 * plant.order + 2] for row in gains[::_FEW]])
    return np.asarray(np.linalg.eigvals(GainsAround(*plant.doubles()).closed_by(gains)).ravel())


# The amplitude of a steady response over frequency, with what is certified of it.

_AMPLITUDE_ROOM, _SHADE = 1.6, 0.25
_FEW_TICKS = 5.0  # between the ends of an axis, below which 1, 2, 5 are too few


def plot_steady(found: SteadyResponse, *, ax: Axes | None = None) -> Axes:
    """The largest ``|z|`` of steady responses against the frequency of the input, both axes logarithmic.

    Blue bars: certified at that frequency, whatever the start.  The dashed curve is harmonic balance in floating
    point, and the shade between the bars is interpolated: at other frequencies nothing is certified.  Orange and grey
    bars: steady responses that exist, certified, where others may; whether they attract what is near is computed.
    Crosses: computed alone.

    Parameters
    ----------
    found : SteadyResponse
        The answer, with an input.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.

    Raises
    ------
    InputError
        There is no response to draw.
    """
    rows = [row for row in found.response if row.omega and row.computed > 0]
    if not rows:
        raise InputError("the steady response has no amplitude at a frequency to draw; give forcing.amplitude")
    axes = axes_or_new(ax)
    shown = [row for row in rows if row.evidence is Evidence.CERTIFIED and math.isfinite(row.amplitude.high)]
    alone = [row for row in shown if row.alone]
    if len(alone) > 1:
        at, below, above = ([getattr(row, name) for row in alone] for name in ("omega", "low", "high"))
        axes.fill_between(at, below, above, color=BLUE, alpha=_SHADE, lw=0, label="interpolated between enclosures")
        label = "harmonic balance, computed"
        axes.plot(at, [row.computed for row in alone], "--", color=GREY, lw=1, label=label)
    _bars(axes, alone, BLUE, "certified, approached by all")
    _bars(
        axes,
        [row for row in shown if not row.alone and row.attracts],
        VERMILLION,
        "exists (certified), attracts nearby (computed)",
    )
    rest = [row for row in shown if not row.alone and not row.attracts]
    _bars(axes, rest, GREY, "exists (certified), does not attract (computed)")
    others = [row for row in rows if row not in shown]
    if others:
        at = [row.omega for row in others]
        axes.plot(at, [row.computed for row in others], "x", color=ink(axes), ms=4, label="computed")
    low, high = ([*(getattr(row, end) for row in shown), *(row.computed for row in rows)] for end in ("low", "high"))
    axes.set_ylim(min(value for value in low if value > 0) / _AMPLITUDE_ROOM, max(high) * _AMPLITUDE_ROOM)
    axes.set_xscale("log")
    axes.set_yscale("log")
    unit = "" if found.forcing is None or not found.forcing.unit else f" [{found.forcing.unit}]"
    axes.set_xlabel("ω [rad/s]")
    axes.set_ylabel(f"largest |z| of a steady response{unit}")
    _ticks(axes)
    return finish_axes(axes, legend="best")


def _bars(axes: Axes, rows: Sequence[SteadyPoint], color: str, label: str) -> None:
    """What is certified of some solutions."""
    if rows:
        low, high = (np.array([getattr(row, end) for row in rows]) for end in ("low", "high"))
        middle, at = (low + high) / 2, [row.omega for row in rows]
        axes.errorbar(at, middle, [middle - low, high - middle], fmt="_", color=color, ms=7, capsize=3, label=label)


def _ticks(axes: Axes) -> None:
    """Plain numbers on axes of less than two decades."""
    from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator

    for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        if high < 100 * low:
            few = high < _FEW_TICKS * low
            axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]) if few else LogLocator(subs=(1, 2, 5)))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.set_minor_locator(NullLocator())
