"""Figures of any Lur'e loop: how far each class is proved and where it is refuted, Nyquist and Popov plots, orbits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.criteria.result import CriterionResult
from analysis.evidence import Evidence, Verdict
from analysis.plots.nyquist import plot_nyquist
from analysis.plots.popov import plot_popov
from analysis.plots.style import BLUE, GREEN, GREY, LEGEND, VERMILLION, axes_or_new, finish_axes, number
from lure.delay import DelayBlock
from lure.rational import RationalBlock
from lure.sector import Sector

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from analysis.answers.largest import Largest
    from analysis.witness import Witness

POINTS = 1500


@dataclass(frozen=True, eq=False, slots=True)
class OnAxis:
    """A block along its stability boundary: ``H(i omega)``, or ``H(e^(i omega))`` with ``omega`` in rad per sample."""

    block: RationalBlock | DelayBlock

    def transfer(self, s: ArrayLike) -> NDArray[np.complex128]:
        """``H`` at ``s = i omega``, or at ``z = exp(s)``."""
        points = np.asarray(s, dtype=complex)
        discrete = isinstance(self.block, RationalBlock) and self.block.dt is not None
        return self.block.transfer(np.exp(points) if discrete else points)

    def frequencies(self) -> NDArray[np.float64]:
        """Frequencies at which the curve looks as it is: a logarithmic grid, refined around every resonance."""
        roots = np.roots([float(c) for c in self.block.denominator])
        if isinstance(self.block, RationalBlock) and self.block.dt is not None:
            roots = np.log(roots[np.abs(roots) > 1e-6])
            low, high = 1e-3, math.pi
        else:
            sizes = [size for size in np.abs(roots).tolist() if size > 1e-9] or [1.0]
            low, high = 1e-2 * min(sizes), 1e2 * max(sizes)
        across = np.tan(np.linspace(-1.5, 1.5, 101))
        near = [abs(root.imag) + abs(root.real) * across for root in roots.tolist() if root.imag]
        omega = np.unique(np.concatenate([np.geomspace(low, high, POINTS), *near]))
        return np.asarray(omega[(omega >= low) & (omega <= high)])


def plot_reach(rows: Sequence[Largest], names: Sequence[str], *, ax: Axes | None = None) -> Axes:
    """One bar a class: proved up to its end, refuted from its cross on, and in between unknown.

    Parameters
    ----------
    rows : sequence of Largest
        The answers, drawn from top to bottom.
    names : sequence of str
        A name for each.
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    axes = axes_or_new(ax)
    marks = [value for row in rows for value in (row.largest.low, row.refuted_at, row.hurwitz.high) if value]
    finite = [value for value in marks if 0 < value < math.inf]
    end = 1.15 * max(finite) if finite else 1.0
    smallest = min(finite, default=1.0)
    wide = end > 200 * smallest and all(row.lower == 0 for row in rows)
    start = 0.3 * smallest if wide else min(0.0, *(float(row.lower) for row in rows))
    for place, row in enumerate(reversed(rows)):
        low = min(row.largest.low, end) if row.verdict is Verdict.PROVED else start
        beyond = end if row.refuted_at is None else min(row.refuted_at, end)
        left = start if wide else float(row.lower)
        axes.barh(place, low - left, left=left, height=0.5, color=BLUE, label="proved" if place == 0 else None)
        if beyond > low:
            axes.barh(place, beyond - low, left=low, height=0.5, color="none", edgecolor=GREY, hatch="///", lw=0.5,
                      label="unknown" if place == 0 else None)  # fmt: skip
        if row.refuted_at is not None and row.refuted_at < end:
            axes.plot([row.refuted_at], [place], marker="X", ms=8, ls="", color=VERMILLION,
                      label="counterexample" if place == 0 else None)  # fmt: skip
    limit = rows[0].hurwitz.high
    if math.isfinite(limit):
        axes.axvline(limit, color=GREEN, lw=1.2, ls="--", label="limit of linear gains")
    axes.set_yticks(range(len(rows)), list(reversed(names)))
    if wide:
        axes.set_xscale("log")
    axes.set_xlim(start, end)
    axes.set_ylim(-0.6, len(rows) + 0.4)
    axes.set_xlabel("upper bound k of the class [unit of μ / unit of σ]")
    finish_axes(axes)
    axes.legend(loc="upper left", ncols=2, **LEGEND)
    return axes


def plot_loop_nyquist(block: RationalBlock | DelayBlock, k: float, *, ax: Axes | None = None) -> Axes:
    """Nyquist plot of any block with the half-plane that the circle criterion forbids for ``[0, k]``.

    Parameters
    ----------
    block : RationalBlock or DelayBlock
        The block.
    k : float
        Upper end of the sector.
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    seen = OnAxis(block)
    return plot_nyquist(seen, Sector(0, k), omega=seen.frequencies(), ax=ax)


def plot_loop_popov(block: RationalBlock | DelayBlock, k: float, theta: float, *, ax: Axes | None = None) -> Axes:
    """Popov plot of any block in continuous time with the line through ``-1/k`` of slope ``1/theta``.

    Parameters
    ----------
    block : RationalBlock or DelayBlock
        The block.
    k : float
        Upper end of the sector.
    theta : float
        Multiplier [s].
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    seen = OnAxis(block)
    result = CriterionResult(
        name="popov",
        model="loop",
        sector=Sector(0, k),
        verdict=Verdict.INCONCLUSIVE,
        evidence=Evidence.OBSERVED,
        theta=theta,
        smallest_theta=None,
        margin=None,
        worst_frequency=None,
        largest_sector=None,
        reason="a drawing",
    )
    return plot_popov(seen, result, omega=seen.frequencies(), ax=ax)


def plot_law(witness: Witness, *, ax: Axes | None = None) -> Axes:
    """The law of a periodic orbit in discrete time, and the points of it that the orbit visits.

    Parameters
    ----------
    witness : Witness
        With ``points`` and ``sigma`` in its data.
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    axes = axes_or_new(ax)
    points = cast("Sequence[Sequence[str]]", witness.data["points"])
    x, y = ([float(Fraction(point[i])) for point in points] for i in (0, 1))
    room = 0.25 * (max(x) - min(x))
    axes.plot([min(x) - room, *x, max(x) + room], [y[0], *y, y[-1]], color=BLUE, lw=1.4, label="φ")
    visited = [float(Fraction(value)) for value in cast("Sequence[str]", witness.data["sigma"])]
    axes.plot(visited, np.interp(visited, x, y), marker="o", ms=5, ls="", color=VERMILLION, label="visited")
    axes.axhline(0.0, color=GREY, lw=0.6)
    axes.axvline(0.0, color=GREY, lw=0.6)
    axes.set_xlabel("σ")
    axes.set_ylabel(f"φ(σ), slope at most {number(witness.k)}")
    finish_axes(axes)
    axes.legend(loc="upper left", **LEGEND)
    return axes
