"""Linear blocks with known poles, for loops with laws of a class."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from lure.errors import InputError
from lure.plants.rational import RationalBlock

# The exact numbers that strategies draw: small ones first, so that what fails shrinks to them.

try:
    from hypothesis import strategies as strategies
except ImportError:
    raise InputError("lure.analysis.testing.strategies needs Hypothesis: pip install hypothesis") from None

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


_ORDERS = (1, 4)
_BLOCKS_FINEST = 10


@dataclass(frozen=True, kw_only=True, slots=True)
class KnownBlock:
    """A block and the poles it was made from.

    Attributes
    ----------
    block : RationalBlock
        The block, its coefficients exact.
    poles : tuple of pairs of Fraction
        Real and imaginary part of each pole; of a conjugate pair the one above the axis.
    """

    block: RationalBlock
    poles: tuple[tuple[Fraction, Fraction], ...]


def lurie_blocks(
    *, order: int | tuple[int, int] = _ORDERS, critical: bool = False, discrete: bool = False
) -> strategies.SearchStrategy[RationalBlock]:
    """Strictly proper blocks with all poles stable, or with one simple pole at 0 (1) and the others stable.

    Parameters
    ----------
    order : int or pair of int
        Order, or the smallest and the largest.
    critical : bool
        Whether there is a pole at ``s = 0`` (``z = 1``); its residue is positive, as absolute stability needs.
    discrete : bool
        Whether time is discrete, with the sampling time 1.

    Returns
    -------
    SearchStrategy of RationalBlock
        Shrinks to ``1/(s + 1)``.

    Raises
    ------
    InputError
        ``order`` is not positive, or not ascending.
    """
    known = known_blocks(order=order, critical=critical, discrete=discrete)

    @strategies.composite
    def blocks(draw: strategies.DrawFn) -> RationalBlock:
        """The block alone."""
        return draw(known).block

    return blocks()


def known_blocks(
    *, order: int | tuple[int, int] = _ORDERS, critical: bool = False, discrete: bool = False
) -> strategies.SearchStrategy[KnownBlock]:
    """The blocks of :func:`lurie_blocks`, with their poles.

    Parameters
    ----------
    order : int or pair of int
        Order, or the smallest and the largest.
    critical : bool
        Whether there is a pole at ``s = 0`` (``z = 1``).
    discrete : bool
        Whether time is discrete.

    Raises
    ------
    InputError
        ``order`` is not positive, or not ascending.
    """
    least, most = (order, order) if isinstance(order, int) else order
    if not 1 <= least <= most:
        raise InputError(f"order is {order!r:.60}; give a positive whole number, or two in ascending order")

    @strategies.composite
    def blocks(draw: strategies.DrawFn) -> KnownBlock:
        """Poles first, then a numerator of lower degree."""
        size = draw(strategies.integers(least, most))
        poles = [(Fraction(1 if discrete else 0), Fraction(0))] if critical else []
        left = size - len(poles)
        while left:
            pair = left >= 2 and draw(strategies.booleans())
            poles.append(_pole(draw, discrete=discrete, pair=pair))
            left -= 2 if pair else 1
        denominator = [Fraction(1)]
        for pole in poles:
            denominator = _product(denominator, _factor(pole))
        numerator = _numerator(draw, size, (1 if discrete else 0) if critical else None)
        return KnownBlock(block=RationalBlock(numerator, denominator, 1 if discrete else None), poles=tuple(poles))

    return blocks()


def _pole(draw: strategies.DrawFn, *, discrete: bool, pair: bool) -> tuple[Fraction, Fraction]:
    """A stable pole: left of the imaginary axis, or inside the unit circle."""
    if not discrete:
        decay = draw(
            strategies.one_of(
                strategies.just(Fraction(1)), strategies.fractions(Fraction(1, 10), 10, max_denominator=_BLOCKS_FINEST)
            )
        )
        return -decay, draw(
            strategies.fractions(Fraction(1, 10), 10, max_denominator=_BLOCKS_FINEST)
        ) if pair else Fraction(0)
    inside = strategies.fractions(Fraction(-9, 10), Fraction(9, 10), max_denominator=_BLOCKS_FINEST)
    real = draw(inside)
    if not pair:
        return real, Fraction(0)
    imaginary = draw(strategies.fractions(Fraction(1, 10), Fraction(9, 10), max_denominator=_BLOCKS_FINEST))
    return (real, imaginary) if real**2 + imaginary**2 < Fraction(9, 10) else (real / 2, imaginary / 2)


def _factor(pole: tuple[Fraction, Fraction]) -> list[Fraction]:
    real, imaginary = pole
    return [Fraction(1), -2 * real, real**2 + imaginary**2] if imaginary else [Fraction(1), -real]


def _product(first: list[Fraction], second: list[Fraction]) -> list[Fraction]:
    out = [Fraction(0)] * (len(first) + len(second) - 1)
    for i, a in enumerate(first):
        for j, b in enumerate(second):
            out[i + j] += a * b
    return out


def _numerator(draw: strategies.DrawFn, order: int, critical: int | None) -> list[Fraction]:
    """Coefficients of a polynomial of degree below the order; its value at the critical pole is positive."""
    number = strategies.one_of(
        strategies.sampled_from((Fraction(0), Fraction(1))), strategies.fractions(-5, 5, max_denominator=4)
    )
    coefficients = [*draw(strategies.lists(number, max_size=order - 1)), draw(number)]
    if not any(coefficients):
        coefficients[-1] = Fraction(1)
    if critical is None:
        return coefficients
    value = sum(coefficients, Fraction(0)) if critical else coefficients[-1]
    if value == 0:
        coefficients[-1] += 1
    return [-c for c in coefficients] if value < 0 else coefficients
