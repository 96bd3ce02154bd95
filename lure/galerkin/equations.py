"""The ordinary differential equations of the coefficients, with the integrals the energy estimates need."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lure.errors import InputError
from lure.galerkin.model import GalerkinModel
from lure.galerkin.nonuniform import interior_breakpoints
from lure.galerkin.spaces import quadrature
from lure.scenario import Scenario

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Array = NDArray[np.float64]

INTEGRALS = 5
_MARGIN = 1e-12


@dataclass(frozen=True, kw_only=True, eq=False)
class Equations:
    r"""State ``y = [a, b, D, S, I_g, I_f, J]`` of length ``2 m + 5`` and its rate.

    .. math::

        \dot a = b, \quad M \dot b = g w(0) - C b - K a - A(L) p\, w(L) + F, \quad
        \dot D = k v_0^2, \quad \dot S = g v_0 + F \cdot b, \quad
        \dot I_g = g^2, \quad \dot I_f = \int_0^L \frac{f^2}{\rho A} dx, \quad \dot J = A(L) p,

    with ``v_0 = b.w(0)``.  ``D`` and ``S`` [J] are lost and supplied energy, ``J`` [N s] the impulse of the obstacle.
    ``F``, ``M`` and ``I_f`` are sums over quadrature nodes, so that ``(F.b)^2 <= I_f' b^T M b`` holds as for integrals.

    Attributes
    ----------
    model : GalerkinModel
        The matrices.
    scenario : Scenario
        The loads.
    """

    model: GalerkinModel
    scenario: Scenario

    @cached_property
    def load_nodes(self) -> Array:
        """(q,) quadrature nodes of the body force [m], panels cut where it changes its formula."""
        return self._rule[0]

    @cached_property
    def _rule(self) -> tuple[Array, Array, csr_array]:
        model, f = self.model, self.scenario.body_force
        rule = quadrature(model.space, (*model.rod.breakpoints, *interior_breakpoints(model.rod.length, f)))
        gather = model.space.values(rule.x).T.multiply(rule.w).tocsr()
        return rule.x, rule.w / model.rod.inertia(rule.x), gather

    @cached_property
    def _ends(self) -> tuple[Array, Array, Array, Array]:
        """``w(0)``, ``w(L)``, ``M^-1 w(0)``, ``M^-1 w(L)``."""
        left, right = self.model.space.left, self.model.space.right
        return left, right, self.model.solve_mass(left), self.model.solve_mass(right)

    def loads(self, t: float, span: tuple[float, float]) -> tuple[float, Array | None, float]:
        """``g``, ``F`` and ``int f^2/(rho A)`` at ``t``, read strictly inside ``span``, where formulas do not change.

        Raises
        ------
        InputError
            A load is not finite there.
        """
        margin = _MARGIN * span[1]
        t = min(max(t, span[0] + margin if span[0] else 0.0), span[1] - margin)
        force = 0.0 if self.scenario.force.is_zero else float(self.scenario.force(t=t))
        if not np.isfinite(force):
            raise InputError(f"force.g is {force} at t = {t:g} s; give a formula that is finite over the run")
        if self.scenario.body_force.is_zero:
            return force, None, 0.0
        x, weight, gather = self._rule
        body = self.scenario.body_force(t=t, x=x)
        if not np.isfinite(body).all():
            raise InputError(
                f"force.f is not finite at t = {t:g} s somewhere on the rod; give a formula that is finite over the run"
            )
        return force, gather @ body, float(weight @ body**2)

    def stress(self, z: float, touching: bool) -> float:  # noqa: FBT001  (which of two smooth pieces)
        """Contact stress on the piece of the law that holds: 0 in flight, ``c_n |z|^m sign z`` in contact [Pa]."""
        law = self.model.rod.law
        return float(np.copysign(law.stiffness * abs(z) ** law.exponent, z)) if touching else 0.0

    def rate(self, t: float, y: Array, *, touching: bool, span: tuple[float, float]) -> Array:
        """``y'`` on one smooth piece."""
        model, m = self.model, self.model.space.order
        left, right, from_left, from_right = self._ends
        a, b = y[:m], y[m : 2 * m]
        force, body, squared = self.loads(t, span)
        v0, z = float(left @ b), float(right @ a) - model.rod.gap
        push = model.end_area * self.stress(z, touching)
        inner = -(model.stiffness @ a) if body is None else body - model.stiffness @ a
        accelerations = model.solve_mass(inner) + (force - model.rod.damping * v0) * from_left - push * from_right
        supplied = force * v0 + (0.0 if body is None else float(body @ b))
        integrals = (model.rod.damping * v0 * v0, supplied, force * force, squared, push)
        return np.concatenate((b, accelerations, integrals))

    def jacobian(self, t: float, y: Array, *, touching: bool, span: tuple[float, float]) -> Array:
        """``dy'/dy`` (2m+5, 2m+5), dense, for the implicit method."""
        model, m = self.model, self.model.space.order
        left, right, from_left, from_right = self._ends
        force, body, _ = self.loads(t, span)
        law, z = model.rod.law, float(right @ y[:m]) - model.rod.gap
        slope = model.end_area * law.stiffness * law.exponent * abs(z) ** (law.exponent - 1) * touching
        J = np.zeros((y.size, y.size))
        J[:m, m : 2 * m] = np.eye(m)
        J[m : 2 * m, :m] = -self._inverse_stiffness - slope * np.outer(from_right, right)
        J[m : 2 * m, m : 2 * m] = -model.rod.damping * np.outer(from_left, left)
        J[2 * m, m : 2 * m] = 2.0 * model.rod.damping * float(left @ y[m : 2 * m]) * left
        J[2 * m + 1, m : 2 * m] = force * left + (0.0 if body is None else body)
        J[2 * m + 4, :m] = slope * right
        return J

    @cached_property
    def _inverse_stiffness(self) -> Array:
        return np.asarray(self.model.solve_mass(self.model.stiffness.toarray()))

    def fastest(self) -> float:
        """Fastest rates of the motion in flight, elastic and of the dashpot, together [1/s].

        The elastic part is a Rayleigh quotient after 40 steps of the power method, a little short of the largest.
        """
        model = self.model
        left, _, from_left, _ = self._ends
        vector = np.cos(2.4 * np.arange(model.space.order) ** 1.5)
        for _ in range(40):
            image = model.solve_mass(model.stiffness @ vector)
            size = float(np.abs(image).max())
            vector = image / size if size else vector
        elastic = float(vector @ (model.stiffness @ vector)) / float(vector @ (model.mass @ vector))
        return float(np.sqrt(max(elastic, 0.0)) + abs(model.rod.damping) * float(left @ from_left))
