"""Lists of exact coefficients, from numbers and from text."""

from __future__ import annotations

import re
import reprlib
from collections.abc import Iterable, Sized
from fractions import Fraction

from lure.errors import InputError
from lure.exact import exact_number
from lure.rational import MAX_ORDER

MAX_TEXT = 1 << 16
_MAX_DIGITS = 1000
_MAX_EXPONENT = 400
_DECIMAL = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)"
_NUMBER = re.compile(rf"([+-]?{_DECIMAL})(?:[eE]([+-]?[0-9]+))?(?:/({_DECIMAL}))?")
_BRACKETS = {"[": "]", "(": ")"}


def coefficients(values: object, name: str = "coefficients") -> tuple[Fraction, ...]:
    """Exact coefficients from a text such as ``"1 3 2 0"`` or from a list of numbers and texts.

    Parameters
    ----------
    values : object
        Text: numbers separated by blanks or commas, with or without brackets around them; each a whole number, a
        decimal, both perhaps with an exponent, or a quotient ``p/q``.  A list: ints, floats (each the double it is),
        Fractions, Decimals, or such texts of one number.
    name : str
        What they are, for errors.

    Raises
    ------
    InputError
        There is none, there are more than 1001, or one is not a finite real number within the range of doubles.

    Examples
    --------
    >>> coefficients("1, 0.1 -2/3 1e-2")
    (Fraction(1, 1), Fraction(1, 10), Fraction(-2, 3), Fraction(1, 100))
    """
    if isinstance(values, str):
        entries: list[object] = list(_words(values, name))
    elif isinstance(values, Iterable) and getattr(values, "shape", None) != ():  # an array () cannot be listed
        entries = list(values)
    else:
        raise InputError(f"{name} is {reprlib.repr(values)}; give a list of numbers")
    if not entries:
        raise InputError(f"{name} is empty; give at least one number")
    if len(entries) > MAX_ORDER + 1:
        raise InputError(f"{name} has {len(entries)} entries; exact polynomials stop at degree {MAX_ORDER}")
    return tuple(exact_coefficient(entry, f"{name}[{i}]") for i, entry in enumerate(entries))


def exact_coefficient(value: object, name: str) -> Fraction:
    """The exact number that a coefficient is: a text of one number, or as in :func:`lure.exact.exact_number`.

    Raises
    ------
    InputError
        It is complex, not a number, not finite or outside the range of doubles.
    """
    if isinstance(value, str):
        return _number(value.strip(), name)
    if hasattr(value, "item") and getattr(value, "ndim", None) == 0:
        value = value.item()
    if isinstance(value, complex):
        if value.imag != 0:
            raise InputError(f"{name} is {value}, a complex coefficient; a real loop needs real numbers")
        value = value.real
    if isinstance(value, Sized):
        raise InputError(f"{name} is a list; give one number: a block has one input and one output")
    return exact_number(value, name)


def _words(text: str, name: str) -> list[str]:
    if len(text) > MAX_TEXT:
        raise InputError(f"{name} has {len(text)} characters; at most {MAX_TEXT} are allowed")
    inner = text.strip()
    if inner[:1] in _BRACKETS:
        if inner[-1:] != _BRACKETS[inner[0]]:
            raise InputError(f"{name} is {reprlib.repr(text)}; close the bracket {inner[0]!r} at the end")
        inner = inner[1:-1].strip()
    if not inner:
        return []
    parts = [part.strip() for part in inner.split(",")]
    if not all(parts):
        raise InputError(f"{name} is {reprlib.repr(text)} with nothing before or after a comma; give a number there")
    return [word for part in parts for word in part.split()]


def _number(text: str, name: str) -> Fraction:
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise InputError(f"{name} is {reprlib.repr(text)}; give a number such as 2, -0.5, 1e-3 or 2/3")
    mantissa, exponent, below = match.groups()
    if len(text) > 2 * _MAX_DIGITS or (exponent and len(exponent.lstrip("+-0")) > len(str(_MAX_EXPONENT))):
        raise InputError(f"{name} has more than {_MAX_DIGITS} digits or an exponent beyond {_MAX_EXPONENT}; rescale it")
    if below is not None and not Fraction(below):
        raise InputError(f"{name} is {reprlib.repr(text)}, a division by zero; give another denominator")
    value = Fraction(mantissa) * Fraction(10) ** int(exponent or 0) / Fraction(below or 1)
    return exact_number(value, name)
