"""The rod: parameters and the constants derived from them."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from types import MappingProxyType
from typing import cast

from lure.errors import InputError
from lure.exact import Exact, exact_number, nearest_double, square_root
from lure.nonlinearities.base import NormalCompliance

PARAMETERS = ("youngs_modulus", "density", "length", "area", "damping", "compliance", "exponent", "gap")
_MULTIPLE = re.compile(r"([+-]?)\s*([0-9][^\s*Z]*|\.[0-9][^\s*Z]*)?\s*\*?\s*Z(?:\s*/\s*([0-9.]+))?")
_POSITIVE = ("youngs_modulus", "density", "length", "area", "compliance", "exponent")


@dataclass(frozen=True, kw_only=True)
class Rod:
    r"""An elastic rod with a dashpot at ``x = 0`` and a compliant obstacle beyond ``x = L``.

    .. math::

        \rho u_{tt} &= E u_{xx} + f(t,x)/A, & \qquad A E u_x(t,0) &= k u_t(t,0) - g(t), \\
        E u_x(t,L) &= -p(u(t,L) - \mathrm{gap}), & \qquad p(r) &= \max(r,0)^m / \varepsilon .

    A parameter is a number or the text of one, such as ``"0.1"`` or ``"1/3"``: text is exact, and a float is the double
    that it is.  The damping may be a multiple of the impedance, ``"2 Z"``.  The limit ``eps -> 0`` is the Signorini
    (rigid) obstacle.  Loads and initial data are not part of the rod: see :class:`lure.rod.scenario.Scenario`.

    Parameters
    ----------
    youngs_modulus : number
        ``E > 0`` [Pa].
    density : number
        ``rho > 0`` [kg/m^3].
    length : number
        ``L > 0`` [m].
    area : number
        ``A > 0``, cross-section [m^2].
    damping : number
        ``k``, dashpot at ``x = 0`` [N s/m], or the text of a multiple of ``Z = A sqrt(rho E)``: ``"2 Z"``, ``"-Z/3"``,
        exact where ``Z`` is rational, else the double nearest to it.  Zero and negative values are physics, not
        mistakes: the analysis answers INCONCLUSIVE and REFUTED.  ``k = -Z`` leaves the boundary condition unsolvable
        and is refused.
    compliance : number
        ``eps > 0``; the contact stiffness is ``c_n = 1/eps`` [Pa/m^m].  ``eps`` itself is in m^m/Pa.
    exponent : number, default 1
        ``m > 0`` of the normal compliance law [-].
    gap : number, default 0
        Free distance between the unstressed end and the obstacle [m]; negative means pre-loaded.

    Attributes
    ----------
    exact : Mapping[str, Fraction]
        Each parameter as the exact rational given; the attributes of the same names are the nearest doubles.
        ``rod.replace(damping=k)`` varies a rod without loss; ``dataclasses.replace`` would round the other parameters
        to doubles.  Rods are equal if these are.

    Raises
    ------
    InputError
        A parameter is no finite number, nor the text of one, is not positive where it must be, ``k = -Z``, or a derived
        constant lies outside the range of doubles.

    References
    ----------
    Danciu, Matei, Micu, Roventa, "Nonlinear Feedback Control and Artificial Intelligence Computational Methods applied
    to a Dissipative Dynamic Contact Problem", equations (8) and (9); signs as corrected in :mod:`lure.rod.derivation`.

    Examples
    --------
    >>> rod = Rod(youngs_modulus=288e6, density=8, length=1, area=0.25e-4, damping=2e-4, compliance=1, gap=0.02)
    >>> print(f"{rod.wave_speed:g} m/s, {rod.impedance:g} N s/m, a = {rod.reflection:.6f}")
    6000 m/s, 1.2 N s/m, a = -0.999667
    """

    youngs_modulus: float
    density: float
    length: float
    area: float
    damping: float
    compliance: float
    exponent: float = 1.0
    gap: float = 0.0
    exact: Mapping[str, Fraction] = field(init=False, repr=False, hash=False)

    def __post_init__(self) -> None:
        multiple = impedance_multiple(self.damping, "rod.damping")
        given = {name: getattr(self, name) for name in PARAMETERS if name != "damping" or multiple is None}
        exact = {name: _parameter(value, f"rod.{name}") for name, value in given.items()}
        for name in _POSITIVE:
            if exact[name] <= 0:
                raise InputError(f"rod.{name} is {float(exact[name]):g}; give a positive number")
        if multiple is not None:
            squared = exact["area"] ** 2 * exact["density"] * exact["youngs_modulus"]
            exact = {name: exact.get(name, _times_root(multiple, squared)) for name in PARAMETERS}
        for name, value in exact.items():
            object.__setattr__(self, name, float(value))
        object.__setattr__(self, "exact", MappingProxyType(exact))
        if multiple == -1 or (exact["damping"] < 0 and self._ratio[1] == 0):
            raise InputError(
                f"rod.damping is {self.damping:g}, minus the impedance of the rod: the condition at x = 0 then fixes "
                "the incoming wave and leaves the outgoing one free, so the motion is not determined; give another "
                "damping"
            )
        for quantity, constant, unit in self._derived():
            if not math.isfinite(constant) or constant == 0:
                raise InputError(f"rod: {quantity} comes out as {constant:g} {unit} in doubles; rescale the units")

    def replace(self, **changes: Exact | str) -> Rod:
        """The rod with some parameters changed; the others stay the exact numbers that they are.

        What ``copy.replace`` does from Python 3.13 on.

        Parameters
        ----------
        **changes : number or str
            New values, by the names of the parameters.

        Raises
        ------
        InputError
            A name is none of a parameter, or there is no such rod.

        Examples
        --------
        >>> rod = Rod(youngs_modulus=288e6, density=8, length="1/3", area="0.25e-4", damping="2e-4", compliance=1)
        >>> stiff = rod.replace(damping="0.3", gap="1/50")
        >>> print(stiff.exact["damping"], stiff.exact["gap"], stiff.exact["length"])
        3/10 1/50 1/3
        """
        unknown = sorted(set(changes) - set(PARAMETERS))
        if unknown:
            raise InputError(f"a rod has no parameter {unknown[0]!r}; it has {', '.join(PARAMETERS)}")
        return Rod(**cast("dict[str, float]", {**self.exact, **changes}))

    __replace__ = replace

    def __reduce__(self) -> tuple[Callable[[dict[str, Fraction]], Rod], tuple[dict[str, Fraction]]]:
        """Pickle and copy by the exact parameters, for worker processes."""
        return _rebuilt, (dict(self.exact),)

    @cached_property
    def wave_speed(self) -> float:
        """``c = sqrt(E/rho)`` [m/s]."""
        return square_root(self.exact["youngs_modulus"] / self.exact["density"])

    @cached_property
    def impedance(self) -> float:
        """``Z = A sqrt(rho E)`` [N s/m]."""
        return square_root(self._squared_impedance)

    @cached_property
    def travel_time(self) -> float:
        """``T = L/c``, one transit of the rod [s]."""
        return square_root(self.exact["length"] ** 2 * self.exact["density"] / self.exact["youngs_modulus"])

    @cached_property
    def reflection(self) -> float:
        """``a = (k - Z)/(k + Z)``; a wave comes back from the dashpot as ``-a`` times itself [-].

        Without cancellation near ``k = Z`` and ``k = -Z``: ``(k/Z)^2 - 1`` is rational and taken exactly.  Zero for
        ``k = Z``, and where ``k`` is a double and the one nearest to ``Z``: a double can come no closer.
        """
        ratio, (one_plus, defect) = self._squared_ratio, self._ratio
        if self._matched:
            return 0.0
        size = defect / one_plus**2 if self.damping >= 0 else one_plus**2 / defect
        return size if ratio > 1 else -size

    @cached_property
    def input_gain(self) -> float:
        """``b = 1/(k + Z)``: the force ``g`` sends out the wave ``2 b g`` [m/(N s)]."""
        k, Z, (one_plus, defect) = self.damping, self.impedance, self._ratio
        return 1.0 / (k + Z) if k >= 0 else one_plus / (defect * (Z if self._squared_ratio < 1 else k))

    @cached_property
    def mobility(self) -> float:
        """``d = 1/sqrt(rho E)``: end velocity per contact stress [m/(Pa s)]."""
        return square_root(1 / (self.exact["density"] * self.exact["youngs_modulus"]))

    @cached_property
    def residue_at_zero(self) -> float:
        """``rho_0 = d (1 - a)/(1 + a) = A/k``, residue of ``H`` at ``s = 0`` [m/(Pa s)]; ``inf`` for ``k = 0``."""
        return self.area / self.damping if self.damping else math.inf

    @cached_property
    def _squared_impedance(self) -> Fraction:
        return self.exact["area"] ** 2 * self.exact["density"] * self.exact["youngs_modulus"]

    @property
    def _matched(self) -> bool:
        k = self.exact["damping"]
        as_doubles = k == Fraction(self.damping) and self.damping == self.impedance
        return k > 0 and (self._squared_ratio == 1 or as_doubles)

    @cached_property
    def _squared_ratio(self) -> Fraction:
        return self.exact["damping"] ** 2 / self._squared_impedance

    @cached_property
    def _ratio(self) -> tuple[float, float]:
        """``1 + q`` and ``1 - q^2`` for the one of ``q = |k|/Z`` and ``q = Z/|k|`` that is at most 1."""
        square = min(self._squared_ratio, 1 / self._squared_ratio) if self.damping else Fraction(0)
        return 1.0 + square_root(square), float(1 - square)

    def _derived(self) -> tuple[tuple[str, float, str], ...]:
        """The constants that must be finite and not zero, each with its name and unit."""
        return (
            ("the wave speed sqrt(E/rho)", self.wave_speed, "m/s"),
            ("the impedance A sqrt(rho E)", self.impedance, "N s/m"),
            ("the travel time L/c", self.travel_time, "s"),
            ("the mobility 1/sqrt(rho E)", self.mobility, "m/(Pa s)"),
            ("the input gain 1/(k + Z)", self.input_gain, "m/(N s)"),
            ("the contact stiffness 1/eps", nearest_double(1 / self.exact["compliance"]), "Pa/m^m"),
            ("the residue A/k", nearest_double(self.exact["area"] / (self.exact["damping"] or 1)), "m/(Pa s)"),
        )

    @cached_property
    def nonlinearity(self) -> NormalCompliance:
        """The contact law ``p``, with stiffness ``1/eps``."""
        stiffness, exponent = 1 / self.exact["compliance"], self.exact["exponent"]
        return NormalCompliance(cast("float", stiffness), cast("float", exponent))


def impedance_multiple(value: object, name: str) -> Fraction | None:
    """The factor of a text such as ``"2 Z"``, ``"-Z"``, ``"0.5*Z"`` or ``"Z/3"``; None for anything without a Z.

    ``value``: what was given; ``name``: where, for errors.

    Raises
    ------
    InputError
        There is a Z and no such multiple of it.
    """
    if not isinstance(value, str) or "Z" not in value:
        return None
    from lure.plants.text import exact_coefficient

    match = _MULTIPLE.fullmatch(value.strip())
    if match is None:
        raise InputError(f"{name} is {value!r:.60}; give a number or a multiple of the impedance, such as '2 Z'")
    sign, factor, divisor = match.groups()
    factors = [exact_coefficient(text, name) for text in (factor or "1", divisor or "1")]
    if factors[1] == 0:
        raise InputError(f"{name} is {value!r:.60}, a division by zero; give another multiple of Z")
    return factors[0] / factors[1] * (-1 if sign == "-" else 1)


def _times_root(multiple: Fraction, squared: Fraction) -> Fraction:
    """``multiple`` times the square root: exact where that is rational, else the double nearest to it."""
    root = Fraction(math.isqrt(squared.numerator), math.isqrt(squared.denominator))
    if root**2 == squared:
        return multiple * root
    return exact_number(math.copysign(square_root(squared * multiple**2), multiple), "rod.damping")


def _parameter(value: object, name: str) -> Fraction:
    if isinstance(value, str):
        from lure.plants.text import exact_coefficient

        return exact_coefficient(value, name)
    return exact_number(value, name)


def _rebuilt(exact: dict[str, Fraction]) -> Rod:
    return Rod(**cast("dict[str, float]", exact))
