"""Linear blocks with known poles, for loops with laws of a class."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from analysis.testing.numbers import strategies as st
from lure.errors import InputError
from lure.rational import RationalBlock

_ORDERS = (1, 4)
_FINEST = 10


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
) -> st.SearchStrategy[RationalBlock]:
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

    @st.composite
    def blocks(draw: st.DrawFn) -> RationalBlock:
        """The block alone."""
        return draw(known).block

    return blocks()


def known_blocks(
    *, order: int | tuple[int, int] = _ORDERS, critical: bool = False, discrete: bool = False
) -> st.SearchStrategy[KnownBlock]:
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

    @st.composite
    def blocks(draw: st.DrawFn) -> KnownBlock:
        """Poles first, then a numerator of lower degree."""
        size = draw(st.integers(least, most))
        poles = [(Fraction(1 if discrete else 0), Fraction(0))] if critical else []
        left = size - len(poles)
        while left:
            pair = left >= 2 and draw(st.booleans())
            poles.append(_pole(draw, discrete=discrete, pair=pair))
            left -= 2 if pair else 1
        denominator = [Fraction(1)]
        for pole in poles:
            denominator = _product(denominator, _factor(pole))
        numerator = _numerator(draw, size, (1 if discrete else 0) if critical else None)
        return KnownBlock(block=RationalBlock(numerator, denominator, 1 if discrete else None), poles=tuple(poles))

    return blocks()


def _pole(draw: st.DrawFn, *, discrete: bool, pair: bool) -> tuple[Fraction, Fraction]:
    """A stable pole: left of the imaginary axis, or inside the unit circle."""
    if not discrete:
        decay = draw(st.one_of(st.just(Fraction(1)), st.fractions(Fraction(1, 10), 10, max_denominator=_FINEST)))
        return -decay, draw(st.fractions(Fraction(1, 10), 10, max_denominator=_FINEST)) if pair else Fraction(0)
    inside = st.fractions(Fraction(-9, 10), Fraction(9, 10), max_denominator=_FINEST)
    real = draw(inside)
    if not pair:
        return real, Fraction(0)
    imaginary = draw(st.fractions(Fraction(1, 10), Fraction(9, 10), max_denominator=_FINEST))
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


def _numerator(draw: st.DrawFn, order: int, critical: int | None) -> list[Fraction]:
    """Coefficients of a polynomial of degree below the order; its value at the critical pole is positive."""
    number = st.one_of(st.sampled_from((Fraction(0), Fraction(1))), st.fractions(-5, 5, max_denominator=4))
    coefficients = [*draw(st.lists(number, max_size=order - 1)), draw(number)]
    if not any(coefficients):
        coefficients[-1] = Fraction(1)
    if critical is None:
        return coefficients
    value = sum(coefficients, Fraction(0)) if critical else coefficients[-1]
    if value == 0:
        coefficients[-1] += 1
    return [-c for c in coefficients] if value < 0 else coefficients
