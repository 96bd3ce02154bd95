"""Values collected on the pieces of a law, and the extremes chosen among them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TypeAlias

from flint import arb

from lure.analysis.nonlinearity.result import Bound, Extreme, Place, short

BITS = 160
_LARGEST = 10_000
End: TypeAlias = Fraction | float
"""An end of an interval: a Fraction, or a float that is an infinity."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Candidate:
    """A value that is taken or approached, perhaps enclosed only.

    Attributes
    ----------
    value : Fraction, infinity, or pair of Fraction
        The value, or an interval that contains it.
    place : Fraction, infinity, pair of Fraction, or str
        The point, an interval that contains it, or words.
    inside : bool
        Whether the law takes the value at the place; else it approaches it.
    side : int
        For a limit: 1 from the right, -1 from the left, 0 where that needs no saying.
    """

    value: Bound | tuple[Fraction, Fraction]
    place: End | tuple[Fraction, Fraction] | str
    inside: bool
    side: int = 0

    @property
    def low(self) -> Bound:
        """What the value is at least."""
        return self.value[0] if isinstance(self.value, tuple) else self.value

    @property
    def high(self) -> Bound:
        """What the value is at most."""
        return self.value[1] if isinstance(self.value, tuple) else self.value

    @property
    def at(self) -> Place:
        """The place as results say it."""
        if isinstance(self.place, float):
            return "sigma -> inf" if self.place > 0 else "sigma -> -inf"
        if isinstance(self.place, Fraction) and not self.inside:
            sign = {1: "+", -1: "-"}.get(self.side, "")
            return f"sigma -> {short(self.place, digits=10)}{sign}"
        return self.place


@dataclass(frozen=True, kw_only=True, slots=True)
class Cover:
    """A set of ``sigma`` on which every value lies in ``[low, high]``, beside the candidates found there."""

    low: Bound
    high: Bound


def largest(found: Sequence[Candidate], covers: Sequence[Cover] = ()) -> Extreme:
    """The supremum: not below any candidate, not above every candidate and cover."""
    inner = max(c.low for c in found)
    outer = max([*(c.high for c in found), *(c.high for c in covers)])
    return _extreme(inner, outer, [c for c in found if c.low == inner], [c for c in found if c.high > inner])


def least(found: Sequence[Candidate], covers: Sequence[Cover] = ()) -> Extreme:
    """The infimum: not above any candidate, not below every candidate and cover."""
    inner = min(c.high for c in found)
    outer = min([*(c.low for c in found), *(c.low for c in covers)])
    return _extreme(inner, outer, [c for c in found if c.high == inner], [c for c in found if c.low < inner])


def _extreme(inner: Bound, outer: Bound, best: Sequence[Candidate], rivals: Sequence[Candidate]) -> Extreme:
    """Of several equal extremes one that is taken, if no limit elsewhere may be more extreme."""
    inside = next((c for c in best if c.inside), None)
    if inside is not None:
        attained = all(c.inside or c.place == inside.place for c in rivals)
        return Extreme(inner=inner, outer=outer, at=inside.at, attained=attained)
    return Extreme(inner=inner, outer=outer, at=_approached(best), attained=False)


def _approached(best: Sequence[Candidate]) -> Place:
    """The place in words, both sides together where both approach it."""
    first, places = best[0], {(c.place, c.side) for c in best}
    if {place for place, _ in places} >= {math.inf, -math.inf}:
        return "|sigma| -> inf"
    if (first.place, -first.side) in places and isinstance(first.place, Fraction):
        return f"sigma -> {short(first.place, digits=10)}"
    return first.at


def interval_of(ball: arb) -> tuple[Fraction, Fraction]:
    """The ends of a finite ball, exactly."""
    low, high = bounds_of(ball)
    assert isinstance(low, Fraction), "the ball is finite"
    assert isinstance(high, Fraction), "the ball is finite"
    return low, high


def bounds_of(ball: arb) -> tuple[Bound, Bound]:
    """The ends of a ball, infinite where nothing is known; sizes beyond ``2^(+-10000)`` are rounded outwards."""
    if ball.is_nan():
        return -math.inf, math.inf
    return _end(ball.lower(), -1), _end(ball.upper(), 1)


def _end(ball: arb, outwards: int) -> Bound:
    if not ball.is_finite():
        return math.inf if ball > 0 else -math.inf
    mantissa, exponent = ball.man_exp()
    m, e = int(mantissa), int(exponent)
    if abs(e + m.bit_length()) > _LARGEST and m:
        tiny, sign = e < 0, 1 if m > 0 else -1
        if tiny:
            return Fraction(sign, 1 << _LARGEST) if sign == outwards else Fraction(0)
        return sign * math.inf if sign == outwards else Fraction(sign * (1 << _LARGEST))
    return Fraction(m << e) if e >= 0 else Fraction(m, 1 << -e)


def tightened(
    found: list[Candidate], covers: list[Cover], within: tuple[End, End]
) -> tuple[list[Candidate], list[Cover]]:
    """Values and covers that were enclosed, without what rounding added beyond bounds that hold for every value.

    Parameters
    ----------
    found, covers : list
        What is known of the values.  An end that is infinite stays so: it says that not every place was looked at.
    within : pair of Fraction or infinity
        The bounds, of :func:`lure.expressions.regularity.hull`.
    """
    low, high = within

    def inside(value: Fraction) -> Fraction:
        """The value, moved to the nearer bound from beyond it."""
        above = max(value, low) if isinstance(low, Fraction) else value
        return min(above, high) if isinstance(high, Fraction) else above

    def end(value: Bound) -> Bound:
        """The end of a cover, likewise."""
        return inside(value) if isinstance(value, Fraction) else value

    values = [
        replace(c, value=(inside(c.value[0]), inside(c.value[1]))) if isinstance(c.value, tuple) else c for c in found
    ]
    return values, [Cover(low=end(c.low), high=end(c.high)) for c in covers]
