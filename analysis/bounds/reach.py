"""What an expansion lies between on its stretch, and where it tends."""

from __future__ import annotations

import math
from fractions import Fraction

from flint import arb

from analysis.bounds.expansion import Expansion, Stretch
from analysis.bounds.extremes import Candidate, Cover, End, bounds_of
from analysis.bounds.result import Bound
from lure.expressions.balls import ball


def reach(m: Expansion, stretch: Stretch, end: End, side: int) -> tuple[Cover, Candidate | None]:
    """What an expansion lies between on its stretch, and its limit as ``t -> 0`` where it has one."""
    low, high, limit = _reach(stretch.settled(m), stretch)
    found = None if limit is None else Candidate(value=limit, place=end, inside=False, side=side)
    return Cover(low=low, high=high), found


def _reach(m: Expansion, stretch: Stretch) -> tuple[Bound, Bound, Bound | tuple[Fraction, Fraction] | None]:
    lead = m.lead
    if m.growth is not None or lead < 0:
        sign = stretch.sign(m)
        if not sign:
            return -math.inf, math.inf, None
        least = max(bounds_of(_smallest(m, stretch))[0], Fraction(0))
        limit = sign * math.inf if m.growth is not None or lead in m.terms else None
        return (least, math.inf, limit) if sign > 0 else (-math.inf, -least, limit)
    constant = m.terms.get(Fraction(0), arb(0))
    rest = m.without_constant
    c_low, c_high = bounds_of(constant)
    known = (
        c_low if c_low == c_high or not isinstance(c_low, Fraction) or isinstance(c_high, float) else (c_low, c_high)
    )
    if rest.is_zero:
        return c_low, c_high, known
    span = stretch.hull(rest, rest.lead) * stretch.upto(rest.lead)
    low, high = bounds_of(span.low)[0], bounds_of(span.high)[1]
    return _sum(c_low, low), _sum(c_high, high), known if rest.lead > 0 else None


def _sum(first: Bound, second: Bound) -> Bound:
    """The sum of two lower or two upper bounds; with an infinite one a number beyond all doubles is not converted."""
    for bound in (first, second):
        if isinstance(bound, float):
            return bound
    return first + second


def _smallest(m: Expansion, stretch: Stretch) -> arb:
    """A lower bound of ``|m|`` for an expansion that grows without bound."""
    size = stretch.hull(m, m.lead).size.low
    if m.growth is None:
        return size * stretch.power(m.lead).low
    rate, power = stretch.hull(m.growth, m.growth.lead).low, m.growth.lead
    far = stretch.power(power).low
    if rate * ball(-power) * far >= ball(m.lead):  # then exp(rate t^power) t^lead falls as t grows
        return size * stretch.power(m.lead).low * (rate * far).exp()
    return arb(0)
