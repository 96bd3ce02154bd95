"""Null space and multiplicity of the eigenvalue 0 of a matrix of exact numbers: no tolerance, no eigenvalue solver."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from lure.exact import exact_number

if TYPE_CHECKING:
    from flint import fmpq_mat, fmpz_mat, nmod_mat

_FIRST_PRIME = 2**61 - 1


def integer_multiple(entries: NDArray[Any], name: str) -> fmpz_mat:
    """The matrix times the least positive integer that clears its denominators: the same eigenvectors for 0.

    Parameters
    ----------
    entries : ndarray of object
        (m, n) ints, Fractions, or floats, which mean the doubles they are.
    name : str
        What the matrix is, for errors.

    Raises
    ------
    InputError
        An entry is not a finite number.
    """
    from flint import fmpz_mat

    values = {(i, j): exact_entry(entries[i, j], f"{name}[{i}, {j}]") for i, j in np.argwhere(entries != 0).tolist()}
    factor = math.lcm(*(value.denominator for value in values.values()))
    matrix = fmpz_mat(*entries.shape)
    for place, value in values.items():
        matrix[place] = value.numerator * (factor // value.denominator)
    return matrix


def exact_entry(value: object, name: str) -> Fraction:
    """The rational an int, a Fraction or a float is; ints and Fractions of any size.

    Raises
    ------
    InputError
        It is not a finite number.
    """
    if isinstance(value, int | Fraction) and not isinstance(value, bool):
        return Fraction(value)
    return exact_number(value, name)


def null_space(matrix: fmpz_mat) -> fmpz_mat:
    """Integer basis of ``{x: M x = 0}``, one column each; ``rank M`` is the number of columns of ``M`` less theirs.

    Parameters
    ----------
    matrix : fmpz_mat
        ``M``, (m, n).

    Returns
    -------
    fmpz_mat
        (n, n - rank).

    Notes
    -----
    The rank modulo a prime bounds the rank from below: a minor that does not vanish modulo the prime does not vanish.
    The null vectors, solved for exactly on a submatrix that is nonsingular modulo the prime and multiplied back into
    all of ``M``, bound it from above.  If one of them fails that test, the prime divides a larger minor: the next is
    taken.
    """
    from flint import fmpz_mat, nmod_mat

    n, table = matrix.ncols(), matrix.tolist()
    for prime in _primes():
        columns = _pivots(nmod_mat(matrix, prime))
        free = sorted(set(range(n)) - set(columns))
        if not free:
            break
        tall = fmpz_mat([[row[j] for row in table] for j in columns]) if columns else fmpz_mat(0, matrix.nrows())
        rows = _pivots(nmod_mat(tall, prime))
        square = fmpz_mat(len(rows), len(rows), [table[i][j] for i in rows for j in columns])
        right = fmpz_mat(len(rows), len(free), [table[i][j] for i in rows for j in free])
        numerators, denominator = cast("fmpq_mat", square.solve(right)).numer_denom()
        basis = fmpz_mat(n, len(free))
        for k, j in enumerate(free):
            basis[j, k] = denominator
            for i, column in enumerate(columns):
                basis[column, k] = -numerators[i, k]
        if (matrix * basis).is_zero():
            return basis
    return fmpz_mat(n, 0)


def zero_multiplicity(matrix: fmpz_mat, nullity: int) -> int:
    """Algebraic multiplicity of the eigenvalue 0 of a square matrix with that nullity.

    Notes
    -----
    The order of 0 as a root of the characteristic polynomial modulo a prime bounds it from above (a coefficient that
    vanishes does so modulo the prime), the nullity of a power ``M^k`` from below; that grows with ``k`` until it is the
    multiplicity and then stays.
    """
    from flint import nmod_mat

    if nullity == 0:
        return 0
    coefficients = nmod_mat(matrix, _FIRST_PRIME).charpoly().coeffs()
    bound = next(order for order, coefficient in enumerate(coefficients) if int(coefficient) != 0)
    power = matrix
    while nullity < bound:
        power = power * power
        wider = null_space(power).ncols()
        if wider == nullity:
            break
        nullity = wider
    return nullity


def _primes() -> Iterator[int]:
    from flint import fmpz

    return (candidate for candidate in range(_FIRST_PRIME, 2, -2) if fmpz(candidate).is_prime())


def _pivots(matrix: nmod_mat) -> list[int]:
    """Columns of the leading entries of the reduced row echelon form."""
    reduced, rank = matrix.rref()
    pivots: list[int] = []
    for row in range(rank):
        column = pivots[-1] + 1 if pivots else 0
        while int(reduced[row, column]) == 0:
            column += 1
        pivots.append(column)
    return pivots


def column_of(basis: fmpz_mat) -> list[Fraction]:
    """The one column of a basis as exact numbers."""
    return [Fraction(int(value)) for value in basis.entries()]


def dot(x: Sequence[Fraction], y: Sequence[Fraction]) -> Fraction:
    """``sum_i x_i y_i``."""
    return sum((p * q for p, q in zip(x, y, strict=True) if p and q), Fraction(0))
