"""Regions: of states that are attracted, of upper bounds and of parameters for which a loop is stable."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from lure.analysis.plots.style import BLUE, GREY, VERMILLION, axes_or_new, finish_axes, ink
from lure.analysis.questions.channel_map import StabilityMap
from lure.analysis.questions.margins import Margin, Tolerances
from lure.analysis.questions.region_curves import drawn, gauge
from lure.analysis.questions.region_sets import levels
from lure.analysis.questions.regions import RegionOfAttraction
from lure.arrays import NDArray
from lure.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.patches import Rectangle

    from lure.plants.family import Box

_GRID, _ROOM, _STEPS, _STARTS = 240, 1.5, 1500, 8


def plot_region(found: RegionOfAttraction, *, plane: tuple[int, int] = (1, 2), ax: Axes | None = None) -> Axes:
    """The sets that are known in the plane of two states; with more states a slice, the others being 0.

    Blue: solutions that start there tend to 0.  Hatched: no solution that starts there does.  White: nothing is known.
    With one state ``x'`` (in discrete time the step ``x+ - x``) is drawn against it.

    Parameters
    ----------
    found : RegionOfAttraction
        The sets, from :func:`lure.analysis.region`.
    plane : tuple of int
        The two states, counted from 1.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.

    Raises
    ------
    InputError
        The plane is none of two different states.
    """
    axes = axes_or_new(ax)
    if found.states == 1:
        return _line(found, axes)
    i, j = plane
    if i == j or not all(isinstance(k, int) and 1 <= k <= found.states for k in plane):
        raise InputError(f"plane is {plane!r:.40}; give two different states, from 1 to {found.states}")
    i, j = i - 1, j - 1
    halves = _halves(found, (i, j))
    x, y = (np.linspace(-half, half, _GRID + 1) for half in halves)
    points = np.zeros(((_GRID + 1) ** 2, found.states))
    points[:, i], points[:, j] = (part.ravel() for part in np.meshgrid(x, y))
    shape = (_GRID + 1, _GRID + 1)
    _outside(found, axes, (x, y), points)
    for number, one in enumerate(found.sets):
        values = np.minimum(one.values(points).reshape(shape), 4.0) if one.bounded else np.zeros(shape)
        axes.contourf(x, y, values, levels=[-1e300, 1.0], colors=[BLUE], alpha=0.35)
        axes.contour(x, y, values, levels=[1.0], colors=[BLUE], linestyles=["-", "--", "-."][number % 3])
        if one.kind not in (before.kind for before in found.sets[:number]):
            axes.fill_between([], [], [], color=BLUE, alpha=0.35, label=f"tends to 0 ({one.kind})")
    rate = _rate(found)
    if found.states == 2 and rate is not None:
        if not found.discrete:
            field = rate(points)
            speed = np.maximum(np.linalg.norm(field, axis=1), 1e-300)
            flow = [(field[:, k] / speed * 1.0).reshape(shape) for k in (0, 1)]
            axes.streamplot(x, y, flow[0], flow[1], color=GREY, linewidth=0.5, density=0.8, arrowsize=0.7)
        _solutions(found, axes, rate, halves)
    axes.plot(0, 0, "o", color=ink(axes), ms=4)
    others = [(float(x[i]), float(x[j])) for x in found.equilibria] if found.states == 2 else []
    shown = [place for place in others if abs(place[0]) < halves[0] and abs(place[1]) < halves[1]]
    if shown:
        axes.plot(*zip(*shown, strict=True), "s", color=VERMILLION, mfc="white", ms=5, label="other equilibria")
    axes.set_xlim(-halves[0], halves[0])
    axes.set_ylim(-halves[1], halves[1])
    return finish_axes(
        axes, f"state {i + 1}", f"state {j + 1}" + (", the others 0" if found.states > 2 else ""), legend="upper right"
    )


def flow_drawn(found: RegionOfAttraction) -> tuple[bool, bool]:
    """Whether :func:`plot_region` draws the field, and solutions, of a loop with two states; ``found``: the sets."""
    known = found.states == 2 and _rate(found) is not None
    return known and not found.discrete, known and bool(found.sets) and found.sets[0].bounded


def _outside(
    found: RegionOfAttraction, axes: Axes, grid: tuple[NDArray[np.float64], ...], points: NDArray[np.float64]
) -> None:
    shape = (_GRID + 1, _GRID + 1)
    for one in found.outside:
        if one.points is None:
            values = np.einsum("ki,ij,kj->k", points, np.array(one.Q, dtype=float), points).reshape(shape)
        else:
            values = gauge(one.points)(points).reshape(shape)
        hatched = axes.contourf(*grid, values, levels=[1.0, 1e300], colors=["none"], hatches=["///"])
        hatched.set_edgecolor(VERMILLION)
        hatched.set_linewidth(0.0)
        axes.contour(*grid, values, levels=[1.0], colors=[VERMILLION], linewidths=1.0)
    if found.outside:
        axes.fill_between([], [], [], facecolor="none", hatch="///", edgecolor=VERMILLION, label="never tends to 0")


def _halves(found: RegionOfAttraction, plane: tuple[int, int]) -> tuple[float, float]:
    """Half the sides of what is drawn: the sets with some room, and with a bounded region all of it."""
    widths = [1e-12, 1e-12]
    matrices = [one.least() for one in found.sets if one.P is not None]
    matrices += [np.array(one.Q, dtype=float) for one in found.outside if one.Q is not None]
    for matrix in matrices:
        part = matrix[np.ix_(plane, plane)]
        if np.linalg.eigvalsh(part)[0] > 0:
            half = np.sqrt(np.diag(np.linalg.inv(part)))
            widths = [max(a, float(b)) for a, b in zip(widths, half, strict=True)]
    for points in (*(one.points for one in found.sets), *(one.points for one in found.outside)):
        if points is not None:
            half = np.abs(drawn(points)).max(axis=0)[list(plane)]
            widths = [max(a, float(b)) for a, b in zip(widths, half, strict=True)]
    room = _ROOM if min(widths) > 1e-12 else 1e12
    return widths[0] * room, widths[1] * room


def _rate(found: RegionOfAttraction) -> Callable[[NDArray[np.float64]], Any] | None:
    """``x'``, in discrete time the next state, at points; None where a direct term leads back to its channel."""
    groups = None if found.plant is None else levels(found.plant.D)
    if found.plant is None or groups is None or not all(map(callable, found.nonlinearities)):
        return None
    A, B, C, D = found.plant.doubles()
    laws = found.nonlinearities

    def rate(points: NDArray[np.float64]) -> NDArray[np.float64]:
        """At points, (k, n)."""
        phi, seen = np.zeros((len(points), len(laws))), points @ C.T
        for group in groups:
            sigma = seen[:, group] - phi @ D[group].T
            phi[:, group] = np.stack([laws[i](sigma[:, k]) for k, i in enumerate(group)], axis=1)
        return np.asarray(points @ A.T - phi @ B.T)

    return rate


