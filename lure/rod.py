"""The rod: parameters and the constants derived from them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from types import MappingProxyType
from typing import cast

from lure.errors import InputError
from lure.exact import exact_number
from lure.nonlinearity import NormalCompliance

PARAMETERS = ("youngs_modulus", "density", "length", "area", "damping", "compliance", "exponent", "gap")
_MATCHED = 8 * 2.0**-52
_POSITIVE = ("youngs_modulus", "density", "length", "area", "compliance", "exponent")


@dataclass(frozen=True, kw_only=True)
class Rod:
    r"""An elastic rod with a dashpot at ``x = 0`` and a compliant obstacle beyond ``x = L``.

    .. math::

        \rho u_{tt} = E u_{xx} + f(t,x)/A, \qquad
        A E u_x(t,0) = k u_t(t,0) - g(t), \qquad
        E u_x(t,L) = -p(u(t,L) - \mathrm{gap}), \qquad p(r) = \max(r,0)^m / \varepsilon .

    The limit ``eps -> 0`` is the Signorini (rigid) obstacle.  Loads and initial data are not part of the rod: see
    :class:`lure.scenario.Scenario`.

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
        ``k``, dashpot at ``x = 0`` [N s/m].  Zero and negative values are physics, not mistakes: the analysis answers
        INCONCLUSIVE and REFUTED.  ``k = -Z`` leaves the boundary condition unsolvable and is refused.
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

    Raises
    ------
    InputError
        A parameter is not a finite number, is not positive where it must be, or ``k = -Z``.

    References
    ----------
    Danciu, Matei, Micu, Roventa, "Nonlinear Feedback Control and Artificial Intelligence Computational Methods applied
    to a Dissipative Dynamic Contact Problem", equations (8) and (9); signs as corrected in :mod:`lure.derivation`.

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
    exact: Mapping[str, Fraction] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        exact = {name: exact_number(getattr(self, name), f"rod.{name}") for name in PARAMETERS}
        for name in _POSITIVE:
            if exact[name] <= 0:
                raise InputError(f"rod.{name} is {float(exact[name]):g}; give a positive number")
        for name, value in exact.items():
            object.__setattr__(self, name, float(value))
        object.__setattr__(self, "exact", MappingProxyType(exact))
        squared_impedance = exact["area"] ** 2 * exact["density"] * exact["youngs_modulus"]
        if exact["damping"] < 0 and exact["damping"] ** 2 == squared_impedance:
            raise InputError(
                f"rod.damping is {self.damping:g}, minus the impedance of the rod: the condition at x = 0 then fixes the "
                "incoming wave and leaves the outgoing one free, so the motion is not determined; give another damping"
            )
        derived = (self.wave_speed, self.impedance, self.travel_time, self.input_gain, self.mobility)
        if not all(math.isfinite(value) and value != 0 for value in derived):
            raise InputError(
                f"rod: wave speed {self.wave_speed:g} m/s, impedance {self.impedance:g} N s/m and travel time "
                f"{self.travel_time:g} s must be finite and nonzero in double precision; rescale the units"
            )

    @property
    def wave_speed(self) -> float:
        """``c = sqrt(E/rho)`` [m/s]."""
        return math.sqrt(self.youngs_modulus) / math.sqrt(self.density)

    @property
    def impedance(self) -> float:
        """``Z = A sqrt(rho E)`` [N s/m]."""
        return self.area * math.sqrt(self.density) * math.sqrt(self.youngs_modulus)

    @property
    def travel_time(self) -> float:
        """``T = L/c``, one transit of the rod [s]."""
        return self.length / self.wave_speed

    @property
    def reflection(self) -> float:
        """``a = (k - Z)/(k + Z)``; a wave comes back from the dashpot as ``-a`` times itself [-].

        Without cancellation near ``k = Z``: ``k^2 - Z^2`` is rational and taken exactly.  Zero where ``k`` and ``Z`` agree
        to the last four units of double precision, since parameters given as doubles can come no closer to ``k = Z``.
        """
        k, Z, excess = self.damping, self.impedance, self._squared_excess
        if k == 0:
            return -1.0
        if abs(excess) <= _MATCHED * Z * Z and k > 0:
            return 0.0
        return excess / (k + Z) ** 2 if k > 0 else (k - Z) ** 2 / excess

    @property
    def input_gain(self) -> float:
        """``b = 1/(k + Z)``: the force ``g`` sends out the wave ``2 b g`` [m/(N s)]."""
        k, Z = self.damping, self.impedance
        return 1.0 / (k + Z) if k >= 0 else (k - Z) / self._squared_excess

    @property
    def mobility(self) -> float:
        """``d = 1/sqrt(rho E)``: end velocity per contact stress [m/(Pa s)]."""
        return 1.0 / (math.sqrt(self.density) * math.sqrt(self.youngs_modulus))

    @property
    def residue_at_zero(self) -> float:
        """``rho_0 = d (1 - a)/(1 + a) = A/k``, residue of ``H`` at ``s = 0`` [m/(Pa s)]; ``inf`` for ``k = 0``."""
        return self.area / self.damping if self.damping else math.inf

    @property
    def _squared_excess(self) -> float:
        exact = self.exact
        return float(exact["damping"] ** 2 - exact["area"] ** 2 * exact["density"] * exact["youngs_modulus"])

    @property
    def law(self) -> NormalCompliance:
        """The contact law ``p``, with stiffness ``1/eps``."""
        stiffness, exponent = 1 / self.exact["compliance"], self.exact["exponent"]
        return NormalCompliance(cast("float", stiffness), cast("float", exponent))
