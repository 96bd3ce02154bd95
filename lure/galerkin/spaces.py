"""The spaces V_m of the Galerkin method: P1 and P2 finite elements and cosines, and quadrature along the rod."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import InputError

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Array = NDArray[np.float64]
SpaceName = Literal["P1", "P2", "cosine"]
SPACES: tuple[SpaceName, ...] = ("P1", "P2", "cosine")
MOST = {"P1": 20_000, "P2": 20_000, "cosine": 500}
_LEAST = {"P1": 2, "P2": 3, "cosine": 1}
_DEGREE = {"P1": 1, "P2": 2}
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Space:
    r"""``V_m = span{w_1, ..., w_m}`` in ``H^1(0, L)``.

    ``"P1"``: continuous, linear on each of ``m - 1`` equal elements.  ``"P2"``: quadratic on each of ``(m - 1)/2``
    (so ``m`` is odd).  In both the coefficients are the values at ``m`` evenly spaced nodes, from ``x = 0`` to
    ``x = L``.  ``"cosine"``: ``w_j = cos((j - 1) pi x/L)``, the modes of the free-free uniform rod; each has slope
    zero at both ends, and the limit of their sums need not.

    Attributes
    ----------
    name : {"P1", "P2", "cosine"}
        The kind.
    order : int
        ``m``, its dimension.
    length : float
        ``L`` [m].

    Raises
    ------
    InputError
        The kind is unknown, or ``order`` is not a whole number that fits it.
    """

    name: SpaceName
    order: int
    length: float

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


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Quadrature:
    """Gauss quadrature on ``(0, L)``, 8 points a panel: exact for polynomials of degree 15 on each.

    Attributes
    ----------
    x, w : ndarray
        (q,) nodes and weights [m].
    """

    x: Array
    w: Array


def quadrature(space: Space, breaks: tuple[float, ...] = ()) -> Quadrature:
    """Quadrature on the elements of a space, cut where formulas change.

    Parameters
    ----------
    space : Space
        The space.
    breaks : tuple of float
        Further places where panels end [m].
    """
    edges = np.union1d(space.edges, np.asarray(breaks, dtype=float))
    half = 0.5 * np.diff(edges)[:, None]
    x = 0.5 * (edges[1:] + edges[:-1])[:, None] + half * _NODES
    return Quadrature(x=x.ravel(), w=(half * _WEIGHTS).ravel())