def _solutions(found: RegionOfAttraction, axes: Axes, rate: Callable[..., Any], halves: tuple[float, float]) -> None:
    """Some solutions that start at the edge of the first set."""
    if not found.sets or not found.sets[0].bounded:
        return
    angles = 2 * np.pi * (np.arange(_STARTS) + 0.5) / _STARTS
    rays = np.column_stack([halves[0] * np.cos(angles), halves[1] * np.sin(angles)])
    low, high = np.zeros(len(rays)), np.ones(len(rays))
    for _ in range(40):
        middle = (low + high) / 2
        inside = found.sets[0].values(middle[:, None] * rays) <= 1
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    x = 0.99 * low[:, None] * rays
    path = [x]
    assert found.plant is not None, "there is a rate"
    A = found.plant.doubles()[0]
    step = 0.02 / max(float(np.linalg.norm(A, 2)), 1e-9)
    for _ in range(60 if found.discrete else _STEPS):
        if found.discrete:
            x = rate(x)
        else:
            k = rate(x)
            x = x + step * rate(x + step / 2 * k)
        path.append(x)
    looks = {"marker": ".", "ms": 3, "lw": 0.6} if found.discrete else {"lw": 1.0}
    for number, line in enumerate(np.swapaxes(np.array(path), 0, 1)):
        axes.plot(*line.T, color=ink(axes), label="solutions" if number == 0 else None, **looks)


