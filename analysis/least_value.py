"""The least value over all frequencies for one multiplier, as a rigorous bracket."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from flint import fmpq, fmpq_poly

from analysis.doubles import double_above, double_below
from analysis.evidence import Bracket
from analysis.multiplier_search import CAP, Cut, search
from analysis.polynomial import to_fmpq, to_fraction
from analysis.polynomial_family import PolynomialFamily


@dataclass(frozen=True, slots=True)
class LeastValue:
    """``low <= inf (U + theta W)/D <= high``, exactly; ``low`` None if no bound was found."""

    low: Fraction | None
    high: Fraction
    x: Fraction | None

    @property
    def frequency(self) -> float:
        """``sqrt(x)`` where the value is least, ``inf`` if only in the limit."""
        return math.inf if self.x is None else math.sqrt(self.x)

    def bracket(self, ease: Fraction = Fraction(0)) -> Bracket:
        """The bracket of the value plus ``ease`` in doubles."""
        low = -math.inf if self.low is None else double_below(self.low + ease)
        return Bracket(low, double_above(self.high + ease))


def least_value(family: PolynomialFamily, theta: Fraction) -> LeastValue:
    """The infimum of ``(U + theta W)/D`` on ``[0, inf]``, relative width about 1e-10, and where it is attained.

    Parameters
    ----------
    family : PolynomialFamily
        The functions.
    theta : Fraction
        The multiplier.
    """
    total = family.U + to_fmpq(theta) * family.W
    fixed = PolynomialFamily(family.D, total, fmpq_poly([]))
    start = [fixed.cut(fmpq(0)), fixed.at_infinity]
    lowest = min(start, key=lambda cut: cut.u)
    lowered = PolynomialFamily(family.D, total - lowest.u * family.D, fmpq_poly([]))
    found = search(lowered, lowered.first_cuts(), lambda level: level)
    low = None if found.theta is None else to_fraction(found.level + lowest.u)
    least = found.summit.support[0]
    where: Cut = lowest if least is CAP else least
    return LeastValue(
        low, to_fraction(found.summit.value + lowest.u), None if where.x is None else to_fraction(where.x)
    )
