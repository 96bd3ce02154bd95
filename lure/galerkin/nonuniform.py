"""A rod whose section and material vary along it: what the weak form needs to know of a rod."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lure.errors import AssumptionError, InputError
from lure.expressions import Expression
from lure.nonlinearity import NormalCompliance
from lure.rod import Rod

Array = NDArray[np.float64]
Formula = str | float | Fraction

_FIELDS = ("area", "youngs_modulus", "density")
_LOOKS = 1001


@dataclass(frozen=True, kw_only=True, eq=False)
class NonuniformRod:
    r"""A rod with ``A(x), E(x), rho(x) > 0``, a dashpot at ``x = 0`` and a compliant obstacle beyond ``x = L``.

    .. math::

        \rho A u_{tt} &= (A E u_x)_x + f, & \qquad A E u_x(t,0) &= k u_t(t,0) - g(t), \\
        E u_x(t,L) &= -p(u(t,L) - \mathrm{gap}), & \qquad p(r) &= c_n \max(r,0)^m .

    The force ``g`` pushes along ``x`` [N], ``f`` too [N/m]; ``p >= 0`` is a stress, so the obstacle pushes back with
    ``A(L) p``.  Loads and initial data are a :class:`lure.scenario.Scenario`.

    Attributes
    ----------
    length : float
        ``L > 0`` [m].
    area, youngs_modulus, density : Expression of x
        ``A`` [m^2], ``E`` [Pa], ``rho`` [kg/m^3].
    damping : float
        ``k`` [N s/m], of any sign.
    law : NormalCompliance
        ``p``, with ``c_n = 1/eps`` [Pa/m^m].
    gap : float
        Free distance to the obstacle [m]; negative means pre-loaded.

    Raises
    ------
    InputError
        A number is not finite or ``length`` not positive; a coefficient is not positive at one of 1001 points spread
        evenly over the rod (what it does between them is not seen).
    AssumptionError
        The law is not locally Lipschitz (``m < 1``), which Lemma 3.1 of the paper assumes.
    """

    length: float
    area: Expression
    youngs_modulus: Expression
    density: Expression
    damping: float
    law: NormalCompliance
    gap: float = 0.0

    def __post_init__(self) -> None:
        for name in ("length", "damping", "gap"):
            if not math.isfinite(getattr(self, name)):
                raise InputError(f"rod.{name} is {getattr(self, name):g}; give a finite number")
        if not self.length > 0:
            raise InputError(f"rod.length is {self.length:g}; give a positive number")
        if not self.law.locally_lipschitz:
            raise AssumptionError(
                f"the Galerkin motion is unique for a Lipschitz law (Lemma 3.1), and p = c_n max(r, 0)^m is not one "
                f"for m = {self.law.exponent:g}; take m >= 1"
            )
        for name in _FIELDS:
            self.coefficient(name, np.linspace(0.0, self.length, _LOOKS))

    @classmethod
    def parse(  # noqa: PLR0913  (the parameters of a rod, all by name)
        cls,
        *,
        length: float,
        area: Formula,
        youngs_modulus: Formula,
        density: Formula,
        damping: float,
        compliance: float,
        exponent: float = 1.0,
        gap: float = 0.0,
    ) -> NonuniformRod:
        """Build a rod from numbers and formulas in ``x``.

        Parameters
        ----------
        length, damping, gap : float
            As in the attributes.
        area, youngs_modulus, density : str or number
            Formulas in ``x`` [m] of :class:`lure.expressions.Expression`, or constants.
        compliance, exponent : float
            ``eps > 0`` [m^m/Pa] and ``m >= 1`` of the law.

        Raises
        ------
        InputError
            A formula does not parse, or ``compliance`` is not positive; also as for the class.

        Examples
        --------
        >>> horn = NonuniformRod.parse(
        ...     length=1, area="(1 + x)**2", youngs_modulus=4, density="where(x < 1/2, 1, 2)", damping=1, compliance=1
        ... )
        >>> horn.coefficient("area", [0.0, 1.0]), horn.breakpoints
        (array([1., 4.]), (0.5,))
        """
        if not (math.isfinite(compliance) and compliance > 0):
            raise InputError(f"rod.compliance is {compliance:g}; give a positive number")
        formulas = {
            name: Expression.parse(text, variables=("x",), field=f"rod.{name}")
            for name, text in zip(_FIELDS, (area, youngs_modulus, density), strict=True)
        }
        law = NormalCompliance(1.0 / compliance, exponent)
        return cls(length=float(length), damping=float(damping), gap=float(gap), law=law, **formulas)

    @classmethod
    def from_rod(cls, rod: Rod) -> NonuniformRod:
        """The uniform rod as a special case; parameters are its doubles.

        Parameters
        ----------
        rod : Rod
            The uniform rod.
        """
        formulas = {
            name: Expression.parse(getattr(rod, name), variables=("x",), field=f"rod.{name}") for name in _FIELDS
        }
        return cls(length=rod.length, damping=rod.damping, gap=rod.gap, law=rod.law, **formulas)

    def coefficient(self, name: str, x: NDArray[np.float64] | list[float]) -> Array:
        """Values of ``"area"``, ``"youngs_modulus"`` or ``"density"`` at ``x`` [m].

        Raises
        ------
        InputError
            One of them is not a positive finite number.
        """
        points = np.asarray(x, dtype=float)
        expression: Expression = getattr(self, name)
        values = expression(x=points)
        wrong = ~(np.isfinite(values) & (values > 0))
        if wrong.any():
            raise InputError(
                f"rod.{name} is {values[wrong][0]:g} at x = {points[wrong][0]:g} m; give a formula that is positive on "
                "the whole rod"
            )
        return values

    def inertia(self, x: Array) -> Array:
        """``rho A`` at ``x`` [kg/m]."""
        return self.coefficient("density", x) * self.coefficient("area", x)

    def stretch(self, x: Array) -> Array:
        """``A E`` at ``x`` [N]."""
        return self.coefficient("area", x) * self.coefficient("youngs_modulus", x)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Places inside the rod where a coefficient changes its formula, as far as they are known [m]."""
        return interior_breakpoints(self.length, *(getattr(self, name) for name in _FIELDS))


def interior_breakpoints(length: float, *expressions: Expression) -> tuple[float, ...]:
    """Places in ``(0, length)`` where one of the formulas changes its branch, as far as they are known [m]."""
    found = (expression.breakpoints("x", 0, length) or () for expression in expressions if not expression.is_constant)
    return tuple(sorted({float(point) for points in found for point in points}))