def _line(found: RegionOfAttraction, axes: Axes) -> Axes:
    """One state: where ``x'`` points, and the interval."""
    intervals = [one.interval for one in found.sets] + [one.interval for one in found.outside]
    ends = [abs(float(end)) for pair in intervals if pair is not None for end in pair]
    ends += [float(one.P[0][0]) ** -0.5 for one in found.sets if one.P is not None]
    half = 1.6 * max((end for end in ends if np.isfinite(end)), default=1.0)
    x = np.linspace(-half, half, 801)[:, None]
    rate = _rate(found)
    if rate is not None:
        axes.plot(x[:, 0], rate(x)[:, 0] - x[:, 0] * bool(found.discrete), color=ink(axes), lw=1.2)
    axes.axhline(0, color=GREY, lw=0.6)
    for one in found.sets:
        end = float("inf") if one.P is None else float(one.P[0][0]) ** -0.5
        low, high = (max(-half, min(half, float(v))) for v in (one.interval or (-end, end)))
        axes.axvspan(low, high, color=BLUE, alpha=0.25, label="tends to 0")
    for beyond in found.outside:
        assert beyond.interval is not None, "with one state"
        low, high = (float(v) for v in beyond.interval)
        for number, (a, b) in enumerate(((-half, low), (high, half))):
            if a < b:
                words = "never tends to 0" if number == 0 else None
                axes.axvspan(a, b, facecolor="none", hatch="///", edgecolor=VERMILLION, alpha=0.6, label=words)
    axes.set_xlim(-half, half)
    return finish_axes(
        axes, "state", "step of the state" if found.discrete else "rate of the state [1/s]", legend="upper right"
    )


# What is proved and refuted in a plane: of the upper bounds of two nonlinearities, or of parameters of the plant.

# The map of the upper bounds of two nonlinearities.

_FARTHEST = 1.2  # of the farthest corner that is drawn


def plot_map(found: StabilityMap, *, ax: Axes | None = None) -> Axes:
    """The plane of the upper bounds ``(k1, k2)``: proved, refuted, and hatched what is open.

    Each region is a union of rectangles: a proof for a pair holds for all smaller ones, a counterexample for all
    larger ones.

    Parameters
    ----------
    found : StabilityMap
        The map, such as ``analyse(loop).map``.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.
    """
    axes = axes_or_new(ax)
    proved, refuted = found.proved, found.refuted
    low = [float(v) for v in found.lower]
    ends = []
    for i in range(2):
        asked = float(found.asked[i])
        seen = [asked, *(c[i] for c in refuted)] if refuted else [asked, 4 * asked]
        ends.append(low[i] + _FARTHEST * (_typical(seen) - low[i]))
    x, y = [
        np.unique([low[i], ends[i], *(c[i] for c in (*proved, *refuted) if low[i] < c[i] < ends[i])]) for i in (0, 1)
    ]
    middle = [(axis[:-1] + axis[1:]) / 2 for axis in (x, y)]
    known = np.zeros((len(middle[1]), len(middle[0])))
    for j, b in enumerate(middle[1]):
        for i, a in enumerate(middle[0]):
            known[j, i] = any(a <= c and b <= d for c, d in proved) - any(a >= c and b >= d for c, d in refuted)
    looks = ((1, BLUE, "", "proved"), (0, "white", "////", "open"), (-1, VERMILLION, "xx", "refuted"))
    for value, colour, hatch, label in looks:
        if not (known == value).any():
            continue
        for j, i in zip(*np.nonzero(known == value), strict=True):
            corners = ([x[i], x[i + 1]], y[j], y[j + 1])
            axes.fill_between(*corners, facecolor=colour, alpha=0.75, hatch=hatch, edgecolor=GREY, linewidth=0.0)
        axes.fill_between(
            [], [], [], facecolor=colour, alpha=0.75, hatch=hatch, edgecolor=GREY, linewidth=0.0, label=label
        )
    inside = [float(found.asked[i]) for i in (0, 1)]
    if all(v < end for v, end in zip(inside, ends, strict=True)):
        axes.plot(*inside, "o", color=ink(axes), mfc="white", ms=6, label="asked about", zorder=4)
    axes.set_xlim(low[0], ends[0])
    axes.set_ylim(low[1], ends[1])
    return finish_axes(axes, found.bounded[0], found.bounded[1], legend="upper right")


