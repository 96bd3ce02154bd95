"""Ball arithmetic: the one place that sets its precision, and the way back to doubles, rounded outwards."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction

from flint import arb, ctx, fmpq

from lure.analysis.numerics.evidence import Bracket

SERIES_TERMS = 10


@contextmanager
def working_precision(bits: int) -> Iterator[None]:
    """Run a block at ``bits`` of precision, with series of 10 terms; put both back (they are global to the process)."""
    before = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = bits, SERIES_TERMS
    try:
        yield
    finally:
        ctx.prec, ctx.cap = before


def ball(value: Fraction | int | float) -> arb:
    """The ball around an exact number, as narrow as the working precision allows."""
    exact = Fraction(value)
    return arb(fmpq(exact.numerator, exact.denominator))


def outward(low: arb, high: arb) -> Bracket:
    """Doubles around ``[low.lower(), high.upper()]``; infinite on a side that is not finite."""
    return Bracket(_down(low) + 0.0, 0.0 - _down(-high))  # the zeros turn -0.0 into 0.0


def upward(value: arb) -> float:
    """A double that is not below a ball, infinite where it is not finite."""
    return 0.0 - _down(-value)


def _down(value: arb) -> float:
    lower = value.lower()
    if not lower.is_finite():
        return math.inf if lower > 0 else -math.inf
    nearest = float(lower)
    if math.isinf(nearest):
        return math.nextafter(nearest, 0.0) if nearest > 0 else nearest
    # float() rounds a long mantissa to one side or the other: step down unless it is certainly below
    return nearest if arb(nearest) <= lower else math.nextafter(nearest, -math.inf)
