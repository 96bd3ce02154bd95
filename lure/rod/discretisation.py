"""The upwind method of lines of the rod: the block, its transfer function and its spectrum in closed form."""

from __future__ import annotations

import math
import reprlib
from functools import cached_property
from numbers import Integral
from typing import TYPE_CHECKING, ClassVar, Literal

from lure.arrays import ArrayLike, NDArray, np
from lure.errors import InputError
from lure.plants.block import LinearBlock, StructuredPlant
from lure.plants.multivariable import counted
from lure.record import Record, derived, quantity
from lure.rod.parameters import Rod
from lure.rod.transfer import RodPlant, certificate_parameters, ring_transfer

if TYPE_CHECKING:
    import control
    from scipy.sparse import csr_array

Ordering = Literal["eq39", "eq42", "eq48"]
ORDERINGS: tuple[Ordering, ...] = ("eq39", "eq42", "eq48")


def ordering_permutation(cells: int, ordering: Ordering) -> NDArray[np.intp]:
    """Positions in the ordering (39) of the states listed in ``ordering``: ``y_ordering = y_39[permutation]``.

    ``eq39``: ``[xi1^1 .. xi1^N, xi2^{N-1} .. xi2^0, z]``.  ``eq42``: the same ring, with ``z`` kept as a network of its
    own, listed after it.  ``eq48``: ``z`` between the two waves.

    Parameters
    ----------
    cells : int
        ``N``.
    ordering : {"eq39", "eq42", "eq48"}
        Which one.

    Raises
    ------
    InputError
        The ordering is none of the three.
    """
    _check_ordering(ordering)
    ring = np.arange(2 * cells)
    contact = np.array([2 * cells])
    if ordering == "eq48":
        return np.concatenate((ring[:cells], contact, ring[cells:]))
    return np.concatenate((ring, contact))


def _check_ordering(ordering: str) -> None:
    if ordering not in ORDERINGS:
        raise InputError(f"ordering is {ordering!r}; give one of {', '.join(ORDERINGS)}")


Form = Literal["corrected", "as-printed"]
FORMS: tuple[Form, ...] = ("corrected", "as-printed")
MAX_CELLS = 10_000_000


