"""What the matrices give: H_N, the characteristic polynomial, the zero eigenvalue, and the limit of many cells."""

from __future__ import annotations

import sympy as sp
from sympy.polys.matrices import DomainMatrix

from lure.derivation.scheme import Scheme, as_scheme
from lure.derivation.vocabulary import T, a, checked_cells, d, laplace, s


def transfer_function(system: int | Scheme) -> sp.Expr:
    """``H_N(s') = c^T (s' I - A)^-1 b1``, from ``mu`` to ``sigma`` [m/Pa], by exact elimination over Q(a, d, s, s').

    Parameters
    ----------
    system : int or Scheme
        Number of cells, or matrices to take instead of the derived ones.

    Raises
    ------
    InputError
        The number of cells is not an integer from 1 to 12.

    Examples
    --------
    >>> sp.cancel(transfer_function(1) - stated_transfer_function(1))
    0
    """
    scheme = as_scheme(system)
    size = len(scheme.state)
    extended = (laplace * sp.eye(size) - scheme.A).row_join(scheme.b1)
    field = DomainMatrix.from_Matrix(sp.Matrix(extended)).to_field()
    solution = field.extract(range(size), range(size)).lu_solve(field.extract(range(size), [size])).to_Matrix()
    return sp.cancel((scheme.c.T * solution)[0])


def stated_transfer_function(cells: int) -> sp.Expr:
    """``(d/s') (1 - a q^{2N})/(1 + a q^{2N})`` with ``q = 1/(1 + s'/s)``: claimed for every ``N`` [m/Pa].

    Parameters
    ----------
    cells : int
        ``N``, from 1 to 12.
    """
    delayed = a / (1 + laplace / s) ** (2 * checked_cells(cells))
    return d / laplace * (1 - delayed) / (1 + delayed)


def characteristic_polynomial(system: int | Scheme) -> sp.Expr:
    """``det(s' I - A)``, computed from the matrix; ``s' ((s' + s)^{2N} + a s^{2N})`` is what it should be.

    Parameters
    ----------
    system : int or Scheme
        Number of cells, or matrices to take instead of the derived ones.

    Examples
    --------
    >>> print(characteristic_polynomial(1).coeff(laplace, 2))
    2*s
    """
    scheme = as_scheme(system)
    return sp.expand((laplace * sp.eye(len(scheme.state)) - scheme.A).det(method="berkowitz"))


def stated_characteristic_polynomial(cells: int) -> sp.Expr:
    """``s' ((s' + s)^{2N} + a s^{2N})``, not derived.

    Parameters
    ----------
    cells : int
        ``N``, from 1 to 12.
    """
    power = 2 * checked_cells(cells)
    return laplace * ((laplace + s) ** power + a * s**power)


def residue_at_zero(system: int | Scheme) -> sp.Expr:
    """``rho_0``, the residue of ``H_N`` at zero, ``d (1 - a)/(1 + a)`` [m/(s Pa)] for every ``N``.

    Parameters
    ----------
    system : int or Scheme
        Number of cells, or matrices to take instead of the derived ones.
    """
    return sp.factor(sp.cancel(laplace * transfer_function(system)).subs(laplace, 0))


def value_at_zero(system: int | Scheme) -> sp.Expr:
    """``H_h(0)``, the limit of ``H_N - rho_0/s'`` at zero, ``4 a d T/(1 + a)^2`` with ``s = N/T`` [m/Pa].

    Parameters
    ----------
    system : int or Scheme
        Number of cells, or matrices to take instead of the derived ones.
    """
    scheme = as_scheme(system)
    regular = sp.cancel(transfer_function(scheme) - residue_at_zero(scheme) / laplace)
    return sp.factor(regular.subs(laplace, 0).subs(s, scheme.cells / T))


def delay_limit() -> sp.Expr:
    """Limit of ``q^{2N}`` as ``N`` grows, ``s'`` fixed and ``s = N/T``: ``exp(-2 s' T)``.

    Examples
    --------
    >>> print(delay_limit())
    exp(-2*T*s')
    """
    cells = sp.Symbol("N", positive=True)
    return sp.limit((1 + laplace * T / cells) ** (-2 * cells), cells, sp.oo)


def numerical_damping() -> sp.Expr:
    """Leading term of what upwinding adds to the exponent of the delay: ``ln q^{2N} + 2 s' T = (s' T)^2/N + O(1/N^2)``.

    On the imaginary axis it is ``-(omega T)^2/N``: damping, though the rod has none there.
    """
    step = sp.Symbol("1/N", positive=True)
    return sp.series(-2 * sp.log(1 + laplace * T * step) / step, step, 0, 2).removeO() + 2 * laplace * T
