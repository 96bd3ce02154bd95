"""A rod whose section and material vary along it: what the weak form needs to know of a rod."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.arrays import Reals as Array
from lure.errors import AssumptionError, InputError
from lure.expressions import Expression
from lure.nonlinearities.base import NormalCompliance
from lure.record import described, quantity
from lure.rod.parameters import Rod

if TYPE_CHECKING:
    from scipy.sparse import csr_array

# The spaces V_m of the Galerkin method: P1 and P2 finite elements and cosines, and quadrature along the rod.

SpaceName = Literal["P1", "P2", "cosine"]
SPACES: tuple[SpaceName, ...] = ("P1", "P2", "cosine")
MOST = {"P1": 20_000, "P2": 20_000, "cosine": 500}
_LEAST = {"P1": 2, "P2": 3, "cosine": 1}
_DEGREE = {"P1": 1, "P2": 2}
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


@described(frozen=True, kw_only=True, slots=True, eq=False)
class Space:
    """``V_m = span{w_1, ..., w_m}`` in ``H^1(0, L)``.

    ``"P1"``: continuous, linear on each of ``m - 1`` equal elements.  ``"P2"``: quadratic on each of ``(m - 1)/2``
    (so ``m`` is odd).  In both the coefficients are the values at ``m`` evenly spaced nodes, from ``x = 0`` to
    ``x = L``.  ``"cosine"``: ``w_j = cos((j - 1) pi x/L)``, the modes of the free-free uniform rod; each has slope
    zero at both ends, and the limit of their sums need not.

    Raises
    ------
    InputError
        The kind is unknown, or ``order`` is not a whole number that fits it.
    """

    name: SpaceName = quantity("The kind")
    order: int = quantity("``m``, its dimension")
    length: float = quantity("``L``", "m")

    def __post_init__(self) -> None:
        name, order = self.name, self.order
        if name not in SPACES:
            raise InputError(f"galerkin.space is {name!r}; give one of {', '.join(SPACES)}")
        if isinstance(order, bool) or not isinstance(order, int | np.integer):
            raise InputError(f"galerkin.order is {order!r}; give a whole number, the dimension of the space")
        if not _LEAST[name] <= order <= MOST[name]:
            raise InputError(
                f"galerkin.order is {order}; give a whole number from {_LEAST[name]} to {MOST[name]} for {name}"
            )
        if name == "P2" and order % 2 == 0:
            raise InputError(f"galerkin.order is {order}; give an odd number for P2, 2 n + 1 for n elements")

    @property
    def width(self) -> float:
        """Element length ``h`` [m]; ``L/m`` for cosines."""
        return self.length / (self.order if self.name == "cosine" else (self.order - 1) // _DEGREE[self.name])

    @property
    def edges(self) -> Array:
        """Ends of the elements [m]; for cosines of ``2 m`` panels, half a wave of products each at most."""
        panels = 2 * self.order if self.name == "cosine" else (self.order - 1) // _DEGREE[self.name]
        return np.linspace(0.0, self.length, panels + 1)

    def values(self, x: ArrayLike) -> csr_array:
        """``w_j(x_i)``: (len(x), m), sparse [-]."""
        return self._basis(np.asarray(x, dtype=float), slope=False)

    def slopes(self, x: ArrayLike) -> csr_array:
        """``w_j'(x_i)``: (len(x), m), sparse [1/m]; at a node the slope of the element on its right (left at ``L``)."""
        return self._basis(np.asarray(x, dtype=float), slope=True)

    @property
    def left(self) -> Array:
        """``w_j(0)``, (m,)."""
        return np.ones(self.order) if self.name == "cosine" else np.eye(1, self.order)[0]

    @property
    def right(self) -> Array:
        """``w_j(L)``, (m,)."""
        alternating = np.where(np.arange(self.order) % 2, -1.0, 1.0)
        return alternating if self.name == "cosine" else np.eye(1, self.order, self.order - 1)[0]

    def _basis(self, x: Array, *, slope: bool) -> csr_array:
        from scipy.sparse import coo_array, csr_array

        if self.name == "cosine":
            rate = np.arange(self.order) * (math.pi / self.length)
            phase = np.outer(x, rate)
            return csr_array(-rate * np.sin(phase) if slope else np.cos(phase))
        degree, h = _DEGREE[self.name], self.width
        elements = (self.order - 1) // degree
        element = np.clip(np.floor(x / h).astype(int), 0, elements - 1)
        xi = x / h - element
        if degree == 1:
            local = [-np.ones_like(xi), np.ones_like(xi)] if slope else [1.0 - xi, xi]
        elif slope:
            local = [4.0 * xi - 3.0, 4.0 - 8.0 * xi, 4.0 * xi - 1.0]
        else:
            local = [(1.0 - xi) * (1.0 - 2.0 * xi), 4.0 * xi * (1.0 - xi), xi * (2.0 * xi - 1.0)]
        rows = np.tile(np.arange(x.size), degree + 1)
        columns = np.concatenate([degree * element + node for node in range(degree + 1)])
        data = np.concatenate(local) / (h if slope else 1.0)
        return coo_array((data, (rows, columns)), shape=(x.size, self.order)).tocsr()