def _typical(seen: list[float]) -> float:
    """The end of an axis: the farthest corner, without those many times as far as the middle one."""
    ordered = sorted(seen)
    most = 4 * ordered[len(ordered) // 2] if ordered[len(ordered) // 2] > 0 else ordered[-1]
    return max(v for v in ordered if v <= most) if most > 0 else 1.0


# Boxes of parameters: what is given, what is proved, and plants that refute.

_MARGIN, _LEGEND = 0.12, 0.3


def plot_tolerances(found: Tolerances, *, ax: Axes | None = None) -> Axes:
    """Of two parameters the boxes in their plane, else how wide each interval may be, in widths of the one given.

    Blue is certified for every plant; an orange cross is a plant that refutes the class; white is open.

    Parameters
    ----------
    found : Tolerances
        The answer.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.
    """
    axes = axes_or_new(ax)
    (_plane if len(found.family.names) == 2 else _bars)(axes, found)
    return finish_axes(axes, legend="upper right")


def _plane(axes: Axes, found: Tolerances) -> None:
    labelled = False
    for margin in found.margins:
        if margin.proved is not None:
            label = None if labelled else "certified for every plant in it"
            axes.add_patch(_rectangle(margin.proved, facecolor=BLUE, alpha=0.35, lw=0, label=label))
            labelled = True
    points = [[float(v) for v in point] for point in map(_point, found.margins) if point is not None]
    axes.add_patch(_rectangle(found.family.box, fill=False, edgecolor=ink(axes), lw=1.4, label="as given"))
    if points:
        axes.plot(*zip(*points, strict=True), "x", color=VERMILLION, mew=1.8, label="a plant that refutes")
    axes.margins(_MARGIN)
    axes.autoscale_view()
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + _LEGEND * (top - bottom))
    axes.set_xlabel(found.family.names[0])
    axes.set_ylabel(found.family.names[1])


def _rectangle(box: Box, **look: object) -> Rectangle:
    from matplotlib.patches import Rectangle

    (left, right), (bottom, top) = ([float(end) for end in ends] for ends in box)
    return Rectangle((left, bottom), right - left, top - bottom, **look)  # type: ignore[arg-type]  # as matplotlib has it


def _point(margin: Margin) -> list[Fraction] | None:
    """The parameters of the plant that refutes."""
    return None if margin.refutation is None else [Fraction(v) for v in margin.refutation.certificate["proof"]["at"]]


def _bars(axes: Axes, found: Tolerances) -> None:
    names = [margin.parameters[0] if len(margin.parameters) == 1 else "all" for margin in found.margins]
    for place, margin in enumerate(found.margins):
        label = "every plant, certified" if place == 0 else None
        axes.barh(place, margin.width.low, height=0.5, color=BLUE, alpha=0.6, label=label)
        if math.isfinite(margin.width.high):
            mark = "a plant refutes" if place == 0 else None
            axes.plot(margin.width.high, place, "x", color=VERMILLION, mew=1.8, label=mark)
    axes.axvline(1, color=GREY, lw=1.2, ls="--", label="as given")
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    axes.set_xlabel("width of the interval, times that given")
