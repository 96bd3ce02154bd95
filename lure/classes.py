"""Classes of nonlinearities: what is assumed of ``phi``, and nothing more."""

from __future__ import annotations

import decimal
import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeVar

from lure.errors import InputError
from lure.exact import exact_number
from lure.record import html_table, plain

# Sectors and slope bounds: what is known of a nonlinearity, as exact numbers.

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


@dataclass(frozen=True, kw_only=True, slots=True)
class NonlinearityClass:
    r"""All ``phi`` with ``phi(0) = 0`` that satisfy the properties listed; a theorem holds for every one of them.

    Parameters
    ----------
    sector : Sector
        Bounds on ``phi(sigma) / sigma``.
    slope : SlopeBounds or None
        Bounds on every difference quotient, None if nothing is assumed of them.
    odd : bool
        Whether ``phi(-sigma) = -phi(sigma)`` is assumed.
    time_varying : bool
        Whether ``phi`` may depend on time; then ``slope`` and ``odd`` hold at each time.

    Raises
    ------
    InputError
        The slope bounds lie outside the sector's: members would leave the sector; or the bounds coincide.

    Examples
    --------
    >>> print(NonlinearityClass(sector=Sector(0, 2), slope=SlopeBounds(0, 2), odd=True))
    odd phi with slope in [0, 2]
    """

    sector: Sector
    slope: SlopeBounds | None = None
    odd: bool = False
    time_varying: bool = False

    def __post_init__(self) -> None:
        for bounds in (self.sector, self.slope):
            if bounds is not None and bounds.lower == bounds.upper:
                raise InputError(
                    f"NonlinearityClass has the bounds {bounds}, in which only a straight line lies; a linear gain "
                    "belongs into the block"
                )
        if self.slope is not None and (self.slope.lower > self.sector.lower or self.slope.upper < self.sector.upper):
            raise InputError(
                f"NonlinearityClass has the sector {self.sector} and the slope bounds {self.slope}: a law with these "
                "slopes lies in the sector of the same bounds; give a sector inside the slope bounds"
            )

    @classmethod
    def slope_restricted(
        cls, lower: float | Fraction, upper: float | Fraction, *, odd: bool = False
    ) -> NonlinearityClass:
        """Time-invariant laws with slope in ``[lower, upper]``, hence in the same sector."""
        return cls(sector=Sector(lower, upper), slope=SlopeBounds(lower, upper), odd=odd)

    def __str__(self) -> str:
        words = "odd phi" if self.odd else "phi"
        bounds = f"slope in {self.slope}" if self.slope is not None else f"sector {self.sector}"
        if self.slope is not None and (self.slope.lower, self.slope.upper) != (self.sector.lower, self.sector.upper):
            bounds += f" and sector {self.sector}"
        when = ", time-varying" if self.time_varying else ""
        return f"{words} with {bounds}{when}" if self.slope is not None else f"{words} in the {bounds}{when}"

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data: exact bounds as text ``p/q``, infinite ones as ``inf``."""
        return {
            "kind": "class of laws",
            "sector": plain(self.sector),
            "slope": plain(self.slope),
            "odd": self.odd,
            "time_varying": self.time_varying,
            "text": str(self),
        }

    def _repr_html_(self) -> str:
        rows = [
            ("sector", self.sector),
            ("slope", "nothing is assumed" if self.slope is None else self.slope),
            ("odd", "assumed" if self.odd else "not assumed"),
            ("time", "phi may depend on it" if self.time_varying else "phi does not depend on it"),
        ]
        return html_table(f"Class of laws: {self}", rows)


@dataclass(frozen=True, slots=True)
class Diagonal:
    """The classes of several nonlinearities, one for each channel: ``mu_i = -phi_i(sigma_i)``.

    Parameters
    ----------
    classes : tuple of NonlinearityClass
        One for each channel.
    repeated : bool
        Whether all channels have the same nonlinearity; then their classes are equal.

    Raises
    ------
    InputError
        There is no class, or ``repeated`` ones differ.

    Examples
    --------
    >>> print(Diagonal((NonlinearityClass(sector=Sector(0, 2)),)))
    phi in the sector [0, 2]
    """

    classes: tuple[NonlinearityClass, ...]
    repeated: bool = False

    def __post_init__(self) -> None:
        if not self.classes:
            raise InputError("Diagonal has no class; give one for each channel")
        if self.repeated and len(set(self.classes)) > 1:
            raise InputError(f"Diagonal repeats one nonlinearity, and its classes differ: {self}")

    def __str__(self) -> str:
        return "; ".join(map(str, self.classes))
