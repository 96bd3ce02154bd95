"""The ordinary differential equations of the coefficients, with the integrals the energy estimates need."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from lure.arrays import Reals as Array
from lure.errors import InputError
from lure.expressions import Expression
from lure.record import Record, described, quantity
from lure.rod.galerkin.spaces import NonuniformRod, Quadrature, Space, SpaceName, interior_breakpoints, quadrature
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario, finite

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from lure.rod.galerkin.motion import GalerkinRun, Method

# The semi-discrete weak form: matrices of a rod in a space, projections of initial data, energy.

_ROUNDING, _ASIDE, _JUMP = 1e-15, 1e-9, 1e-6


class GalerkinModel(Record):
    r"""A rod in ``V_m``; build it with :func:`galerkin`.

    With ``u_m = sum_j a_j(t) w_j(x)`` the weak form (10), with every constant and the sign of ``g`` as (8) has it, is

    .. math::

        M \ddot a + C \dot a + K a = g\, w(0) - A(L)\, p(a \cdot w(L) - \mathrm{gap})\, w(L) + F(t),

    .. math::

        M_{ij} &= \int_0^L \rho A w_i w_j, & \qquad K_{ij} &= \int_0^L A E w_i' w_j', \\
        C_{ij} &= k\, w_i(0) w_j(0), & \qquad F_i &= \int_0^L f w_i .

    The paper prints ``+ g`` on the left of (10), (11), (14), (20) and (25), against (8) and (15), and ``\dot a`` beside
    ``K`` in (14); here ``g > 0`` pushes along ``x``.

    Notes
    -----
    A break of a coefficient inside an element leaves the integrals right and spoils the order: the motion has a kink
    there that the element cannot bend to.  Choose ``order`` so that a node falls on it.
    """

    rod: NonuniformRod = quantity("The rod")
    space: Space = quantity("``V_m``")
    quadrature: Quadrature = quantity(
        "Panels end at the elements and where a coefficient changes its formula: integrals of piecewise polynomials "
        "are exact to rounding",
        key="",
        label="",
    )

    @cached_property
    def mass(self) -> csr_array:
        """``M`` (m, m), sparse, symmetric positive definite [kg]."""
        return self._gram(self.space.values(self.quadrature.x), self.rod.inertia(self.quadrature.x))

    @cached_property
    def stiffness(self) -> csr_array:
        """``K`` (m, m), sparse, symmetric positive semidefinite with the constants as kernel [N/m]."""
        return self._gram(self.space.slopes(self.quadrature.x), self.rod.stretch(self.quadrature.x))

    @cached_property
    def damping(self) -> csr_array:
        """``C = k w(0) w(0)^T`` (m, m), sparse, of rank one [N s/m]."""
        from scipy.sparse import csr_array

        left = csr_array(self.space.left[None, :])
        return csr_array(self.rod.damping * (left.T @ left))

    @cached_property
    def end_area(self) -> float:
        """``A(L)``, where the contact stress acts [m^2]."""
        return float(self.rod.coefficient("area", np.array([self.rod.length]))[0])

    @cached_property
    def solve_mass(self) -> Any:  # noqa: ANN401  (scipy has no types)
        """The map ``r -> M^-1 r``, from one sparse factorisation."""
        from scipy.sparse.linalg import splu

        return splu(self.mass.tocsc()).solve

    def project(self, u0: Expression, u1: Expression) -> tuple[Array, Array]:
        r"""Initial coefficients: (21) in H1, (22) in L2.

        ``u0_m`` minimises ``int A E (u0' - v')^2 dx`` among the ``v`` in ``V_m`` with ``v(L) = u0(L)``, and ``u1_m``
        minimises ``int rho A (u1 - v)^2 dx``; the first starts the contact coordinate without error.  Both tend to the
        data, as Lemma 3.3 asks, whatever ``u0`` in H1 and ``u1`` in L2; how fast depends on their smoothness.

        Parameters
        ----------
        u0, u1 : Expression of x
            Displacement [m] and velocity [m/s].

        Returns
        -------
        displacement, velocity : ndarray
            (m,) coefficients [m], [m/s].

        Raises
        ------
        InputError
            ``u0``, its slope or ``u1`` is not finite at a node of the quadrature, or ``u0(L)`` is not; or ``u0`` jumps
            where it changes its formula.
        """
        from scipy.sparse import csr_array
        from scipy.sparse.linalg import splu

        rule = quadrature(self.space, (*self.rod.breakpoints, *interior_breakpoints(self.rod.length, u0, u1)))
        finite(u0(x=rule.x), "initial.u0", rule.x)
        refuse_jumps(u0, self.rod.length)
        slope = finite(u0.derivative("x")(x=rule.x), "the slope of initial.u0", rule.x)
        velocity = finite(u1(x=rule.x), "initial.u1", rule.x)
        end = np.array([self.rod.length])
        anchor = self.stiffness.diagonal().mean() or 1.0
        last = csr_array(self.space.right[None, :])
        held = float(finite(u0(x=end), "initial.u0", end)[0])
        pull = self.space.slopes(rule.x).T @ (rule.w * self.rod.stretch(rule.x) * slope)
        fixed = splu((self.stiffness + anchor * (last.T @ last)).tocsc())
        displacement = fixed.solve(pull + anchor * held * self.space.right)
        push = self.space.values(rule.x).T @ (rule.w * self.rod.inertia(rule.x) * velocity)
        return np.asarray(displacement), np.asarray(self.solve_mass(push))

    def energy(self, a: ArrayLike, b: ArrayLike) -> Array:
        r"""``E_m = (b^T M b + a^T K a)/2 + A(L) P(z)``, ``P' = p``, the energy of the rod at ``u_m`` [J].

        For the paper's nonlinearity and ``A = E = rho = 1`` this is its ``E_m``, since ``P = eps p^2/2``.

        Parameters
        ----------
        a, b : array_like
            (..., m) coefficients of displacement and velocity.
        """
        displacement, velocity = np.atleast_2d(a), np.atleast_2d(b)
        kinetic = 0.5 * np.einsum("ij,ij->i", velocity, (self.mass @ velocity.T).T)
        strain = self.space.slopes(self.quadrature.x) @ displacement.T  # no cancellation, however far the rod has moved
        elastic = 0.5 * ((self.quadrature.w * self.rod.stretch(self.quadrature.x)) @ strain**2)
        contact = self.end_area * self.rod.nonlinearity.primitive(displacement @ self.space.right - self.rod.gap)
        return np.asarray(kinetic + elastic + contact).reshape(np.shape(a)[:-1])

    def simulate(
        self,
        scenario: Scenario,
        until: float,
        *,
        samples: int = 501,
        tolerance: float = 1e-10,
        method: Method = "DOP853",
    ) -> GalerkinRun:
        """The motion from the initial data of ``scenario`` under its loads.

        Parameters
        ----------
        scenario : Scenario
            Loads and initial data.
        until : float
            End of the run [s].
        samples : int
            Number of samples, evenly spaced from 0 to ``until``.
        tolerance : float
            Accuracy of each step, from 1e-13 to 1e-3, relative to the largest velocity the data and loads suggest.
        method : {"DOP853", "Radau"}
            Explicit of order 8, or implicit of order 5: for contact or a dashpot so stiff that the explicit method is
            refused; ``m <= 300``.
        """
        from lure.rod.galerkin.motion import simulate

        return simulate(self, scenario, until, samples=samples, tolerance=tolerance, method=method)

    def _gram(self, basis: csr_array, weight: Array) -> csr_array:
        """``sum_q w_q weight_q basis_qi basis_qj``, symmetric; what is rounding beside the diagonal is left out."""
        from scipy.sparse import csr_array, diags_array

        gram = (basis.T @ (diags_array(self.quadrature.w * weight) @ basis)).tocoo()
        size = np.sqrt(np.abs(gram.diagonal()))
        row, column = gram.coords
        kept = np.abs(gram.data) > _ROUNDING * self.space.order * size[row] * size[column]
        matrix = csr_array((gram.data[kept], (row[kept], column[kept])), shape=gram.shape)
        return csr_array(0.5 * (matrix + matrix.T))


def galerkin(rod: Rod | NonuniformRod, *, space: SpaceName = "P1", order: int) -> GalerkinModel:
    """The semi-discrete weak form of a rod, section 3 of the paper.

    Parameters
    ----------
    rod : Rod or NonuniformRod
        The rod; ``m < 1`` in its contact law is refused.
    space : {"P1", "P2", "cosine"}
        See :class:`lure.rod.galerkin.spaces.Space`.
    order : int
        ``m``, the dimension of the space: nodes of the elements, or number of cosines.

    Raises
    ------
    InputError
        ``space`` is unknown, ``order`` does not fit it, or a coefficient is not positive at a quadrature node.
    AssumptionError
        The contact law is not Lipschitz.

    Examples
    --------
    >>> from lure.rod import Rod, Scenario
    >>> rod = Rod(youngs_modulus=1, density=1, length=1, area=1, damping=1, compliance=1, gap=0.5)
    >>> model = galerkin(rod, space="P1", order=3)
    >>> (12 * model.mass).toarray().round(12)
    array([[2., 1., 0.],
           [1., 4., 1.],
           [0., 1., 2.]])
    >>> run = model.simulate(Scenario.parse(velocity=1), until=4)
    >>> bool((run.energy <= run.gronwall_bound).all()), len(run.contacts)
    (True, 1)
    """
    nonuniform = rod if isinstance(rod, NonuniformRod) else NonuniformRod.from_rod(rod)
    chosen = Space(name=space, order=order, length=nonuniform.length)
    return GalerkinModel(rod=nonuniform, space=chosen, quadrature=quadrature(chosen, nonuniform.breakpoints))


def refuse_jumps(u0: Expression, length: float) -> None:
    """Refuse a displacement that jumps at a place where it is known to change its formula.

    Raises
    ------
    InputError
        It does.
    """
    for place in interior_breakpoints(length, u0):
        sides = u0(x=place + _ASIDE * length * np.array([-2.0, -1.0, 1.0, 2.0]))
        jump, slope = (
            abs(float(sides[2] - sides[1])),
            max(abs(float(sides[1] - sides[0])), abs(float(sides[3] - sides[2]))),
        )
        if jump > 10.0 * slope + _JUMP * float(np.abs(sides).max()):
            raise InputError(
                f"initial.u0 jumps by {jump:g} m at x = {place:g} m; give a displacement that is continuous, as H1 asks"
            )


INTEGRALS = 5


@described(frozen=True, kw_only=True, eq=False)
class Equations:
    r"""State ``y = [a, b, D, S, I_g, I_f, J]`` of length ``2 m + 5`` and its rate.

    .. math::

        \dot a = b, \quad M \dot b = g w(0) - C b - K a - A(L) p\, w(L) + F, \quad
        \dot D = k v_0^2, \quad \dot S = g v_0 + F \cdot b, \quad
        \dot I_g = g^2, \quad \dot I_f = \int_0^L \frac{f^2}{\rho A} dx, \quad \dot J = A(L) p,

    with ``v_0 = b.w(0)``.  ``D`` and ``S`` [J] are lost and supplied energy, ``J`` [N s] the impulse of the obstacle.
    ``F``, ``M`` and ``I_f`` are sums over quadrature nodes, so that ``(F.b)^2 <= I_f' b^T M b`` holds as for integrals.
    """

    model: GalerkinModel = quantity("The matrices")
    scenario: Scenario = quantity("The loads")

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
        x, weight, gather = self._rule
        force, body = self.scenario.loads(t, x, span)
        return (force, None, 0.0) if body is None else (force, gather @ body, float(weight @ body**2))

    def rate(self, t: float, y: Array, *, touching: bool, span: tuple[float, float]) -> Array:
        """``y'`` on one smooth piece."""
        model, m = self.model, self.model.space.order
        left, right, from_left, from_right = self._ends
        a, b = y[:m], y[m : 2 * m]
        force, body, squared = self.loads(t, span)
        v0, z = float(left @ b), float(right @ a) - model.rod.gap
        push = model.end_area * model.rod.nonlinearity.continued(z)[0] if touching else 0.0
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
        z = float(right @ y[:m]) - model.rod.gap
        slope = model.end_area * model.rod.nonlinearity.continued(z)[1] if touching else 0.0
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
