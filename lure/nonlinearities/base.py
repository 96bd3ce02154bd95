"""What every law of the library offers, and the checks its parameters share."""

from __future__ import annotations

from fractions import Fraction
from typing import Protocol, TypeAlias

from lure.arrays import ArrayLike, NDArray, np
from lure.classes import Sector, SlopeBounds
from lure.errors import InputError
from lure.exact import Exact, exact_number

Parameter: TypeAlias = Exact | str
"""A number, or a text of one such as ``".1"`` or ``"1/3"``."""


class Law(Protocol):
    """A memoryless law ``phi(sigma)`` with ``phi(0) = 0`` that enters the loop as ``mu = -phi(sigma)``."""

    @property
    def sector(self) -> Sector:
        """Bounds on ``phi(sigma)/sigma`` [unit of phi / unit of sigma]."""

    @property
    def slope_bounds(self) -> SlopeBounds | None:
        """Bounds on every difference quotient; None where there are none, or none are known."""

    @property
    def odd(self) -> bool:
        """Whether ``phi(-sigma) = -phi(sigma)`` is known."""

    @property
    def regularity(self) -> str:
        """Continuity and smoothness in words."""

    @property
    def locally_lipschitz(self) -> bool:
        """Whether ``phi`` is known to be locally Lipschitz."""

    def __call__(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Values ``phi(sigma)``, elementwise."""

    def slope(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Derivative, elementwise; at a kink the one from the left, at a jump without it."""

    def primitive(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """``int_0^sigma phi``, elementwise."""


def exact_parameter(value: object, name: str) -> Fraction:
    """The exact number that a parameter is; a text of one number, ``".1"`` or ``"1/3"``, is taken as blocks take it.

    Raises
    ------
    InputError
        It is not a finite number.
    """
    if not isinstance(value, str):
        return exact_number(value, name)
    from lure.plants.text import exact_coefficient

    return exact_coefficient(value, name)


def positive(value: object, name: str) -> Fraction:
    """The exact number, which must be positive.

    Raises
    ------
    InputError
        It is not a positive finite number.
    """
    exact = exact_parameter(value, name)
    if exact <= 0:
        raise InputError(f"{name} is {float(exact):g}; give a positive number")
    return exact


def assign(law: object, **fields: object) -> None:
    """Set the fields of a frozen law, from its own ``__init__``."""
    for name, value in fields.items():
        object.__setattr__(law, name, value)


def number_text(value: Fraction) -> str:
    """An exact number for people: a short decimal where that is exact, else ``p/q``, else six digits.

    >>> number_text(Fraction(1, 8)), number_text(Fraction(-2, 3)), number_text(Fraction(0.1))
    ('0.125', '-2/3', '0.1')
    """
    text = f"{float(value):.6g}"
    short = value.denominator != 1 and max(abs(value.numerator), value.denominator) < 10**6
    return str(value) if short and Fraction(text) != value else text


def factor_text(value: Fraction) -> str:
    """A number before a product: ``2 ``, nothing for 1."""
    return "" if value == 1 else f"{number_text(value)} "
