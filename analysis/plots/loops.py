"""Figures of any Lur'e loop: how far each class is proved and where it is refuted, Nyquist and Popov plots, orbits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from lure.analysis.graphical.axis import OnAxis
from lure.analysis.inequality.checks import CriterionResult
from lure.analysis.plots.nyquist import plot_nyquist
from lure.analysis.plots.popov import plot_popov
from lure.analysis.plots.style import BLUE, GREEN, GREY, LEGEND, VERMILLION, axes_or_new, finish_axes
from lure.analysis.questions.largest import StabilityBound, proved_up_to
from lure.analysis.verdict import Evidence, Verdict
from lure.classes import Sector
from lure.plants.delay import DelayPlant
from lure.plants.rational import RationalPlant

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_reach(rows: Sequence[StabilityBound], names: Sequence[str], *, ax: Axes | None = None) -> Axes:
    """One bar a class: proved up to its end, refuted from its cross on, and in between unknown.

    Parameters
    ----------
    rows : sequence of StabilityBound
        The answers, drawn from top to bottom.
    names : sequence of str
        A name for each.
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    axes = axes_or_new(ax)
    start, end, wide = _range(rows)
    labels: set[str] = set()

    def once(text: str) -> str | None:
        """A legend entry the first time it is asked for, then None."""
        fresh = text not in labels
        labels.add(text)
        return text if fresh else None

    for place, (row, name) in enumerate(zip(reversed(rows), reversed(names), strict=True)):
        left = start if wide else float(row.lower)
        low = max(min(row.largest.low, end), left) if row.verdict is Verdict.PROVED else left
        against = end if row.refuted_at is None else max(min(row.refuted_at, end), low)
        if low > left:
            axes.barh(place, low - left, left=left, color=BLUE, height=0.34, label=once("proved"))
        if against > low:
            axes.barh(place, against - low, left=low, color="none", edgecolor=GREY, hatch="////", lw=0.5,
                      height=0.34, label=once("unknown"))  # fmt: skip
        if row.refuted_at is not None and against < end:
            axes.barh(place, end - against, left=against, color=VERMILLION, alpha=0.25, height=0.34)
            axes.plot([against], [place], marker="X", ms=7, ls="", color=VERMILLION, label=once("counterexample"))
        words = f"{name}: {_reach_words(row)}"
        paper = {"facecolor": axes.get_facecolor(), "edgecolor": "none", "pad": 0.5}  # no line runs through the words
        axes.text(
            0.0, place + 0.24, words, transform=axes.get_yaxis_transform(), fontsize="small", va="bottom", bbox=paper
        )
    limit = rows[0].hurwitz.high
    if start < limit < end:
        axes.axvline(limit, color=GREEN, lw=1.2, ls="--", zorder=0, label="linear gains")
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    if wide:
        axes.set_xscale("log")
    axes.set_xlim(start, end)
    room = 0.5 * max(3 - len(rows), 0)  # a lone bar stays a bar
    axes.set_ylim(-0.45 - room, len(rows) + 0.35 + room)
    axes.set_xlabel("upper end k of the class [unit of μ / unit of σ]" + (", logarithmic" if wide else ""))
    finish_axes(axes)
    axes.legend(loc="upper center", ncols=4, columnspacing=1.0, borderaxespad=0.0, **LEGEND)
    return axes


def _range(rows: Sequence[StabilityBound]) -> tuple[float, float, bool]:
    """Ends of the axis of ``k``, and whether it is logarithmic."""
    ends = [value for row in rows for value in (row.refuted_at, row.hurwitz.high) if value]
    marks = [abs(value) for value in ends + [row.largest.low for row in rows if not row.search_limited] if value]
    finite = [value for value in marks if 0 < value < math.inf]
    lower = min(float(row.lower) for row in rows)
    if not finite:
        return min(lower, 0.0), max(lower, 0.0) + 1.0, False
    largest, smallest = max(finite), min(finite)
    if lower == 0 and largest > 50 * smallest:
        return 0.3 * smallest, 3.0 * largest, True
    room = 0.2 * (largest - min(lower, 0.0))
    return min(lower, 0.0), largest + room, False


def _reach_words(row: StabilityBound) -> str:
    words = []
    if row.verdict is Verdict.PROVED:
        words.append("every finite k proved" if row.largest.low == math.inf else f"proved to {proved_up_to(row)}")
    if row.refuted_at is not None:
        words.append(f"refuted at {row.refuted_text}")
    return ", ".join(words) or "unknown"


def plot_loop_nyquist(block: RationalPlant | DelayPlant, k: float, *, ax: Axes | None = None) -> Axes:
    """Nyquist plot of any block with the half-plane that the circle criterion forbids for ``[0, k]``.

    Parameters
    ----------
    block : RationalPlant or DelayPlant
        The block.
    k : float
        Upper end of the sector.
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    seen = OnAxis(block)
    axes = plot_nyquist(seen, Sector(0, k), omega=seen.frequencies(), ax=ax)
    if k == math.inf:  # every finite sector has its boundary further left
        for patch in axes.patches:
            patch.set_label("forbidden: Re H < 0")
    if seen.discrete:
        axes.set_xlabel("Re H(exp iω) [unit of σ / unit of μ]")
        axes.set_ylabel("Im H(exp iω) [unit of σ / unit of μ]")
        axes.lines[0].set_label("H(exp iω), 0 < ω < π")
    axes.legend(loc="best", **LEGEND)
    return axes


def plot_loop_popov(block: RationalPlant | DelayPlant, k: float, theta: float, *, ax: Axes | None = None) -> Axes:
    """Popov plot of any block in continuous time with the line through ``-1/k`` of slope ``1/theta``.

    Parameters
    ----------
    block : RationalPlant or DelayPlant
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
