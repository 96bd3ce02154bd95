"""The values of a target on a closed interval, as far as one look at it tells."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from flint import arb

from analysis.bounds.extremes import Candidate, Cover, bounds_of, interval_of
from analysis.bounds.jets import jet, value_at, values_by_branch
from analysis.bounds.target import Region, Target, middle
from analysis.polynomial import to_fmpq
from lure.expressions.balls import ball


def by_branch(target: Target, a: Fraction, b: Fraction) -> list[Region]:
    """A box too narrow to be halved, once more with its branches apart; nothing if that says no more."""
    values = values_by_branch(target.tree, ball(a).union(ball(b)))
    ends = [bounds_of(value) for value in values or []]
    if not ends or any(isinstance(end, float) for pair in ends for end in pair):
        return []
    cover = Cover(low=min(low for low, _ in ends), high=max(high for _, high in ends))
    return [Region(box=(a, b), end=None, cover=cover, closed=True)]


def evaluated(target: Target, a: Fraction, b: Fraction) -> Region:
    """What one look at the values, slope and curvature on the box shows."""
    tree = target.tree
    box = ball(a).union(ball(b))
    value, slope, bend = jet(tree, box)
    centre = middle(a, b)
    if slope >= 0 or slope <= 0:
        return _closed(a, b, [_point(target, a), _point(target, b)])
    at_centre = _point(target, centre)
    if bend.is_finite() and (bend > 0 or bend < 0):
        turning = _turning(target, a, b, bend)
        if turning is not None:
            return _closed(a, b, [_point(target, a), _point(target, b), *turning])
    spread = value
    if slope.is_finite() and at_centre is not None:
        step = box - ball(centre)
        first = _ball_of(at_centre) + slope * step
        spread = spread.intersection(first) if spread.is_finite() and spread.overlaps(first) else first
    low, high = bounds_of(spread)
    return Region(
        box=(a, b), end=None, cover=Cover(low=low, high=high), found=() if at_centre is None else (at_centre,)
    )


def _point(target: Target, x: Fraction) -> Candidate | None:
    """The value at a point; None where nothing is known of it."""
    low, high = bounds_of(value_at(target.tree, x))
    inside = target.low < x < target.high
    if not isinstance(low, Fraction) or not isinstance(high, Fraction):
        return None
    return Candidate(value=low if low == high else (low, high), place=x, inside=inside)


def _turning(target: Target, a: Fraction, b: Fraction, bend: arb) -> list[Candidate] | None:
    """The value where the slope changes sign, for a second derivative of one sign; empty if it does not."""
    tree = target.tree
    at_a, at_b = jet(tree, ball(a))[1], jet(tree, ball(b))[1]
    first, last = (at_a, at_b) if bend > 0 else (at_b, at_a)  # the slope rises from the first to the last
    if first >= 0 or last <= 0:
        return []
    if not (first < 0 and last > 0):
        return None
    inside = ball(a).union(ball(b))
    for _ in range(60):
        centre = inside.mid()
        newton = centre - jet(tree, centre)[1] / (2 * bend)
        if not newton.overlaps(inside):
            return None
        narrower = newton.intersection(inside)
        if not narrower.rad() < 0.75 * inside.rad():
            break
        inside = narrower
        new = jet(tree, inside)[2]
        bend = new if new.is_finite() and (new > 0 or new < 0) else bend
    slope = jet(tree, inside)[1]
    centre = inside.mid()
    held = jet(tree, centre)[0] + slope * (inside - centre)
    low, high = bounds_of(held)
    if not isinstance(low, Fraction) or not isinstance(high, Fraction):
        return None
    return [Candidate(value=(low, high), place=interval_of(inside), inside=True)]


def _closed(a: Fraction, b: Fraction, found: Sequence[Candidate | None]) -> Region:
    """A box on which the function is monotone between the points given."""
    known = tuple(c for c in found if c is not None)
    if len(known) < len(found):
        return Region(box=(a, b), end=None, cover=Cover(low=-math.inf, high=math.inf), found=known)
    cover = Cover(low=min(c.low for c in known), high=max(c.high for c in known))
    return Region(box=(a, b), end=None, cover=cover, found=known, closed=True)


def _ball_of(c: Candidate) -> arb:
    low, high = c.low, c.high
    return arb(to_fmpq(low)).union(arb(to_fmpq(high)))
