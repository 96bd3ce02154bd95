"""Figures of any Lur'e loop: how far each class is proved and where it is refuted, Nyquist and Popov plots, orbits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from lure.analysis.counterexamples.simulated import nonlinearity_entry, orbit_of
from lure.analysis.plots.style import (
    BLUE,
    GREEN,
    GREY,
    LEGEND,
    PURPLE,
    VERMILLION,
    axes_or_new,
    finish_axes,
    number,
    padded,
    panels,
)
from lure.analysis.questions.largest import StabilityBound
from lure.analysis.verdict import Evidence, Verdict
from lure.errors import InputError
from lure.plants.conversion import exact_block

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lure.analysis.counterexamples.trajectories import Trajectory
    from lure.analysis.verdict import Witness

# The periodic orbit of a counterexample: sigma over one period, and the nonlinearity it belongs to.

# Simulated solutions of a loop from several first states, on one figure.

_LINES = ((BLUE, "-"), (VERMILLION, (0, (5, 1.5))), (GREEN, (0, (1, 1))), (PURPLE, (0, (4, 1.2, 1, 1.2))))
_UNSEEN = 1e-9  # share of the largest |sigma| of all below which a solution is rounding
_ROOM = 0.5  # of the height of the curves, above them: the legend stands there


def plot_solutions(trajectories: Sequence[Trajectory], *, ax: Axes | None = None) -> Axes:
    """``sigma`` over time for the first few trajectories, each divided by its own largest ``|sigma|``.

    Simulated, hence OBSERVED: what one solution does proves nothing about another.

    Parameters
    ----------
    trajectories : sequence of Trajectory
        Of one loop, such as ``report.trajectories``; at most four are drawn, and none that ``sigma`` hardly shows.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.

    Raises
    ------
    InputError
        There is no trajectory.
    """
    if not trajectories:
        raise InputError("there is no trajectory to draw; give at least one")
    axes = axes_or_new(ax)
    seen_at_all = _UNSEEN * max(map(_largest, trajectories))
    shown = [one for one in trajectories if _largest(one) >= seen_at_all][: len(_LINES)]
    discrete = shown[0].discrete
    for (colour, dashes), one in zip(_LINES, shown, strict=False):
        seen, largest = np.isfinite(one.sigma), _largest(one)
        look: dict[str, Any] = {"marker": ".", "ms": 3, "lw": 0.7} if discrete else {"lw": 1.2}
        label = f"{one.finding}, largest |σ| {number(largest, 3)}"
        axes.plot(one.t[seen], one.sigma[seen] / (largest or 1.0), color=colour, ls=dashes, label=label, **look)
    axes.axhline(0.0, color=GREY, lw=0.6, zorder=1)
    axes.set_ylim(-1.1, 1.1 + _ROOM * 2.2)
    axes.set_yticks([-1, -0.5, 0, 0.5, 1])
    end = max(float(one.t[-1]) for one in shown)
    axes.set_xlim(0.0, end or 1.0)
    return finish_axes(axes, f"t [{shown[0].unit}]", "σ / largest |σ|", legend="upper right")


def plot_channels(trajectory: Trajectory, *, ax: Axes | None = None) -> Axes:
    """``sigma_i`` and, below, ``mu_i = -phi_i(sigma_i)`` over time along one solution of a loop with several channels.

    Simulated, hence OBSERVED: what one solution does proves nothing about another.

    Parameters
    ----------
    trajectory : Trajectory
        With ``sigma`` and ``mu`` (samples, m); the first four channels are drawn.
    ax : Axes, optional
        Whose place the two take; by default a new figure.

    Returns
    -------
    Axes
        The upper axes; those of ``mu`` share its times.
    """
    above, below = panels(ax, 1.0)
    look: dict[str, Any] = {"marker": ".", "ms": 3, "lw": 0.7} if trajectory.discrete else {"lw": 1.2}
    for axes, values, name in ((above, trajectory.sigma, "σ"), (below, trajectory.mu, "μ")):
        drawn = np.where(np.isfinite(values), values, np.nan)
        for i, (colour, dashes) in enumerate(_LINES[: values.shape[1]]):
            axes.plot(trajectory.t, drawn[:, i], color=colour, ls=dashes, label=f"channel {i + 1}", **look)
        axes.axhline(0.0, color=GREY, lw=0.6, zorder=1)
        axes.set_ylabel(f"{name}ᵢ [unit of {name}]")
    above.set_xlim(0.0, float(trajectory.t[-1]) or 1.0)
    above.tick_params(labelbottom=False)
    below.set_xlabel(f"t [{trajectory.unit}]")
    finish_axes(above)
    finish_axes(below)
    above.legend(loc="upper right", ncols=2, **LEGEND)
    return above


def _largest(one: Trajectory) -> float:
    return float(np.max(np.abs(one.sigma[np.isfinite(one.sigma)]), initial=0.0))


_STANDING = {Evidence.CERTIFIED: "certified orbit", Evidence.COMPUTED: "computed orbit"}


def plot_orbit(block: object, witness: Witness, *, ax: Axes | None = None) -> Axes:
    """``sigma`` over one period of the orbit of a witness, with the places where its nonlinearity bends.

    The curve is drawn in floating point; that there is an orbit is what ``witness.evidence`` says.

    Parameters
    ----------
    block : object
        The block that the witness was found for, whatever :func:`lure.as_plant` takes.
    witness : Witness
        Of kind ``periodic orbit``, such as ``max_slope(block).witness``.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.

    Raises
    ------
    InputError
        The witness is no periodic orbit, the block is not the one it was found for, or it has no exact coefficients.
    """
    linear = exact_block(block, "plot_orbit")
    t, sigma = orbit_of(linear, witness)
    axes = axes_or_new(ax)
    name = _STANDING.get(witness.evidence, "observed orbit")
    if linear.dt is None:
        axes.plot(t, sigma, color=VERMILLION, lw=1.5, label=f"{name}, period {t[-1]:.4g} s")
        axes.set_xlabel("t [s]")
    else:
        axes.plot(t, sigma, color=VERMILLION, lw=0.8, marker="o", ms=5, label=f"{name}, period {len(t) - 1} samples")
        axes.set_xlabel("t [samples]")
        axes.set_xticks(t[:: 1 + len(t) // 12])
    bends = [float(Fraction(x)) for x, _ in cast("Sequence[Sequence[str]]", witness.data["points"])]
    low, high = padded(float(sigma.min()), float(sigma.max()), 0.1)
    for i, place in enumerate(x for x in bends if linear.dt is None and low < x < high):
        axes.axhline(place, color=BLUE, lw=0.9, ls="--", label="where φ bends" if i == 0 else None, zorder=1)
    axes.axhline(0.0, color=GREY, lw=0.6, zorder=1)
    axes.set_xlim(t[0], t[-1])
    axes.set_ylim(low, high + 0.25 * (high - low))  # room for the legend above the curve
    axes.set_ylabel("σ [unit of σ]")
    finish_axes(axes)
    axes.legend(loc="upper right", ncols=2, **LEGEND)
    return axes


def plot_orbit_signals(block: object, witness: Witness, *, ax: Axes | None = None) -> Axes:
    """``sigma`` and, below it, ``mu = -phi(sigma)`` over one period of the orbit of a witness.

    Parameters
    ----------
    block : object
        The block that the witness was found for, whatever :func:`lure.as_plant` takes.
    witness : Witness
        Of kind ``periodic orbit``.
    ax : Axes, optional
        Whose place the two take; by default a new figure.

    Returns
    -------
    Axes
        The upper axes; those of ``mu`` share its times.

    Raises
    ------
    InputError
        The witness is no periodic orbit, the block is not the one it was found for, or it has no exact coefficients.
    """
    linear = exact_block(block, "plot_orbit_signals")
    t, sigma = orbit_of(linear, witness)
    mu = -np.asarray(nonlinearity_entry(witness)(sigma), dtype=float)
    above, below = panels(ax, 1.0)
    discrete = linear.dt is not None
    look: dict[str, Any] = {"marker": "o", "ms": 4, "lw": 0.8} if discrete else {"lw": 1.5}
    for axes, values, colour, name in ((above, sigma, VERMILLION, "σ"), (below, mu, BLUE, "μ")):
        axes.plot(t, values, color=colour, **look)
        axes.axhline(0.0, color=GREY, lw=0.6, zorder=1)
        axes.set_ylim(*padded(float(values.min()), float(values.max()), 0.1))
        axes.set_ylabel(f"{name} [unit of {name}]")
    above.set_xlim(t[0], t[-1])
    above.tick_params(labelbottom=False)
    below.set_xlabel("t [samples]" if discrete else "t [s]")
    finish_axes(above)
    finish_axes(below)
    return above


def plot_nonlinearity(witness: Witness, *, ax: Axes | None = None) -> Axes:
    """The piecewise linear nonlinearity of a periodic orbit over all that the orbit visits.

    Parameters
    ----------
    witness : Witness
        With ``points`` in its data; ``sigma`` or ``visited``, ``left_slope`` and ``right_slope`` where there are any.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.
    """
    axes = axes_or_new(ax)
    points = cast("Sequence[Sequence[str]]", witness.data["points"])
    x, y = (np.array([float(Fraction(point[i])) for point in points]) for i in (0, 1))
    slopes = [float(Fraction(str(witness.data.get(side, 0)))) for side in ("left_slope", "right_slope")]
    span = cast("Sequence[float]", witness.data.get("visited", (x[0], x[-1])))
    low, high = min(x[0], span[0]), max(x[-1], span[1])
    room = 0.08 * (high - low) if "visited" in witness.data else 0.25 * (high - low)
    ends = np.array([low - room, high + room])
    heights = [y[0] + slopes[0] * (ends[0] - x[0]), y[-1] + slopes[1] * (ends[1] - x[-1])]
    corners, values = np.array([ends[0], *x, ends[1]]), np.array([heights[0], *y, heights[1]])
    axes.plot(corners, values, color=BLUE, lw=1.4, label="φ")
    if "sigma" in witness.data:
        visited = [float(Fraction(value)) for value in cast("Sequence[str]", witness.data["sigma"])]
        axes.plot(visited, np.interp(visited, x, y), marker="o", ms=4, ls="", color=VERMILLION, label="visited")
    elif "visited" in witness.data:
        swept = np.array([span[0], *x[(x > span[0]) & (x < span[1])], span[1]])
        axes.plot(
            swept, np.interp(swept, corners, values), color=VERMILLION, lw=3.5, alpha=0.5, label="visited by the orbit"
        )
    axes.axhline(0.0, color=GREY, lw=0.6)
    axes.axvline(0.0, color=GREY, lw=0.6)
    return finish_axes(axes, "σ [unit of σ]", "φ(σ) [unit of μ]", legend="upper left")


def plot_largest(rows: Sequence[StabilityBound], names: Sequence[str], *, ax: Axes | None = None) -> Axes:
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
        words = f"{name}: {_bracket_words(row)}"
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
    if all(row.largest.low == math.inf and row.refuted_at is None for row in rows):
        axes.set_xticks([start])  # the bars have no end, and other ticks would measure nothing
    room = 0.5 * max(3 - len(rows), 0)  # a lone bar stays a bar
    axes.set_ylim(-0.45 - room, len(rows) + 0.35 + room)
    several = bool(rows) and rows[0].classes is not None
    name = "factor k of every upper bound" if several else "upper end k of the class [unit of μ / unit of σ]"
    axes.set_xlabel(name + (", logarithmic" if wide else ""))
    finish_axes(axes)
    axes.legend(loc="upper center", ncols=4, columnspacing=1.0, borderaxespad=0.0, **LEGEND)
    return axes


def _range(rows: Sequence[StabilityBound]) -> tuple[float, float, bool]:
    """Ends of the axis of ``k``, and whether it is logarithmic."""
    ends = [value for row in rows for value in (row.refuted_at, row.hurwitz.high) if value]
    marks = [abs(value) for value in ends + [row.largest.low for row in rows if not row.search_limited] if value]
    tried = [row.largest.low for row in rows if row.search_limited]  # where nothing else ends: beyond is unknown
    finite = [value for value in marks if 0 < value < math.inf] or tried
    lower = min(float(row.lower) for row in rows)
    if not finite:
        return min(lower, 0.0), max(lower, 0.0) + 1.0, False
    largest, smallest = max(finite), min(finite)
    if lower == 0 and largest > 50 * smallest:
        return 0.3 * smallest, 3.0 * largest, True
    room = 0.2 * (largest - min(lower, 0.0))
    return min(lower, 0.0), largest + room, False


def _bracket_words(row: StabilityBound) -> str:
    words = []
    if row.verdict is Verdict.PROVED:
        words.append("every finite k proved" if row.largest.low == math.inf else f"proved to {row.proved_up_to}")
    if row.refuted_at is not None:
        words.append(f"refuted at {row.refuted_text}")
    return ", ".join(words) or "unknown"
