"""The upwind method of lines: (35) put into (34), and the matrices of (38) and (42)."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from lure.derivation.vocabulary import Form, a, b, checked_cells, checked_form, d, g, p, s

mu, z = sp.symbols("mu z", real=True)


@dataclass(frozen=True, kw_only=True, slots=True)
class Scheme:
    """``y' = A y + b1 mu + b2 g``, ``sigma = c^T y``, ``mu = -p(sigma)``, in the ordering (39).

    Attributes
    ----------
    A : sympy.ImmutableMatrix
        (2N+1, 2N+1) [1/s].
    b1, b2, c : sympy.ImmutableMatrix
        (2N+1, 1) columns.
    state : tuple of sympy.Symbol
        ``xi1^1 .. xi1^N, xi2^{N-1} .. xi2^0, z``.
    """

    A: sp.ImmutableMatrix
    b1: sp.ImmutableMatrix
    b2: sp.ImmutableMatrix
    c: sp.ImmutableMatrix
    state: tuple[sp.Symbol, ...]

    @property
    def cells(self) -> int:
        """Number of cells, ``N``."""
        return (len(self.state) - 1) // 2

    def rates(self, law: sp.Expr = -p) -> sp.ImmutableMatrix:
        """``y'`` with ``mu = law``, a (2N+1, 1) column."""
        return sp.ImmutableMatrix(self.A * sp.Matrix(self.state) + self.b1 * law + self.b2 * g)


def upwind_matrices(cells: int, *, form: Form = "corrected") -> Scheme:
    r"""Substitute the boundary relations (35) in the upwind equations (34) and read off the matrices.

    (34): ``xi1^i' = s (xi1^{i-1} - xi1^i)`` for ``i = 1..N``, ``xi2^i' = s (xi2^{i+1} - xi2^i)`` for ``i = 0..N-1``.
    (35): ``xi1^0 = -a xi2^0 + 2 b g``, ``xi2^N = xi1^N - 2 d p``, ``z' = (xi1^N + xi2^N)/2``.

    Parameters
    ----------
    cells : int
        ``N``, from 1 to 12.
    form : {"corrected", "as-printed"}
        ``"as-printed"`` takes the force in the first row of (36) as printed, ``2 b g`` instead of ``2 s b g``.

    Raises
    ------
    InputError
        ``cells`` is not an integer from 1 to 12, or ``form`` is unknown.

    Examples
    --------
    >>> print(upwind_matrices(1).A)
    Matrix([[-s, -a*s, 0], [s, -s, 0], [1, 0, 0]])
    """
    last = checked_cells(cells)
    xi1 = sp.symbols(f"xi1^0:{last + 1}", real=True)
    xi2 = sp.symbols(f"xi2^0:{last + 1}", real=True)
    ends = {xi1[0]: -a * xi2[0] + 2 * b * g, xi2[last]: xi1[last] + 2 * d * mu}
    forward = [(xi1[i], s * (xi1[i - 1] - xi1[i])) for i in range(1, last + 1)]
    backward = [(xi2[i], s * (xi2[i + 1] - xi2[i])) for i in reversed(range(last))]
    rows = [*forward, *backward, (z, (xi1[last] + xi2[last]) / 2)]
    state = tuple(component for component, _ in rows)
    right = sp.Matrix([sp.expand(rate.subs(ends)) for _, rate in rows])
    force = right.diff(g) / (s if checked_form(form) == "as-printed" else 1)
    return Scheme(
        A=sp.ImmutableMatrix(right.jacobian(state)),
        b1=sp.ImmutableMatrix(right.diff(mu)),
        b2=sp.ImmutableMatrix(force),
        c=sp.ImmutableMatrix([component.diff(z) for component in state]),
        state=state,
    )


def stated_matrices(cells: int) -> Scheme:
    """The matrices written down row by row, not derived: ``y1' = -s y1 - s a y_{2N} + 2 s b g`` and so on.

    Row ``i`` is ``s y_{i-1} - s y_i``, row ``N+1`` has ``2 s d mu`` besides, and ``z' = y_N + d mu``.

    Parameters
    ----------
    cells : int
        ``N``, from 1 to 12.
    """
    last = 2 * checked_cells(cells)
    A, b1, b2, output = (sp.zeros(last + 1, width) for width in (last + 1, 1, 1, 1))
    for i in range(last):
        A[i, i], A[i, (i - 1) % last] = -s, s if i else -s * a
    A[last, cells - 1], b1[cells], b1[last], b2[0], output[last] = 1, 2 * s * d, d, 2 * s * b, 1
    columns = {"A": A, "b1": b1, "b2": b2, "c": output}
    return Scheme(
        **{name: sp.ImmutableMatrix(value) for name, value in columns.items()}, state=upwind_matrices(cells).state
    )


def as_scheme(system: int | Scheme) -> Scheme:
    """Return the scheme itself, or the corrected scheme with that many cells."""
    if isinstance(system, Scheme):
        return system
    return upwind_matrices(system)


def ring(cells: int) -> tuple[sp.ImmutableMatrix, sp.ImmutableMatrix]:
    """The CNN matrix of (42), (2N, 2N), and the cyclic shift whose top right corner is ``f`` instead of 1.

    A matrix is f-circulant exactly when it is a polynomial in that shift ``K_f``; it is circulant when ``f = 1``.

    Parameters
    ----------
    cells : int
        ``N``, from 1 to 12.
    """
    order = 2 * checked_cells(cells)
    shift = sp.zeros(order)
    for i in range(1, order):
        shift[i, i - 1] = 1
    shift[0, order - 1] += sp.Symbol("f", real=True)
    return sp.ImmutableMatrix(upwind_matrices(cells).A[:order, :order]), sp.ImmutableMatrix(shift)


def printed_input(cells: int) -> sp.ImmutableMatrix:
    """``b1`` as printed under (38), ``[..., -2 s d, ..., -d]``: with ``mu = -p`` it makes contact pull.

    Parameters
    ----------
    cells : int
        ``N``, from 1 to 12.
    """
    return sp.ImmutableMatrix(-upwind_matrices(cells).b1)