@described(frozen=True, kw_only=True, slots=True, eq=False)
class Quadrature:
    """Gauss quadrature on ``(0, L)``, 8 points a panel: exact for polynomials of degree 15 on each."""

    x: Array = quantity("(q,) nodes", "m")
    w: Array = quantity("(q,) weights", "m")


def quadrature(space: Space, breaks: tuple[float, ...] = ()) -> Quadrature:
    """Quadrature on the elements of a space, cut where formulas change.

    ``breaks``: further places where panels end [m].
    """
    edges = np.union1d(space.edges, np.asarray(breaks, dtype=float))
    half = 0.5 * np.diff(edges)[:, None]
    x = 0.5 * (edges[1:] + edges[:-1])[:, None] + half * _NODES
    return Quadrature(x=x.ravel(), w=(half * _WEIGHTS).ravel())


Formula = str | float | Fraction

_FIELDS = ("area", "youngs_modulus", "density")
_LOOKS = 1001


@described(frozen=True, kw_only=True, eq=False)
class NonuniformRod:
    r"""A rod with ``A(x), E(x), rho(x) > 0``, a dashpot at ``x = 0`` and a compliant obstacle beyond ``x = L``.

    .. math::

        \rho A u_{tt} &= (A E u_x)_x + f, & \qquad A E u_x(t,0) &= k u_t(t,0) - g(t), \\
        E u_x(t,L) &= -p(u(t,L) - \mathrm{gap}), & \qquad p(r) &= c_n \max(r,0)^m .

    The force ``g`` pushes along ``x`` [N], ``f`` too [N/m]; ``p >= 0`` is a stress, so the obstacle pushes back with
    ``A(L) p``.  Loads and initial data are a :class:`lure.rod.scenario.Scenario`.

    Raises
    ------
    InputError
        A number is not finite or ``length`` not positive; a coefficient is not positive at one of 1001 points spread
        evenly over the rod (what it does between them is not seen).
    AssumptionError
        The nonlinearity is not locally Lipschitz (``m < 1``), which Lemma 3.1 of the paper assumes.
    """

    length: float = quantity("``L > 0``", "m")
    area: Expression = quantity("``A`` [m^2], an expression of ``x``")
    youngs_modulus: Expression = quantity("``E`` [Pa], an expression of ``x``")
    density: Expression = quantity("``rho`` [kg/m^3], an expression of ``x``")
    damping: float = quantity("``k`` [N s/m], of any sign")
    nonlinearity: NormalCompliance = quantity("``p``, with ``c_n = 1/eps`` [Pa/m^m]")
    gap: float = quantity("Free distance to the obstacle [m]; negative means pre-loaded", default=0.0)

    def __post_init__(self) -> None:
        for name in ("length", "damping", "gap"):
            if not math.isfinite(getattr(self, name)):
                raise InputError(f"rod.{name} is {getattr(self, name):g}; give a finite number")
        if not self.length > 0:
            raise InputError(f"rod.length is {self.length:g}; give a positive number")
        if not self.nonlinearity.locally_lipschitz:
            raise AssumptionError(
                "the Galerkin motion is unique for a Lipschitz nonlinearity (Lemma 3.1), and p = c_n max(r, 0)^m is "
                f"not one for m = {self.nonlinearity.exponent:g}; take m >= 1"
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
            ``eps > 0`` [m^m/Pa] and ``m >= 1`` of the nonlinearity.

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
        nonlinearity = NormalCompliance(1.0 / compliance, exponent)
        return cls(length=float(length), damping=float(damping), gap=float(gap), nonlinearity=nonlinearity, **formulas)

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
        return cls(length=rod.length, damping=rod.damping, gap=rod.gap, nonlinearity=rod.nonlinearity, **formulas)

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
