"""Nonlinearities ``phi(sigma)``, which enter a loop as ``mu = -phi(sigma)``: what each offers, and what it checks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Protocol, TypeAlias

from lure.arrays import ArrayLike, NDArray, np
from lure.classes import Sector, SlopeBounds
from lure.errors import InputError
from lure.exact import Exact, exact_number
from lure.record import Page, Record, quantity
from lure.record.values import exact_text

# What every nonlinearity of the library offers, and the checks its parameters share.

Parameter: TypeAlias = Exact | str
"""A number, or a text of one such as ``".1"`` or ``"1/3"``."""


class LibraryNonlinearity(Protocol):
    """A memoryless nonlinearity ``phi(sigma)`` with ``phi(0) = 0`` that enters the loop as ``mu = -phi(sigma)``."""

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


def assign(nonlinearity: object, **fields: object) -> None:
    """Set the fields of a frozen nonlinearity, from its own ``__init__``."""
    for name, value in fields.items():
        object.__setattr__(nonlinearity, name, value)


def factor_text(value: Fraction) -> str:
    """A number before a product: ``2 ``, nothing for 1."""
    return "" if value == 1 else f"{exact_text(value)} "


class Nonlinearity(Protocol):
    """What a loop needs of a nonlinearity: its sector (the caller's word) and its values."""

    @property
    def sector(self) -> Sector:
        """Sector the caller vouches for [unit of phi / unit of sigma]."""

    def __call__(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Values ``phi(sigma)``, elementwise."""


class NamedNonlinearity(Record):
    """The base of the nonlinearities of the library: what is known of one is its plain data and its table."""

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data: parameters, and what is known with its provenance."""
        from lure.nonlinearities.properties import nonlinearity_dict

        return nonlinearity_dict(self)  # type: ignore[arg-type]  # each is a Nonlinearity

    def _page(self) -> Page:
        from lure.nonlinearities.properties import nonlinearity_page

        return nonlinearity_page(self)  # type: ignore[arg-type]  # every class of the library is a Nonlinearity


class NormalCompliance(NamedNonlinearity, kw_only=False):
    r"""Normal compliance, ``p(r) = c_n max(r, 0)^m`` (Martins and Oden 1987).

    ``r`` is the penetration: displacement of the contacting end minus the gap.  The paper's nonlinearity (9) is ``m =
    1``, ``c_n = 1/eps``.  As ``c_n -> inf`` it tends to the Signorini condition ``r <= 0, p >= 0, r p = 0`` (a rigid
    obstacle), which is a set-valued nonlinearity and not a member of this class.

    The nonlinearity is continuous, nondecreasing, and zero on the whole half-line ``r <= 0``: a loop with it has a
    half-line of equilibria, so that no theorem can make its origin asymptotically stable.

    Parameters
    ----------
    stiffness : float or Fraction
        ``c_n > 0`` [Pa/m^m].
    exponent : float or Fraction
        ``m > 0`` [-].

    Attributes
    ----------
    sector : Sector
        ``[0, c_n]`` for ``m = 1``, else ``[0, inf]``: for ``m > 1`` the chord slope grows without bound as ``r`` grows,
        for ``m < 1`` as ``r`` falls to zero.
    slope_bounds : SlopeBounds
        ``[0, c_n]`` for ``m = 1``, else ``[0, inf]``.
    locally_lipschitz : bool
        ``m >= 1``.
    exact_stiffness, exact_exponent : Fraction
        Both parameters, exactly.

    Raises
    ------
    InputError
        ``c_n`` or ``m`` is not a positive finite number.

    References
    ----------
    J. A. C. Martins and J. T. Oden, Nonlinear Analysis TMA 11 (1987) 407-428.

    Examples
    --------
    >>> nonlinearity = NormalCompliance(stiffness=4, exponent=1)
    >>> print(nonlinearity.sector, nonlinearity([-1.0, 0.5]), nonlinearity.primitive([-1.0, 0.5]))
    [0, 4] [0. 2.] [0.  0.5]
    >>> print(nonlinearity, "and", NormalCompliance(stiffness=1, exponent="3/2"))
    the contact law 4 max(sigma, 0) and the contact law max(sigma, 0)^1.5
    """

    stiffness: float
    exponent: float = 1.0
    exact_stiffness: Fraction = quantity("", init=False)
    exact_exponent: Fraction = quantity("", init=False)
    odd = False  # it pushes one way only

    def __post_init__(self) -> None:

        for name in ("stiffness", "exponent"):
            exact = positive(getattr(self, name), f"NormalCompliance.{name}")
            object.__setattr__(self, f"exact_{name}", exact)
            object.__setattr__(self, name, float(exact))

    @property
    def sector(self) -> Sector:
        """``[0, c_n]`` for ``m = 1``, else ``[0, inf]`` [Pa/m]."""
        return Sector(0, self.exact_stiffness if self.exact_exponent == 1 else math.inf)

    @property
    def slope_bounds(self) -> SlopeBounds:
        """``[0, c_n]`` for ``m = 1``, else ``[0, inf]`` [Pa/m]."""
        return SlopeBounds(0, self.exact_stiffness if self.exact_exponent == 1 else math.inf)

    @property
    def regularity(self) -> str:
        """Continuity in words."""
        if self.exact_exponent == 1:
            return "piecewise linear, globally Lipschitz"
        return "continuous, locally Lipschitz" if self.locally_lipschitz else "continuous, not Lipschitz at 0"

    @property
    def breakpoints(self) -> tuple[Fraction, ...]:
        """The point of contact."""
        return (Fraction(0),)

    @property
    def locally_lipschitz(self) -> bool:
        """Whether ``p`` is locally Lipschitz: ``m >= 1``."""
        return self.exact_exponent >= 1

    def continued(self, r: float) -> tuple[float, float]:
        """``c_n |r|^m sign r`` [Pa] and its slope: the smooth law of contact, for integrators that step beyond it."""
        size, m = abs(r), self.exponent
        steep = 1.0 if m == 1.0 else max(size, 1e-300) ** (m - 1.0)  # for m < 1 without bound at 0
        return math.copysign(self.stiffness * size**m, r), self.stiffness * m * steep

    def __call__(self, penetration: ArrayLike, /) -> NDArray[np.float64]:
        """Contact stress ``p(r)`` [Pa] at the penetration ``r`` [m], elementwise; ``inf`` above the largest double."""
        r = np.maximum(np.asarray(penetration, dtype=float), 0.0)
        with np.errstate(over="ignore", under="ignore"):
            return np.asarray(self.stiffness * r**self.exponent)

    def slope(self, penetration: ArrayLike, /) -> NDArray[np.float64]:
        """Derivative ``p'(r)`` [Pa/m], elementwise; at ``r = 0`` the left derivative, zero."""
        r = np.asarray(penetration, dtype=float)
        outside = r <= 0
        with np.errstate(over="ignore", under="ignore"):
            inside = self.stiffness * self.exponent * np.where(outside, 1.0, r) ** (self.exponent - 1)
        return np.where(outside, 0.0, inside)

    def primitive(self, penetration: ArrayLike, /) -> NDArray[np.float64]:
        """``P(r) = int_0^r p = c_n max(r, 0)^(m+1) / (m+1)`` [Pa m], elementwise."""
        r = np.maximum(np.asarray(penetration, dtype=float), 0.0)
        with np.errstate(over="ignore", under="ignore"):
            return np.asarray(self.stiffness * r ** (self.exponent + 1) / (self.exponent + 1))

    def __str__(self) -> str:

        m = exact_text(self.exact_exponent)
        power = "" if m == "1" else f"^({m})" if "/" in m else f"^{m}"
        return f"the contact law {factor_text(self.exact_stiffness)}max(sigma, 0){power}"


# What is known of a nonlinearity on an interval around 0 alone.


@dataclass(frozen=True, slots=True)
class LocalSector:
    """Every locally Lipschitz ``phi(t, sigma)`` with ``lower <= phi/sigma <= upper`` for ``0 < |sigma| <= radius``.

    Nothing is said of it beyond, so that it is a class for :func:`lure.analysis.region` alone.  In files it is a
    ``[class]`` with ``sector`` and ``on = [-a, b]``, of which the smaller end is the radius.

    Attributes
    ----------
    lower, upper, radius : int, float, Fraction or str
        Exact numbers; a float means the double it is.

    Raises
    ------
    InputError
        A number is none, the bounds are not in order, or the radius is not positive.
    """

    lower: Any
    upper: Any
    radius: Any

    def __post_init__(self) -> None:
        for name in ("lower", "upper", "radius"):
            object.__setattr__(self, name, exact_parameter(getattr(self, name), f"LocalSector.{name}"))
        if not self.lower < self.upper or self.radius <= 0:
            raise InputError(
                f"LocalSector is [{self.lower}, {self.upper}] for |sigma| <= {self.radius}; give two bounds in order, "
                "and a positive radius"
            )

    def __str__(self) -> str:
        return f"phi in the sector [{self.lower}, {self.upper}] for |sigma| <= {self.radius}"
