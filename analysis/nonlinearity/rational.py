"""Extremes of values, and those of rational functions on an interval, by exact root isolation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TypeAlias

from flint import arb, arb_poly, fmpq_poly

from lure.analysis.nonlinearity.result import Bound, Extreme, Place
from lure.analysis.numerics.polynomial import X, exact_midpoint, real_roots, to_fmpq, to_fraction
from lure.analysis.numerics.precision import working_precision
from lure.errors import InputError
from lure.expressions.tree import Apply, Node, Number
from lure.record import described, quantity
from lure.record.values import exact_text

# Values collected on the pieces of a nonlinearity, and the extremes chosen among them.

BITS = 160
_LARGEST = 10_000
_ACCURATE, _NOTHING = 40, 2.0**-BITS  # [bits], and the radius of a value that may be 0
End: TypeAlias = Fraction | float
"""An end of an interval: a Fraction, or a float that is an infinity."""


@described(frozen=True, kw_only=True, slots=True)
class Candidate:
    """A value that is taken or approached, perhaps enclosed only."""

    value: Bound | tuple[Fraction, Fraction] = quantity("The value, or an interval that contains it")
    place: End | tuple[Fraction, Fraction] | str = quantity("The point, an interval that contains it, or words")
    inside: bool = quantity("Whether the nonlinearity takes the value at the place; else it approaches it")
    side: int = quantity("For a limit: 1 from the right, -1 from the left, 0 where that needs no saying", default=0)

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
            return f"sigma -> {exact_text(self.place, 10)}{sign}"
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
        return f"sigma -> {exact_text(first.place, 10)}"
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


MAX_DEGREE = 256
_ONE = fmpq_poly([1])


class TooLarge(InputError):
    """A formula passes a limit of what is offered: that says nothing against it."""


@dataclass(frozen=True, slots=True)
class Ratio:
    """``top / bottom`` in lowest terms; ``poles`` holds every denominator met on the way, as written."""

    top: fmpq_poly
    bottom: fmpq_poly
    poles: fmpq_poly

    def over_sigma(self) -> Ratio:
        """The function divided by ``sigma``."""
        return _reduced(self.top, self.bottom * X, self.poles)

    def slope(self) -> Ratio:
        """The derivative."""
        top = self.top.derivative() * self.bottom - self.top * self.bottom.derivative()
        return _reduced(top, self.bottom * self.bottom, self.poles)

    def defined_at(self, x: Fraction) -> Fraction | None:
        """The value at a point, None where a denominator met on the way is 0, whether it cancels or not."""
        return None if self.poles(to_fmpq(x)) == 0 else self.at(x)

    def at(self, x: Fraction) -> Fraction | None:
        """The value at a point, None at a pole."""
        point = to_fmpq(x)
        bottom = self.bottom(point)
        return None if bottom == 0 else to_fraction(self.top(point) / bottom)


def ratio(node: Node) -> Ratio | None:
    """The rational function a tree of one variable without branches stands for; None for any other tree.

    Raises
    ------
    InputError
        Its degree passes 256.
    """
    if isinstance(node, Number):
        return Ratio(fmpq_poly([to_fmpq(node.value)]), _ONE, _ONE)
    if not isinstance(node, Apply):
        return Ratio(X, _ONE, _ONE)
    if node.operation == "**":
        exponent = node.arguments[1]
        assert isinstance(exponent, Number), "the parser and the derivative make only constant exponents"
        base = ratio(node.arguments[0]) if exponent.value.denominator == 1 else None
        return None if base is None else _power(base, exponent.value.numerator)
    if node.operation not in ("+", "-", "*", "/", "neg"):
        return None
    parts: list[Ratio] = []
    for argument in node.arguments:
        part = ratio(argument)
        if part is None:
            return None
        parts.append(part)
    u = parts[0]
    if node.operation == "neg":
        return Ratio(-u.top, u.bottom, u.poles)
    v = parts[1]
    poles = u.poles * v.poles
    _bounded(poles.degree())
    match node.operation:
        case "*":
            return _reduced(u.top * v.top, u.bottom * v.bottom, poles)
        case "/":
            if v.top.degree() < 0:
                raise InputError("the nonlinearity divides by zero everywhere; write a formula that has values")
            return _reduced(u.top * v.bottom, u.bottom * v.top, poles * v.top)
        case "+":
            return _reduced(u.top * v.bottom + v.top * u.bottom, u.bottom * v.bottom, poles)
        case _:
            return _reduced(u.top * v.bottom - v.top * u.bottom, u.bottom * v.bottom, poles)


def roots_between(p: fmpq_poly, low: End, high: End) -> list[Fraction | arb]:
    """The distinct real roots of a polynomial in an open interval; a rational one exactly if short, else in a ball."""
    if p.degree() <= 0:
        return []
    with working_precision(BITS):
        balls = real_roots(p)
    ends = [end for end in (low, high) if isinstance(end, Fraction)]
    found: list[Fraction | arb] = []
    for root in balls:
        left, right = _ends_of(root)
        guess = ((left + right) / 2).limit_denominator(10**18)
        if left <= guess <= right and p(to_fmpq(guess)) == 0:  # the one root in the ball
            if low < guess < high:
                found.append(guess)
            continue
        if any(left <= end <= right and p(to_fmpq(end)) == 0 for end in ends):
            continue
        bits = BITS
        while any(left <= end <= right for end in ends):  # which are no roots: narrow it until that shows
            bits *= 2
            root = _narrower(p, root, bits)
            left, right = _ends_of(root)
        if low < left and right < high:
            found.append(root)
    return found


def _ends_of(root: arb) -> tuple[Fraction, Fraction]:
    """The ends of a ball as they are: rounded, it may take in its neighbour."""
    middle, radius = exact_midpoint(root), exact_midpoint(root.rad())
    return middle - radius, middle + radius


def _narrower(p: fmpq_poly, root: arb, bits: int) -> arb:
    """The ball around the same root at a higher precision."""
    while True:
        with working_precision(bits):
            near = [ball for ball in real_roots(p) if ball.overlaps(root)]
        if len(near) == 1:
            return near[0]
        bits *= 2


def candidates(r: Ratio, low: End, high: End) -> list[Candidate]:
    """The values among which the least and the largest of ``r`` on the open interval lie, ends included as limits.

    No pole may lie inside.  Between the points of the list the function is monotone, so that nothing else is needed.
    """
    found = [limit(r, low, 1), limit(r, high, -1)]
    if r.top.degree() <= 0 and r.bottom.degree() <= 0:
        inside = _inside(low, high)
        return [Candidate(value=to_fraction(r.top[0] / r.bottom[0]), place=inside, inside=True), *found]
    slope = r.slope()
    for root in roots_between(slope.top, low, high):
        if isinstance(root, Fraction):
            value = r.at(root)
            assert value is not None, "poles inside are refused"
            found.append(Candidate(value=value, place=root, inside=True))
        else:
            found.append(Candidate(value=_at_root(r, slope.top, root), place=_ends_of(root), inside=True))
    return found


def limit(r: Ratio, end: End, side: int) -> Candidate:
    """The limit of a rational function at an end of the interval, from the right for ``side = 1``."""
    if not isinstance(end, Fraction):
        growth = r.top.degree() - r.bottom.degree()
        if growth < 0 or r.top.degree() < 0:
            return Candidate(value=Fraction(0), place=end, inside=False)
        quotient = to_fraction(r.top[r.top.degree()] / r.bottom[r.bottom.degree()])
        if growth == 0:
            return Candidate(value=quotient, place=end, inside=False)
        sign = (1 if quotient > 0 else -1) * (-1 if end < 0 and growth % 2 else 1)
        return Candidate(value=sign * math.inf, place=end, inside=False)
    value: Bound | None = r.at(end)
    if value is None:
        value = math.inf * _sign_beside(r.top, end, side) * _sign_beside(r.bottom, end, side)
    return Candidate(value=value, place=end, inside=False, side=side)


def _sign_beside(p: fmpq_poly, x: Fraction, side: int) -> int:
    """The sign of a nonzero polynomial just right (``side = 1``) or left of a point."""
    factor = 1
    while (value := p(to_fmpq(x))) == 0:
        p, factor = p.derivative(), factor * side
    return factor if value > 0 else -factor


def _at_root(r: Ratio, p: fmpq_poly, root: arb) -> tuple[Fraction, Fraction]:
    """An enclosure of the value at a root of ``p`` in a ball, which is narrowed while the value is hardly known."""
    bits = BITS
    while True:
        with working_precision(2 * bits):
            value = arb_poly(r.top)(root) / arb_poly(r.bottom)(root)
            if value.is_finite() and (value.rel_accuracy_bits() > _ACCURATE or value.rad() < _NOTHING):
                return interval_of(value)
        bits *= 2
        root = _narrower(p, root, bits)


def _power(base: Ratio, exponent: int) -> Ratio:
    size = max(base.top.degree(), base.bottom.degree(), base.poles.degree(), 0)
    _bounded(size * abs(exponent))
    if exponent >= 0:
        return Ratio(base.top**exponent, base.bottom**exponent, base.poles)
    if base.top.degree() < 0:
        raise InputError("the nonlinearity divides by zero everywhere; write a formula that has values")
    return _reduced(base.bottom**-exponent, base.top**-exponent, base.poles * base.top)


def _reduced(top: fmpq_poly, bottom: fmpq_poly, poles: fmpq_poly) -> Ratio:
    _bounded(max(top.degree(), bottom.degree()))
    if bottom.degree() > 0:
        common = top.gcd(bottom)
        top, bottom = top // common, bottom // common
    return Ratio(top, bottom, poles)


def _bounded(degree: int) -> None:
    if degree > MAX_DEGREE:
        raise TooLarge(f"the nonlinearity is a rational function of degree {degree}; at most {MAX_DEGREE} is offered")


def _inside(low: End, high: End) -> Fraction:
    if isinstance(low, Fraction) and isinstance(high, Fraction):
        return (low + high) / 2
    return low + 1 if isinstance(low, Fraction) else high - 1 if isinstance(high, Fraction) else Fraction(1)