class UpwindScheme(Record, StructuredPlant, kw_only=False):
    r"""Courant-Isaacson-Rees semi-discretisation of the rod with ``N`` cells; build it with :func:`upwind`.

    State (39), ``y = [xi1^1 .. xi1^N, xi2^{N-1} .. xi2^0, z]``, rate ``s = c N / L``:

    .. math::

        y_1' &= -s y_1 - s a y_{2N} + 2 s b g, \\
        y_i' &= s y_{i-1} - s y_i \qquad (i = 2..2N,\ i \ne N+1), \\
        y_{N+1}' &= s y_N - s y_{N+1} + 2 s d \mu, \\
        z' &= y_N + d \mu, \qquad \sigma = z, \quad \mu = -p(\sigma).

    Raises
    ------
    InputError
        As for :func:`upwind`.

    Notes
    -----
    A statement about this block is a statement about the scheme, not about the rod: upwinding adds damping that the
    rod does not have (see :func:`lure.analysis.rod.spectrum.rod_spectrum`).
    """

    rod: Rod = quantity("The rod", label="")
    cells: int = quantity("``N``, number of cells")
    form: Form = quantity(
        '``"as-printed"`` drops the factor ``s`` from the force, ``b2 = [2b, 0, ..]`` as in (36) and (38): with it the '
        "paper's figures 8-10 appear, and a force ``g`` acts as ``g L/(c N)`` would.  ``A``, ``b1`` and ``c`` are the "
        "same in both forms; the sign of the printed ``b1`` is not reproduced, since with it contact would pull",
        default="corrected",
    )
    ordering: Ordering = quantity("Order of the states in the matrices", label="", default="eq39")
    response_units: ClassVar[tuple[str, str]] = ("m/Pa", "m/(Pa s)")  # of H and of omega H
    gain_letter: ClassVar[str] = "κ"  # of the sector's upper end: k is the dashpot
    _kind = "upwind scheme"
    _title = "The upwind scheme of the rod"
    _notes = ("A scheme, not the rod: upwinding adds damping that the rod does not have. In a loop mu = -p(sigma).",)

    def __post_init__(self) -> None:
        object.__setattr__(self, "cells", checked_cells(self.cells))
        if self.form not in FORMS:
            raise InputError(f"discretisation.form is {self.form!r}; give one of {', '.join(FORMS)}")
        _check_ordering(self.ordering)

    @property
    @derived("1/s", label="c N/L", form=lambda rate: f"{rate:.6g} 1/s")
    def rate(self) -> float:
        """``s = c N / L`` [1/s]."""
        return self.rod.wave_speed * self.cells / self.rod.length

    @property
    def name(self) -> str:
        """``the scheme with N cells``."""
        return f"the scheme with {counted(self.cells, 'cell')}"

    @property
    @derived(label="states")
    def order(self) -> int:
        """Number of states, ``2N + 1``."""
        return 2 * self.cells + 1

    def certificate_system(self) -> dict[str, str | int]:
        """The kind ``rod-scheme``, the parameters of the rod and the number of cells.

        The force does not enter the loop, so both forms of the scheme and all orderings of its states are one system.
        """
        return {"kind": "rod-scheme", **certificate_parameters(self.rod), "cells": self.cells}

    @property
    def force_gain(self) -> float:
        """Wave sent out by a unit force, ``2 b``, or ``2 b/s`` as printed [m/(N s)]."""
        return 2.0 * self.rod.input_gain / (1.0 if self.form == "corrected" else self.rate)

    @property
    def permutation(self) -> NDArray[np.intp]:
        """``y_ordering = y_39[permutation]``."""
        return ordering_permutation(self.cells, self.ordering)

    @cached_property
    def block(self) -> LinearBlock:
        """The block ``(A, b1, b2, c)``, sparse, assembled from the cloning templates."""
        from scipy.sparse import block_array, coo_array

        from lure.rod.cellular.gallery import rod_template
        from lure.rod.cellular.network import interconnection

        N, s, rod = self.cells, self.rate, self.rod
        ring = interconnection(rod_template(s, rod.reflection), (2 * N,), "periodic")[:, : 2 * N]
        pick = coo_array(([1.0], ([0], [N - 1])), shape=(1, 2 * N))
        A = block_array([[ring, None], [pick, coo_array((1, 1))]], format="csr")
        b1, b2, c = np.zeros(2 * N + 1), np.zeros(2 * N + 1), np.zeros(2 * N + 1)
        b1[N], b1[-1], c[-1] = 2.0 * s * rod.mobility, rod.mobility, 1.0
        b2[0] = 2.0 * rod.input_gain * (s if self.form == "corrected" else 1.0)
        order = self.permutation
        return LinearBlock(A[order][:, order].tocsr(), b1[order], b2[order], c[order])

    @property
    def A(self) -> csr_array:
        """(2N+1, 2N+1), sparse [1/s]."""
        return self.block.A

    @property
    def b1(self) -> NDArray[np.float64]:
        """(2N+1,) input of ``mu = -p`` [m/(Pa s^2) for the waves, m/(Pa s) for z]."""
        return self.block.b1

    @property
    def b2(self) -> NDArray[np.float64]:
        """(2N+1,) input of the force ``g`` [m/(N s^2)]."""
        return self.block.b2

    @property
    def c(self) -> NDArray[np.float64]:
        """(2N+1,) output ``sigma = z`` [-]."""
        return self.block.c

    def transfer(self, s: ArrayLike) -> NDArray[np.complex128]:
        r"""``H_N(s) = (d/s)(1 - a q^{2N})/(1 + a q^{2N})``, ``q = 1/(1 + s/rate)`` [m/Pa], elementwise.

        Closed form, cost independent of ``N``; not finite at a pole.
        """
        points, N = np.asarray(s, dtype=complex), self.cells
        x, y = points.real / self.rate, points.imag / self.rate
        with np.errstate(divide="ignore", over="ignore"):  # q is infinite at s = -rate
            log_ring = -N * np.log1p(x * (2.0 + x) + y * y) - 2j * N * np.arctan2(y, 1.0 + x)
        return ring_transfer(self.rod, points, np.asarray(log_ring))

    def eigenvalues(self) -> NDArray[np.complex128]:
        r"""The ``2N`` wave eigenvalues ``s((-a)^{1/2N} e^{i pi m/N} - 1)`` [1/s]; the other eigenvalue is 0.

        In order of frequency, conjugates included, all equal to ``-s`` for ``k = Z`` (one Jordan block).  From the
        closed form: numerical eigenvalues of ``A`` are meaningless near ``k = Z``.
        """
        N = self.cells
        if self.rod.reflection == 0.0:
            return np.full(2 * N, -self.rate, dtype=complex)
        return self.wave_eigenvalues(np.arange(-N, N) + (0.5 if self.rod.reflection > 0 else 1.0))

    def wave_eigenvalues(self, turns: ArrayLike) -> NDArray[np.complex128]:
        r"""``s(|a|^{1/2N} e^{i pi turns/N} - 1)`` [1/s], elementwise, without cancellation near 0; ``k != Z``.

        Parameters
        ----------
        turns : array_like
            ``m`` for ``a < 0`` and ``m + 1/2`` for ``a > 0``, between ``-N`` and ``N``.
        """
        fraction = np.asarray(turns, dtype=float) / self.cells
        growth = RodPlant(self.rod).log_reflection / (2 * self.cells)
        # sin(pi x) = sin(pi (1 - x)): exactly zero at x = 1, where the eigenvalue is real
        sine = np.copysign(np.sin(math.pi * np.minimum(abs(fraction), 1.0 - abs(fraction))), fraction)
        real = math.expm1(growth) * np.cos(math.pi * fraction) - 2.0 * np.sin(math.pi * fraction / 2.0) ** 2
        return np.asarray(self.rate * (real + 1j * math.exp(growth) * sine))

    def to_control(self) -> control.StateSpace:
        """The block from ``mu`` to ``sigma`` as a ``control.StateSpace`` (dense)."""
        return self.block.to_control()

    def frequency_response(self, omega: ArrayLike) -> control.FrequencyResponseData:
        """``H_N(i omega)`` at ``omega`` [rad/s], computed by python-control from the matrices."""
        return self.block.frequency_response(omega)


