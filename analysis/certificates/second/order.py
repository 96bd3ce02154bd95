r"""Forms of several samples, checked again: every cone by its own enumeration, copositivity by Keller's theorem.

Points ``(sigma_i, phi(sigma_i))`` and 0 are taken in some order.  With ``v = k sigma - phi`` and slopes in ``[0, k]``,
from each point to the next ``phi`` and ``v`` grow by nonnegative steps ``a_j``, ``b_j``; the point 0 fixes where they
start: ``phi_i = sum_{j below i} a_j - sum_{j below 0} a_j``, and ``v_i`` likewise.  For odd ``phi`` the points are
``s_i (sigma_i, phi_i)`` with signs that make ``s_i sigma_i >= 0``, and 0 comes first.  A symmetric matrix is strictly
copositive exactly if each principal submatrix for which the cofactors of the last row are all positive has a positive
determinant (E. L. Keller; K. P. Hadeler, Linear Algebra Appl. 49 (1983) 79-89).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import combinations, permutations, product

from flint import fmpq_mat

from lure.analysis.certificates.second.numerics import to_fmpq
from lure.analysis.certificates.second.reading import require, tick

LARGEST_WINDOW = 4


def require_positive_on_orders(rows: Sequence[Sequence[Fraction]], *, odd: bool) -> None:
    """Check that ``w' M w > 0`` for ``w = (phi, v) != 0`` from the samples of every nonlinearity.

    ``rows``: the lower triangle of ``M``, of ``2 p`` rows; ``odd``: whether for odd nonlinearities only.

    Raises
    ------
    NotShown
        There are too many samples, or it fails for an ordering.
    """
    size = len(rows)
    require(size % 2 == 0 and size <= 2 * LARGEST_WINDOW, "a form is about 1 to 4 samples")
    require([len(row) for row in rows] == list(range(1, size + 1)), "the form is no lower triangle")
    if not size:
        return
    M = fmpq_mat([[to_fmpq(rows[max(i, j)][min(i, j)]) for j in range(size)] for i in range(size)])
    for values in _steps(size // 2, odd=odd):
        tick()
        zero = [[0] * len(values) for _ in values]
        both = [[*a, *b] for a, b in (*zip(values, zero, strict=True), *zip(zero, values, strict=True))]
        T = fmpq_mat(both)
        require(strictly_copositive(T.transpose() * M * T), "the form is not positive for an ordering of the samples")


def _steps(samples: int, *, odd: bool) -> Iterator[list[list[int]]]:
    """For each ordering: row ``i`` holds the coefficients of ``phi_i`` in the steps from each point to the next."""
    for order in permutations(range(samples if odd else samples + 1)):
        points = (samples, *order) if odd else order  # `samples` stands for 0
        place = {point: i for i, point in enumerate(points)}
        from_start = [[int(j < place[i]) - int(j < place[samples]) for j in range(samples)] for i in range(samples)]
        for signs in product((1, -1), repeat=samples) if odd else ((1,) * samples,):
            yield [[sign * value for value in row] for sign, row in zip(signs, from_start, strict=True)]


def strictly_copositive(C: fmpq_mat) -> bool:
    """Whether ``x' C x > 0`` for every ``x >= 0`` but 0, of a symmetric matrix."""
    size = C.nrows()
    for count in range(1, size + 1):
        for face in combinations(range(size), count):
            B = fmpq_mat([[C[i, j] for j in face] for i in face])
            if B.det() <= 0 and _cofactors_positive(B):
                return False
    return True


def _cofactors_positive(B: fmpq_mat) -> bool:
    """Whether those of the last row are all positive."""
    size = B.nrows()
    for leave in range(size):
        columns = [j for j in range(size) if j != leave]
        minor = (
            fmpq_mat([[B[i, j] for j in columns] for i in range(size - 1)]).det() if size > 1 else to_fmpq(Fraction(1))
        )
        if (-1) ** (size - 1 + leave) * minor <= 0:
            return False
    return True
