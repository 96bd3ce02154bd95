"""Sectors and slope bounds: what is known of a nonlinearity, as exact numbers."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Self

from lure.errors import InputError, Reason
from lure.exact import exact_number
from lure.record import Record, quantity, rounded
from lure.record.values import Towards

_LONGEST = 24
_A_BOUND = "a number (int, float or Fraction), -math.inf or math.inf"


def lower_text(value: float | Fraction) -> str:
    """A lower bound as text, rounded up where it is long."""
    return _bound(value, "above")


def upper_text(value: float | Fraction) -> str:
    """An upper bound as text, rounded down where it is long."""
    return _bound(value, "below")


def _bound(value: float | Fraction, towards: Towards) -> str:
    short = f"{float(value):g}"
    if not math.isfinite(value) or Fraction(short) == Fraction(value) or float(short) == value:
        return short
    whole = str(Fraction(value))
    if isinstance(value, float):
        return repr(value)
    if len(whole) <= _LONGEST:
        return whole
    return rounded(Fraction(value), towards, 17)


class Bounds(Record, kw_only=False):
    """Bounds on a quotient of values of ``phi``: a :class:`Sector` or :class:`SlopeBounds`."""

    lower: float | Fraction = quantity("Lower bound", form=lower_text)
    upper: float | Fraction = quantity("Upper bound", form=upper_text)
    _said = "text"

    def __post_init__(self) -> None:
        name = type(self).__name__
        for label, bound in (("lower", self.lower), ("upper", self.upper)):
            if isinstance(bound, bool) or not isinstance(bound, int | float | Fraction):
                raise InputError(f"{name}.{label} is {bound!r}; give {_A_BOUND}")
            if isinstance(bound, float) and math.isnan(bound):
                raise InputError(
                    f"{name}.{label} is nan, which bounds nothing; give {_A_BOUND}", code=Reason.NO_NUMBERS
                )
            if not (isinstance(bound, float) and math.isinf(bound)):
                exact_number(bound, f"{name}.{label}")
        if not self.lower < self.upper:
            raise InputError(f"{name} needs lower < upper; got [{self.lower}, {self.upper}]")

    @classmethod
    def line(cls, gain: Fraction) -> Self:
        """The bounds ``[gain, gain]``, which hold ``phi(sigma) = gain sigma`` only and which no theorem takes.

        The constructors refuse them: a linear gain belongs into the block.

        Parameters
        ----------
        gain : Fraction
            The gain.
        """
        made = object.__new__(cls)
        object.__setattr__(made, "lower", gain)
        object.__setattr__(made, "upper", gain)
        return made

    def __str__(self) -> str:
        """The bounds as text, exact if that is short, else rounded inwards: no other sector is claimed."""
        return f"[{lower_text(self.lower)}, {upper_text(self.upper)}]"


class Sector(Bounds, kw_only=False):
    r"""The nonlinearities with ``lower * sigma^2 <= sigma * phi(sigma) <= upper * sigma^2`` for every ``sigma``.

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

    _kind = "sector"
    _title = "Sector: lower sigma^2 <= sigma phi(sigma) <= upper sigma^2"


class SlopeBounds(Bounds, kw_only=False):
    r"""The nonlinearities with ``lower <= (phi(x) - phi(y)) / (x - y) <= upper`` for every ``x != y``.

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

    _kind = "slope bounds"
    _title = "Slope: lower <= (phi(x) - phi(y))/(x - y) <= upper"