def checked_cells(cells: object, field: str = "discretisation.cells") -> int:
    """A number of cells as ``int``, after the one check there is of it.

    Raises
    ------
    InputError
        It is not a whole number from 1 to 10 000 000; the message names ``field`` and, for more, the memory needed.

    Examples
    --------
    >>> checked_cells(10)
    10
    """
    if isinstance(cells, bool) or not isinstance(cells, Integral):
        raise InputError(f"{field} is {reprlib.repr(cells)}; give a whole number")
    number = int(cells)
    if number.bit_length() > 60:
        raise InputError(f"{field} has more than 18 digits; give a whole number from 1 to {MAX_CELLS}")
    if not 1 <= number <= MAX_CELLS:
        size = f" (it would need about {number / 1e7:.3g} GB for its matrices)" if number > MAX_CELLS else ""
        raise InputError(f"{field} is {number}{size}; give a whole number from 1 to {MAX_CELLS}")
    return number


def upwind(rod: Rod, cells: int, *, form: Form = "corrected", ordering: Ordering = "eq39") -> UpwindScheme:
    """The ``N``-cell upwind scheme of ``rod``.

    Parameters
    ----------
    rod : Rod
        The rod.
    cells : int
        ``1 <= N <= 10 000 000``.
    form : {"corrected", "as-printed"}
        See :class:`UpwindScheme`.
    ordering : {"eq39", "eq42", "eq48"}
        See :func:`lure.rod.discretisation.ordering_permutation`.

    Raises
    ------
    InputError
        ``cells`` is not an integer in that range, or ``form`` or ``ordering`` is unknown.

    Examples
    --------
    >>> from lure.rod import Rod
    >>> rod = Rod(youngs_modulus=288e6, density=8, length=1, area=0.25e-4, damping=2e-4, compliance=1)
    >>> upwind(rod, 10).A.shape
    (21, 21)
    """
    return UpwindScheme(rod, cells, form, ordering)
