"""Sectors and slope bounds: what is known of a nonlinearity, as exact numbers."""

from __future__ import annotations

import decimal
import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeVar

from lure.errors import InputError
from lure.exact import exact_number
from lure.showing import html_table, plain

Bounds = TypeVar("Bounds", "Sector", "SlopeBounds")
_LONGEST = 24
_A_BOUND = "an int, a float, a Fraction or math.inf"


def _check_bounds(name: str, lower: float | Fraction, upper: float | Fraction) -> None:
    for label, bound in (("lower", lower), ("upper", upper)):
        if isinstance(bound, bool) or not isinstance(bound, int | float | Fraction):
            raise InputError(f"{name}.{label} is {bound!r}; give {_A_BOUND}")
        if bound != bound:
            raise InputError(f"{name}.{label} is nan; give {_A_BOUND}")
        if bound not in (math.inf, -math.inf):
            exact_number(bound, f"{name}.{label}")
    if not lower < upper:
        raise InputError(f"{name} needs lower < upper; got [{lower}, {upper}]")


def _interval(lower: float | Fraction, upper: float | Fraction) -> str:
    """The bounds as text, exact if that is short, else rounded inwards: no other sector is claimed."""
    return f"[{_bound(lower, decimal.ROUND_CEILING)}, {_bound(upper, decimal.ROUND_FLOOR)}]"


def _bound(value: float | Fraction, rounding: str) -> str:
    short = f"{float(value):g}"
    if value in (math.inf, -math.inf) or Fraction(short) == Fraction(value) or float(short) == value:
        return short
    whole = str(Fraction(value))
    if isinstance(value, float):
        return repr(value)
    if len(whole) <= _LONGEST:
        return whole
    exact = Fraction(value)
    context = decimal.Context(prec=17, rounding=rounding)
    return str(context.divide(decimal.Decimal(exact.numerator), decimal.Decimal(exact.denominator)))


def _line(kind: type[Bounds], gain: Fraction) -> Bounds:
    """Bounds that coincide, which the constructors refuse: a linear gain belongs into the block."""
    made = object.__new__(kind)
    object.__setattr__(made, "lower", gain)
    object.__setattr__(made, "upper", gain)
    return made


@dataclass(frozen=True, slots=True)
class Sector:
    r"""The laws with ``lower * sigma^2 <= sigma * phi(sigma) <= upper * sigma^2`` for every ``sigma``.

    An infinite bound drops the inequality on that side; ``Sector(0, inf)`` is ``sigma * phi(sigma) >= 0``.
    A sector bounds the chord from the origin, not the slope: see :class:`SlopeBounds`.

    Parameters
    ----------
    lower, upper : int, float or Fraction
        ``lower < upper`` [unit of phi / unit of sigma]; ``-inf`` and ``inf`` are allowed.

    Raises
    ------
    InputError
        A bound is not a number, lies outside the range of doubles, or ``lower >= upper``.

    Examples
    --------
    >>> print(Sector(0, 2))
    [0, 2]
    """

    lower: float | Fraction
    upper: float | Fraction

    def __post_init__(self) -> None:
        _check_bounds("Sector", self.lower, self.upper)

    @classmethod
    def line(cls, gain: Fraction) -> Sector:
        """The sector ``[gain, gain]``, which holds ``phi(sigma) = gain sigma`` only and which no theorem takes.

        Parameters
        ----------
        gain : Fraction
            The gain.
        """
        return _line(cls, gain)

    def __str__(self) -> str:
        return _interval(self.lower, self.upper)

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data: exact bounds as text ``p/q``, infinite ones as ``inf``."""
        return {"kind": "sector", "lower": plain(self.lower), "upper": plain(self.upper), "text": str(self)}

    def _repr_html_(self) -> str:
        rows = [
            ("lower", _bound(self.lower, decimal.ROUND_CEILING)),
            ("upper", _bound(self.upper, decimal.ROUND_FLOOR)),
        ]
        return html_table("Sector: lower sigma^2 <= sigma phi(sigma) <= upper sigma^2", rows)


@dataclass(frozen=True, slots=True)
class SlopeBounds:
    r"""The laws with ``lower <= (phi(x) - phi(y)) / (x - y) <= upper`` for every ``x != y``.

    Slope bounds imply the sector of the same bounds when ``phi(0) = 0``; the converse is false.

    Parameters
    ----------
    lower, upper : int, float or Fraction
        ``lower < upper`` [unit of phi / unit of sigma]; ``-inf`` and ``inf`` are allowed.

    Raises
    ------
    InputError
        A bound is not a number, or ``lower >= upper``.

    Examples
    --------
    >>> print(SlopeBounds(0, 2))
    [0, 2]
    """

    lower: float | Fraction
    upper: float | Fraction

    def __post_init__(self) -> None:
        _check_bounds("SlopeBounds", self.lower, self.upper)

    @classmethod
    def line(cls, gain: Fraction) -> SlopeBounds:
        """The slope bounds ``[gain, gain]`` of a straight line, which no theorem takes.

        Parameters
        ----------
        gain : Fraction
            The gain.
        """
        return _line(cls, gain)

    def __str__(self) -> str:
        return _interval(self.lower, self.upper)

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data: exact bounds as text ``p/q``, infinite ones as ``inf``."""
        return {"kind": "slope bounds", "lower": plain(self.lower), "upper": plain(self.upper), "text": str(self)}

    def _repr_html_(self) -> str:
        rows = [
            ("lower", _bound(self.lower, decimal.ROUND_CEILING)),
            ("upper", _bound(self.upper, decimal.ROUND_FLOOR)),
        ]
        return html_table("Slope: lower <= (phi(x) - phi(y))/(x - y) <= upper", rows)
