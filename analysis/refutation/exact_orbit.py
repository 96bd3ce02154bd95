"""From a periodic orbit in floating point to one in rationals, checked exactly."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from flint import fmpq, fmpq_mat
from numpy.typing import NDArray

from analysis.polynomial import to_fmpq, to_fraction
from analysis.refutation.interpolation import PiecewiseLinear
from analysis.refutation.matrix_game import solve_games
from analysis.refutation.orbit import orbit_witness, shifted_block, steady_state_map
from analysis.refutation.patterns import Family, basis
from analysis.witness import Witness
from lure.errors import InputError
from lure.rational import RationalBlock

Floats = NDArray[np.float64]

_LARGEST_EXACT = 12  # rows of a matrix whose characteristic polynomial is factored


@dataclass(frozen=True, slots=True)
class Proposal:
    """An orbit in floating point: ``w = V d`` with ``V`` the basis of the pattern of ``values``.

    Attributes
    ----------
    reach : float
        ``1/k`` of the loop shifted to the lower bound zero.
    q, twist : int
        ``w[t + q] = twist * w[t]``.
    family : {"monotone", "odd", "sector"}
        Which pattern of ``values`` is kept.
    values, mixture : ndarray
        (q,), (q,).
    """

    reach: float
    q: int
    twist: int
    family: Family
    values: Floats
    mixture: Floats


def exact_orbit(block: RationalBlock, lower: Fraction, proposal: Proposal, *, odd: bool = False) -> Witness | None:
    """The witness of a proposal: at its own ``k`` if that is rational, else at the next ``k`` above that can be proved.

    Parameters
    ----------
    block : RationalBlock
        The block before the shift.
    lower : Fraction
        The lower bound.
    proposal : Proposal
        Found for the shifted block ``n / (d + lower n)``.
    odd : bool
        Whether the law of a ``sector`` pattern has to be odd.

    Returns
    -------
    Witness or None
        None if no rational orbit nearby passes the exact check.
    """
    response = steady_state_map(shifted_block(block, lower), proposal.q, twist=proposal.twist)
    if response is None:
        return None
    V = fmpq_mat([[int(v) for v in row] for row in basis(proposal.values[None], proposal.family)[0]])
    A = V.solve(response * V) * fmpq(-1)
    for d in _candidates(A, proposal):
        w = V * d
        witness = _witness(block, lower, proposal, (w, response * w * fmpq(-1)), odd=odd)
        if witness is not None:
            return witness
    return None


def _witness(
    block: RationalBlock, lower: Fraction, proposal: Proposal, orbit: tuple[fmpq_mat, fmpq_mat], *, odd: bool
) -> Witness | None:
    w, sigma = ([to_fraction(side[i, 0]) for i in range(proposal.q)] for side in orbit)
    if proposal.twist == -1:
        w, sigma = ([*side, *(-value for value in side)] for side in (w, sigma))
    full = [value + lower * s for value, s in zip(w, sigma, strict=True)]
    try:
        law = PiecewiseLinear.through(zip(sigma, full, strict=True), lower, odd=odd or proposal.family == "odd")
        u = [-value for value in full]
        return orbit_witness(block, law, u, sigma, slope_restricted=proposal.family != "sector")
    except InputError:
        return None


def _candidates(A: fmpq_mat, proposal: Proposal) -> list[fmpq_mat]:
    """Steps ``d`` with ``A d >= reach d`` exactly: an eigenvector of the steps in use, then interior points."""
    found = []
    vertex = _vertex(A, proposal)
    if vertex is not None:
        found.append(vertex)
    size = proposal.q
    numbers = np.array([[float(to_fraction(A[i, j])) for j in range(size)] for i in range(size)])
    for give in (1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5):
        reach = Fraction(proposal.reach * (1 - give))
        solved = solve_games((numbers - float(reach) * np.eye(size))[None])
        if not solved.value[0] > 0:
            continue
        for bits in range(10, 64, 6):
            d = fmpq_mat([[fmpq(round(value * 2**bits), 2**bits)] for value in solved.mixture[0]])
            slack = A * d - d * to_fmpq(reach)
            if any(d[i, 0] > 0 for i in range(size)) and all(slack[i, 0] >= 0 for i in range(size)):
                found.append(d)
                break
    return found


def _vertex(A: fmpq_mat, proposal: Proposal) -> fmpq_mat | None:
    """The exact solution of ``(A d)_i = reach d_i`` on the rows in use, if its eigenvalue is rational."""
    size = proposal.q
    used = [i for i in range(size) if proposal.mixture[i] > 1e-9]
    if len(used) > _LARGEST_EXACT:
        return None
    block = fmpq_mat([[A[i, j] for j in used] for i in used])
    _, factors = block.charpoly().numer().factor()
    roots = [Fraction(-int(f[0]), int(f[1])) for f, _ in factors if f.degree() == 1]
    near = [root for root in roots if abs(float(root) / proposal.reach - 1) < 1e-7]
    if not near:
        return None
    vector = _null_vector(block, to_fmpq(near[0]))
    if vector is None:
        return None
    d = fmpq_mat(size, 1)
    for i, value in zip(used, vector, strict=True):
        d[i, 0] = value
    image = A * d
    fits = all(value > 0 for value in vector) and all(image[i, 0] >= 0 for i in range(size) if i not in used)
    return d if fits else None


def _null_vector(matrix: fmpq_mat, eigenvalue: fmpq) -> list[fmpq] | None:
    """The eigenvector of last entry 1, if the eigenvalue is simple and that entry is not zero."""
    n = matrix.nrows()
    reduced, rank = fmpq_mat(
        [[matrix[i, j] - (eigenvalue if i == j else 0) for j in range(n)] for i in range(n)]
    ).rref()
    if rank != n - 1 or any(reduced[i, i] != 1 for i in range(n - 1)):
        return None
    return [-reduced[i, n - 1] for i in range(n - 1)] + [fmpq(1)]
