r"""Eigenvalues 0 of the loop at the lower bounds (in discrete time 1), checked again: projected out, and equilibria.

Let ``A~ N = 0``, ``K A~ = 0``, ``K N = 1`` and ``Pi = N K``.  Then ``H~ = R/s + H_1`` with ``R = C~ Pi B~`` and ``H_1``
from ``(A~ - c Pi, (1 - Pi) B~, C~, D~)``, whose eigenvalues are those of ``A~`` with ``-c`` for 0.  With ``Lambda R``
symmetric ``He Lambda R/(i omega) = 0``, so that the inequality is one about ``H_1``, and ``i omega Theta H`` has
``Theta R`` beside ``i omega Theta H_1``.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from flint import arb_mat, fmpq, fmpq_mat, fmpz

from lure.analysis.certificates.second.channels import Asked, acyclic, diagonal
from lure.analysis.certificates.second.frequencies import Matrices, require_vertices
from lure.analysis.certificates.second.numerics import to_fmpq
from lure.analysis.certificates.second.reading import listed, numbers, require

MOST_VERTICES = 10


def shifted_by(asked: Asked, bounds: Sequence[tuple[Fraction, Fraction]]) -> Matrices:
    """``A~, B~, C~, D~``: the loop shifted by the lower bounds.

    ``asked``: the plant; ``bounds``: of each channel.
    """
    m = asked.D.nrows()
    lower, one = diagonal([low for low, _ in bounds]), diagonal([Fraction(1)] * m)
    whole = one + asked.D * lower
    require(bool(whole.det() != 0), "the loop is not well posed at the lower bounds")
    inverse = whole.inv()
    C, D = inverse * asked.C, inverse * asked.D
    return asked.A - asked.B * lower * C, asked.B * (one - lower * D), C, D


def integrators_apart(shifted: Matrices, weights: fmpq_mat) -> tuple[Matrices, fmpq_mat]:
    """``(A~ - c Pi, (1 - Pi) B~, C~, D~)`` and ``R``; ``Lambda R`` symmetric with a positive eigenvalue for each 0.

    ``shifted``: ``A~, B~, C~, D~``, in continuous time, ``A~`` singular; ``weights``: ``Lambda``, or what a multiplier
    is at 0.

    Raises
    ------
    NotShown
        0 is not semisimple, or ``Lambda R`` is another matrix.
    """
    A, B, C, D = shifted
    right, left = null_space(A), null_space(A.transpose()).transpose()
    overlap = left * right
    require(bool(overlap.det() != 0), "the eigenvalue 0 has too few eigenvectors")
    through = right * overlap.inv() * left
    R = C * through * B
    S = weights * R
    require(bool(S.transpose() == S), "Lambda R is not symmetric")
    p, m, zeros = S.charpoly(), S.nrows(), right.ncols()
    signs = [p[m - k] * (-1) ** k for k in range(m + 1)]  # all roots are real
    require(zeros <= m and all(v > 0 for v in signs[: zeros + 1]), "Lambda R has too few positive eigenvalues")
    require(all(v == 0 for v in signs[zeros + 1 :]), "Lambda R has too many eigenvalues")
    far = sum((abs(v) for v in A.entries()), fmpq(1))
    return (A - far * through, B - through * B, C, D), R


def null_space(M: fmpq_mat) -> fmpq_mat:
    """A basis of the null space, one column each."""
    reduced, rank = M.rref()
    n, pivots = M.ncols(), leading(reduced, rank)
    free = [j for j in range(n) if j not in pivots]
    basis = fmpq_mat(n, len(free))
    for k, j in enumerate(free):
        basis[j, k] = fmpq(1)
        for i, pivot in enumerate(pivots):
            basis[pivot, k] = -reduced[i, j]
    return basis


def leading(reduced: fmpq_mat, rank: int) -> list[int]:
    """The columns of the leading ones of a matrix in echelon form; ``rank``: its number of rows that are not 0."""
    return [next(j for j in range(reduced.ncols()) if reduced[i, j] != 0) for i in range(rank)]


def require_rests(
    asked: Asked, shifted: Matrices, bounds: Sequence[tuple[Fraction, Fraction]], zero: object
) -> tuple[fmpq_mat, fmpq_mat]:
    """The states of the equilibria of a certificate, one column each, and their ``sigma``, which tells them apart.

    Parameters
    ----------
    asked : Asked
        The plant and the classes.
    shifted : tuple of fmpq_mat
        ``A~, B~, C~, D~``.
    bounds : sequence of pairs of Fraction
        By whose lower ones the loop is shifted.
    zero : object
        The equilibria ``(x, phi)``, as they stand in the certificate.

    Raises
    ------
    NotShown
        One is none, or ``sigma`` is the same for some.
    """
    A, _, C, _ = shifted
    n, m = A.nrows(), asked.D.nrows()
    points = [numbers(v) for v in listed(zero)]
    require(0 < len(points) <= m and all(len(v) == n + m for v in points), "the equilibria do not fit")
    states, phi = (fmpq_mat([[to_fmpq(v[i]) for v in points] for i in part]) for part in (range(n), range(n, n + m)))
    seen, turned = C * states, A - diagonal([Fraction(int(asked.discrete))] * n)
    still = bool(turned * states == fmpq_mat(n, len(points)))
    require(
        still and bool(phi == diagonal([low for low, _ in bounds]) * seen), "an equilibrium is none with phi = L sigma"
    )
    require(seen.rank() == len(points), "sigma does not see all equilibria")
    return states, seen


def require_equilibria(  # noqa: PLR0913  (the parts of one inequality)
    asked: Asked,
    shifted: Matrices,
    bounds: Sequence[tuple[Fraction, Fraction]],
    scaled: tuple[list[list[fmpz]], int],
    Pi: fmpq_mat,
    theta: Sequence[Fraction],
    zero: object,
) -> list[int]:
    """States that tell the equilibria of a certificate apart, after a check that the inequality is an equality there.

    At ``A~ v = 0`` (discrete: ``v``) and ``psi = 0`` the form vanishes with its derivative if ``A~'Q v = -C~'Pi_11 C~
    v`` (discrete: ``(A~ - 1)'Q v``) and ``B~'Q v = (Pi_21 - D~'Pi_11) C~ v``.

    Parameters
    ----------
    asked : Asked
        The plant and the classes.
    shifted : tuple of fmpq_mat
        ``A~, B~, C~, D~``.
    bounds : sequence of pairs of Fraction
        By whose lower ones the loop is shifted.
    scaled : tuple
        ``P`` and its exponent.
    Pi : fmpq_mat
        The multiplier.
    theta : sequence of Fraction
        Popov's terms.
    zero : object
        The equilibria, as they stand in the certificate.

    Raises
    ------
    NotShown
        It is not so, or ``sigma`` does not tell them apart.
    """
    A, B, C, D = shifted
    (rows, exponent), n, m = scaled, A.nrows(), asked.D.nrows()
    states, seen = require_rests(asked, shifted, bounds, zero)
    low, unit = diagonal([low for low, _ in bounds]), fmpq(2) ** -exponent
    P = fmpq_mat([[rows[max(i, j)][min(i, j)] * unit for j in range(n)] for i in range(n)])
    flat = (P + asked.C.transpose() * low * diagonal(theta) * asked.C) * states
    square, side = (fmpq_mat([[Pi[top + i, j] for j in range(m)] for i in range(m)]) * seen for top in (0, m))
    turned = A - diagonal([Fraction(int(asked.discrete))] * n)
    level = bool(turned.transpose() * flat == -C.transpose() * square)
    require(level, "the inequality is no equality at an equilibrium")
    require(bool(B.transpose() * flat == side - D.transpose() * square), "the inequality fails near an equilibrium")
    return leading(*states.transpose().rref())


def without(M: arb_mat, left_out: Sequence[int]) -> arb_mat:
    """A matrix without some rows and columns.

    ``M``: square; ``left_out``: which, counted from 0.
    """
    kept = [i for i in range(M.nrows()) if i not in left_out]
    return arb_mat([[M[i, j] for j in kept] for i in kept]) if left_out else M


def require_one_solution(asked: Asked, bounds: Sequence[tuple[Fraction, Fraction]]) -> None:
    """Check that ``sigma + D phi(sigma) = y`` has one solution, whatever the multiplier says about differences.

    ``bounds``: of each channel.

    Raises
    ------
    NotShown
        It is not shown.
    """
    if acyclic(asked):
        return
    own = [i for i in range(len(bounds)) if i not in asked.performance]
    for i in own:
        require(asked.nonlinearities[i].slopes_within(*bounds[i]), "D has a cycle, and a slope is outside the bounds")
    require(len(own) <= MOST_VERTICES, "D has a cycle, and there are too many channels")
    direct = fmpq_mat([[asked.D[i, j] for j in own] for i in own])
    low, one = diagonal([bounds[i][0] for i in own]), diagonal([Fraction(1)] * len(own))
    whole = one + direct * low
    require(bool(whole.det() != 0), "the loop is not well posed at the lower bounds")
    require_vertices(whole.inv() * direct, [bounds[i][1] - bounds[i][0] for i in own])
