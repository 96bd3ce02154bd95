r"""The best number ``theta`` in ``inf_x (U + theta W)/D``: exact cutting planes, no grid and no semidefinite program.

For polynomials ``D, U, W`` with ``D > 0`` on ``[0, inf)`` the function ``m(theta) = inf {u(x) + theta w(x)}`` with
``u = U/D`` and ``w = W/D`` is concave.  Each point ``x`` gives a *cut* ``m(theta) <= u(x) + theta w(x)``; two cuts
whose slopes ``w`` have opposite signs bound ``sup m`` from above, exactly.  From below a level counts only after an
exact root count has shown ``U + theta W - level D > 0`` on all of ``[0, inf)``; where that fails, the intervals between
roots yield new cuts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from flint import fmpq

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.gains import simplest_between
from lure.analysis.numerics.polynomial import to_fmpq, to_fraction

ROUNDS = 60
TOLERANCE = fmpq(1, 10**12)
POLISH, WATCHED = 8, 6


@dataclass(frozen=True, slots=True)
class Cut:
    """``m(theta) <= u + theta w`` for every ``theta``, from the point ``x``; None is infinity.

    The two numbers may be rounded; what is claimed in the end is computed anew from ``x``.
    """

    u: fmpq
    w: fmpq
    x: fmpq | None = None

    def at(self, theta: fmpq) -> fmpq:
        """The bound at this ``theta``."""
        return self.u + theta * self.w


CAP = Cut(fmpq(0), fmpq(0))


@dataclass(frozen=True, slots=True)
class UpperBound:
    """An upper bound of ``sup m`` from some cuts, and the one or two cuts behind it."""

    value: fmpq
    support: tuple[Cut, ...]


@dataclass(frozen=True, slots=True)
class Window:
    """The ``theta`` at which all cuts lie above some level, from ``low`` to ``high``; None where unbounded."""

    low: fmpq | None
    high: fmpq | None


@dataclass(frozen=True, slots=True)
class SearchResult:
    """``m(theta) > level``, and ``sup m <= summit.value``; ``theta`` None: no level was shown to be exceeded.

    ``cuts`` are those at hand in the end.
    """

    theta: fmpq | None
    level: fmpq
    upper_bound: UpperBound
    cuts: tuple[Cut, ...]


class Family(Protocol):
    """What is asked about ``u + theta w``."""

    def violations(self, theta: fmpq, level: fmpq) -> Sequence[Cut]:
        """Cuts that do not exceed ``level`` at ``theta``; none at all is the claim ``m(theta) > level``."""
        ...

    def nearby(self, cuts: Sequence[Cut], theta: fmpq) -> Sequence[Cut]:
        """Cuts from the local minima next to the points of others; a cheap guess, none is an answer too."""
        ...

    def bound(self, support: Sequence[Cut]) -> fmpq:
        """The upper bound of ``sup m`` from the points of one or two cuts, as exact as the family can say it."""
        ...


def search(
    family: Family,
    cuts: Sequence[Cut],
    rounded: Callable[[fmpq], fmpq],
    *,
    nonnegative: bool = False,
    tolerance: fmpq = TOLERANCE,
) -> SearchResult:
    """The largest level up to 0 that some ``theta`` exceeds, from above by cuts and from below by the family's word.

    Parameters
    ----------
    family : Family
        Decides whether a level is exceeded; its word is the evidence behind ``level``.
    cuts : sequence of Cut
        What is known at the start.
    rounded : callable
        Takes a negative level to one not above it that the caller can state exactly.
    nonnegative : bool
        Whether only ``theta >= 0`` is admitted.
    tolerance : fmpq
        How far below the cuts a level is tried, relative.
    """
    known = _polished(family, [CAP, *cuts], tolerance, nonnegative=nonnegative)
    for attempt in range(ROUNDS):
        checkpoint()
        top = upper_bound(known, nonnegative=nonnegative)
        slack = tolerance * (1 if attempt < ROUNDS - 8 else 10 ** (attempt - ROUNDS + 9))
        aim = top.value * (1 + slack) if top.value < 0 else -_scale(known) * slack
        window = admissible(known, aim, nonnegative=nonnegative)
        level = rounded(aim * (1 + slack))
        if window is None:
            continue
        theta = choice(window)
        found = family.violations(theta, level)
        if not found:
            return SearchResult(theta, level, UpperBound(family.bound(top.support), top.support), tuple(known))
        known = _polished(family, [*known, *found], tolerance, nonnegative=nonnegative)
    top = upper_bound(known, nonnegative=nonnegative)
    return SearchResult(None, fmpq(0), UpperBound(family.bound(top.support), top.support), tuple(known))


def _polished(family: Family, cuts: Sequence[Cut], tolerance: fmpq, *, nonnegative: bool) -> list[Cut]:
    """The cuts and those next to the summit, while they lower it: saves calls of the exact test."""
    known = list(cuts)
    for _ in range(POLISH):
        top = upper_bound(known, nonnegative=nonnegative)
        if len(top.support) < 2 or not top.value < 0:
            break
        left, right = top.support
        theta = choice(Window(*sorted(_near((right.u - left.u) / (left.w - right.w)))))
        lowest = sorted(known, key=lambda cut: cut.at(theta))[:WATCHED]
        lower = [cut for cut in family.nearby(lowest, theta) if cut.at(theta) < top.value * (1 + tolerance)]
        if not lower:
            break
        known += lower
    return known


def _near(theta: fmpq) -> tuple[fmpq, fmpq]:
    return theta * (1 - fmpq(1, 10**15)), theta * (1 + fmpq(1, 10**15))


def upper_bound(cuts: Sequence[Cut], *, nonnegative: bool = False) -> UpperBound:
    """The greatest value over ``theta`` of the least cut; the cuts must bound it.

    ``cuts``: at least one of slope zero; ``nonnegative``: whether only ``theta >= 0`` is admitted.
    """
    flat = min((cut for cut in cuts if cut.w == 0), key=lambda cut: cut.u)
    rising = [cut for cut in cuts if cut.w > 0]
    falling = [cut for cut in cuts if cut.w < 0]
    if nonnegative:
        at_zero = min(cuts, key=lambda cut: cut.u)
        if at_zero.w <= 0:
            return UpperBound(at_zero.u, (at_zero,))
    if not rising or not falling:
        return UpperBound(flat.u, (flat,))
    left, right, rough = rising[0], falling[0], [(_double(cut.u), _double(cut.w)) for cut in cuts]
    while True:
        theta = (right.u - left.u) / (left.w - right.w)
        least = min(_lowest(cuts, rough, theta), key=lambda cut: cut.at(theta))
        if least.w == 0:
            return UpperBound(flat.u, (flat,))
        if not least.at(theta) < left.at(theta):
            return UpperBound(least.at(theta), (left, right))
        left, right = (least, right) if least.w > 0 else (left, least)


def _double(value: fmpq) -> float:
    """The nearest double, nan if there is none."""
    try:
        return float(to_fraction(value))
    except OverflowError:
        return math.nan


def _lowest(cuts: Sequence[Cut], rough: Sequence[tuple[float, float]], theta: fmpq) -> Sequence[Cut]:
    """The cuts of which doubles leave open whether they are the least at ``theta``, all where doubles say nothing."""
    t = _double(theta)
    bounds = [(u + t * w, 1e-14 * (abs(u) + abs(t * w)) + 1e-290) for u, w in rough]
    top = min(value + error for value, error in bounds)
    if not math.isfinite(sum(value for value, _ in bounds)):
        return cuts
    return [cut for cut, (value, error) in zip(cuts, bounds, strict=True) if value - error <= top]


def mixture(support: Sequence[Cut]) -> fmpq:
    """The upper bound of ``sup m`` that a support gives; 0 if it gives none.

    ``support``: two cuts of opposite slopes; or one of slope zero, or of negative slope if only ``theta >= 0`` is
    admitted.
    """
    if len(support) == 1:
        return support[0].u
    one, two = support
    if not one.w * two.w < 0:
        return fmpq(0)
    return (one.u * abs(two.w) + two.u * abs(one.w)) / (abs(one.w) + abs(two.w))


def admissible(cuts: Sequence[Cut], level: fmpq, *, nonnegative: bool = False) -> Window | None:
    """The ``theta`` at which no cut lies below ``level``; None if there is none.

    ``nonnegative``: whether only ``theta >= 0`` is admitted.
    """
    if any(cut.w == 0 and cut.u < level for cut in cuts):
        return None
    lows = [(level - cut.u) / cut.w for cut in cuts if cut.w > 0]
    highs = [(level - cut.u) / cut.w for cut in cuts if cut.w < 0]
    low = max(lows + [fmpq(0)] * nonnegative, default=None)
    high = min(highs, default=None)
    if low is not None and high is not None and low > high:
        return None
    return Window(low, high)


def choice(window: Window) -> fmpq:
    """A simple ``theta`` well inside a window: 0 if it lies there."""
    low, high = window.low, window.high
    if (low is None or low <= 0) and (high is None or high >= 0):
        return fmpq(0)
    if low is None and high is not None:
        return -choice(Window(-high, None))
    assert low is not None
    if high is None:
        return _simplest(low * fmpq(5, 4), low * 3)
    quarter = (high - low) / 4
    return _simplest(low + quarter, high - quarter)


def _simplest(low: fmpq, high: fmpq) -> fmpq:
    return to_fmpq(simplest_between(to_fraction(low), to_fraction(high)))


def _scale(cuts: Sequence[Cut]) -> fmpq:
    return max((abs(cut.u) for cut in cuts), default=fmpq(1)) or fmpq(1)
