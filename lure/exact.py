"""Numbers as given: every real input is kept as an exact rational beside its nearest double."""

from __future__ import annotations

import math
import reprlib
from decimal import Decimal
from fractions import Fraction

from lure.errors import InputError, Reason

Exact = int | float | Fraction | Decimal


def exact_number(value: object, name: str) -> Fraction:
    """Return ``value`` as the exact rational it denotes.

    A ``Fraction``, ``Decimal`` or ``int`` is taken as it is; a ``float`` means the double itself, not the decimal it
    was typed as (``0.1`` is ``3602879701896397 / 2**55``; pass ``Fraction("0.1")`` for one tenth).

    Parameters
    ----------
    value : int, float, Fraction or Decimal
        A finite real number.  ``bool`` is refused: it is a number by accident only.
    name : str
        What the number is, for the error.

    Raises
    ------
    InputError
        ``value`` is not a finite real number, or lies outside the range of doubles.

    Examples
    --------
    >>> exact_number(0.5, "rod.length")
    Fraction(1, 2)
    """
    if type(value) is not Fraction and hasattr(value, "item") and getattr(value, "ndim", None) == 0:
        value = value.item()
    if isinstance(value, bool) or not isinstance(value, int | float | Fraction | Decimal):
        raise InputError(f"{name} is {reprlib.repr(value):.80}; give a number")
    if not (value.is_finite() if isinstance(value, Decimal) else not isinstance(value, float) or math.isfinite(value)):
        raise InputError(f"{name} is {value}; give a finite number")
    nearest = float(value) if isinstance(value, Decimal) else nearest_double(value)
    if not math.isfinite(nearest) or (nearest == 0.0) != (value == 0):
        raise InputError(
            f"{name} is outside the range of double precision, 1e-308 to 1e308; rescale the units", code=Reason.RANGE
        )
    return value if type(value) is Fraction else Fraction(value)


def nearest_double(value: float | Fraction) -> float:
    """The nearest double; an infinite one beyond their range.

    ``value``: an exact number, or an infinity.
    """
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def square_root(value: Fraction) -> float:
    """The double nearest to the square root of an exact number, exact for the square of a double; ``inf`` on overflow.

    ``value``: a nonnegative number of any size.

    Notes
    -----
    The integer root carries at least 119 bits, cut off below: the result can miss the nearest double only where the
    root lies within ``2^-118`` (relative) of the midpoint of two doubles.

    Examples
    --------
    >>> square_root(Fraction(288_000_000, 8))
    6000.0
    """
    if not value:
        return 0.0
    shift = 240 - (value.numerator.bit_length() - value.denominator.bit_length())
    shift += shift % 2
    top, bottom = value.numerator << max(shift, 0), value.denominator << max(-shift, 0)
    root = math.isqrt(top // bottom)
    try:
        return root / 2 ** (shift // 2) if shift > 0 else float(root * 2 ** (-shift // 2))
    except OverflowError:
        return math.inf
