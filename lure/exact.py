"""Numbers as given: every real input is kept as an exact rational beside its nearest double."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction

from lure.errors import InputError

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
    if hasattr(value, "item") and getattr(value, "ndim", None) == 0:
        value = value.item()
    if isinstance(value, bool) or not isinstance(value, int | float | Fraction | Decimal):
        raise InputError(f"{name} is {value!r}; give a number")
    if not isinstance(value, int | Fraction) and not math.isfinite(value):
        raise InputError(f"{name} is {value}; give a finite number")
    exact = Fraction(value)
    try:
        nearest = float(exact)
    except OverflowError:
        nearest = math.inf
    if not math.isfinite(nearest) or (nearest == 0.0) != (exact == 0):
        raise InputError(f"{name} is outside the range of double precision, 1e-308 to 1e308; rescale the units")
    return exact
