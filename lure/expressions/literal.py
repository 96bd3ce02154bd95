"""A number given as a Python object, as the text that means it exactly."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction
from numbers import Integral

from lure.errors import InputError
from lure.expressions.tree import decimal


def literal(number: int | float | Fraction | Decimal, *, field: str) -> str:
    """A number as the text that means it exactly."""
    if isinstance(number, bool) or not isinstance(number, Integral | float | Fraction | Decimal):
        raise InputError(f"{field}: expected a number or a formula but found a {type(number).__name__}.")
    if not (
        number.is_finite() if isinstance(number, Decimal) else isinstance(number, Integral) or math.isfinite(number)
    ):
        raise InputError(f"{field}: the number must be finite but is {number}.")
    text = None
    if isinstance(number, Decimal):
        small = not number or (abs(number.adjusted()) <= 400 and len(number.as_tuple().digits) <= 500)
        text = decimal(Fraction(number) if number else Fraction(0)) if small else None
    elif isinstance(number, float):
        text = decimal(Fraction(float.__repr__(number)))
    elif isinstance(number, Fraction):
        text = decimal(number)
    else:
        text = decimal(Fraction(int(number)))
    if text is None:
        raise InputError(
            f"{field}: the number is not zero and not between 1e-300 and 1e300 in size with at most 100 digits."
        )
    return text
