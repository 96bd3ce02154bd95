"""A plant in units in which its poles and its peak are near 1, for the search in doubles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from analysis.criteria.kernel_grid import Floats
from analysis.criteria.kernel_search import Family, Search
from analysis.plant import Plant
from analysis.polynomial import to_descending


@dataclass(frozen=True, slots=True)
class Scaled:
    """``H(unit s) / gain`` in doubles, of size about 1, and the way back; both factors are powers of two."""

    numerator: Floats
    denominator: Floats
    unit: Fraction
    gain: Fraction

    @classmethod
    def of(cls, plant: Plant) -> Scaled:
        """The plant with the geometric mean of its poles and the peak of ``|H|`` near 1."""
        n, d = to_descending(plant.n), to_descending(plant.d)
        order = len(d) - 1
        unit = _power_of_two(_log2(abs(d[-1] / d[0])) / order)
        top = [c * unit**i for c, i in zip(n, range(len(n) - 1, -1, -1), strict=True)]
        bottom = [c * unit**i for c, i in zip(d, range(order, -1, -1), strict=True)]
        lead = _power_of_two(max(_log2(abs(c)) for c in bottom if c))
        size = _power_of_two(max(_log2(abs(c)) for c in top if c))
        numerator = np.array([float(c / size) for c in top])
        denominator = np.array([float(c / lead) for c in bottom])
        probe = Search(numerator, denominator, odd=False, family="none")
        peak = _power_of_two(math.log2(float(np.max(np.abs(probe.response(probe.rows))))))
        return cls(numerator / float(peak), denominator, unit, peak * size / lead)

    def search(self, family: Family, *, odd: bool = False, full: bool = False) -> Search:
        """A search for this plant."""
        return Search(self.numerator, self.denominator, odd=odd, family=family, full=full)


def _power_of_two(exponent: float) -> Fraction:
    return Fraction(2) ** round(exponent)


def _log2(value: Fraction) -> float:
    return math.log2(value.numerator) - math.log2(value.denominator)
