"""The exact numbers that strategies draw: small ones first, so that what fails shrinks to them."""

from __future__ import annotations

import math
from fractions import Fraction

from lure.errors import InputError

try:
    from hypothesis import strategies as strategies
except ImportError:
    raise InputError("analysis.testing.strategies needs Hypothesis: pip install hypothesis") from None

_FAR = 100
_FINEST = 12


def ratios(lower: float | Fraction, upper: float | Fraction) -> strategies.SearchStrategy[Fraction]:
    """Numbers of ``[lower, upper]``: often one of the finite bounds; at most 100 beyond the finite end of a half-line.

    Parameters
    ----------
    lower, upper : int, float or Fraction
        The interval; infinite ends are allowed.
    """
    if lower == -math.inf and upper == math.inf:
        return strategies.one_of(
            strategies.integers(-3, 3).map(Fraction), strategies.fractions(-_FAR, _FAR, max_denominator=_FINEST)
        )
    if upper == math.inf:
        return _shares(_FAR).map(lambda share: Fraction(lower) + share)
    if lower == -math.inf:
        return _shares(_FAR).map(lambda share: Fraction(upper) - share)
    low, width = Fraction(lower), Fraction(upper) - Fraction(lower)
    return _shares(1).map(lambda share: low + share * width)


def steps(scale: Fraction) -> strategies.SearchStrategy[Fraction]:
    """Distances between knots, a tenth to ten times the scale.

    Parameters
    ----------
    scale : Fraction
        Their size, positive.
    """
    share = strategies.one_of(
        strategies.just(Fraction(1)), strategies.fractions(Fraction(1, 10), 10, max_denominator=_FINEST)
    )
    return share.map(lambda number: number * scale)


def sizes(scale: Fraction) -> strategies.SearchStrategy[Fraction]:
    """Positive numbers from a hundredth to a hundred times the scale.

    Parameters
    ----------
    scale : Fraction
        Their size, positive.
    """
    powers = strategies.sampled_from((Fraction(1), Fraction(1, 10), Fraction(10), Fraction(1, 100), Fraction(100)))
    return powers.map(lambda number: number * scale)


def _shares(most: int) -> strategies.SearchStrategy[Fraction]:
    """Numbers from 0 to ``most``, often the ends; 1 is the simplest."""
    return strategies.one_of(
        strategies.sampled_from((Fraction(1), Fraction(0))), strategies.fractions(0, most, max_denominator=_FINEST)
    )
