"""The eigenvalue 0 of a finite block, and the residue of its transfer function there, decided in exact arithmetic."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, cast

from lure.analysis.numerics.evidence import Evidence
from lure.arrays import NDArray, np
from lure.errors import AssumptionError, InputError
from lure.exact import exact_number
from lure.plants.block import LinearBlock
from lure.record import described, quantity

if TYPE_CHECKING:
    from flint import fmpq_mat, fmpz_mat, nmod_mat

# Null space and multiplicity of the eigenvalue 0 of a matrix of exact numbers: no tolerance, no eigenvalue solver.

_FIRST_PRIME = 2**61 - 1


def integer_multiple(entries: NDArray[Any], name: str) -> fmpz_mat:
    """The matrix times the least positive integer that clears its denominators: the same eigenvectors for 0.

    ``entries``: (m, n) ints, Fractions, or floats, which mean the doubles they are; ``name``: what the matrix is, for
    errors.

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

    ``matrix``: ``M``, (m, n).

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


Number = int | float | Fraction
LARGEST_ORDER = 1000


@described(frozen=True, kw_only=True, slots=True)
class ZeroEigenvalue:
    r"""The eigenvalue 0 of ``x' = A x + b mu``, ``sigma = c^T x``, for the critical case of Popov's theorem."""

    order: int = quantity("Number of states ``n``")
    geometric: int = quantity("Number of independent eigenvectors, ``n - rank A``")
    algebraic: int = quantity("Multiplicity in the characteristic polynomial, ``n - rank A^n``")
    observable: bool | None = quantity(
        "For a simple zero with eigenvectors ``A r = 0``, ``l^T A = 0``: whether ``c^T r != 0``.  None if the zero "
        "is not simple"
    )
    controllable: bool | None = quantity("For a simple zero: whether ``l^T b != 0``.  None if the zero is not simple")
    residue: Fraction | None = quantity(
        "``rho_0 = (c^T r)(l^T b)/(l^T r)``, the limit of ``s H(s)`` at 0 [unit of sigma / unit of mu / s]; None if "
        "the zero is not simple"
    )

    @property
    def evidence(self) -> Evidence:
        """CERTIFIED: every number here is exact, for the entries as given."""
        return Evidence.CERTIFIED

    @property
    def critical(self) -> bool:
        """Whether the zero is simple with a positive residue, as the critical case asks.

        It asks for more: that all other eigenvalues have negative real parts is not looked at here.
        """
        return self.residue is not None and self.residue > 0

    @property
    def reason(self) -> str:
        """One sentence: why the critical case admits this zero, or why it is refused."""
        if self.algebraic == 0:
            return "A has no eigenvalue 0: this is not the critical case; use the criterion for a Hurwitz A"
        if self.algebraic > 1 and self.geometric == self.algebraic:
            return (
                f"the eigenvalue 0 is {_times(self.algebraic)}, with {self.geometric} independent eigenvectors, and "
                "the critical case needs a simple one: one input moves one combination of these modes, and the others "
                "stay where they start"
            )
        if self.algebraic > 1:
            return (
                f"the eigenvalue 0 is {_times(self.algebraic)}, with {_count(self.geometric)}, and the critical case "
                "needs a simple one: where phi is small the state drifts away like a power of time, and a nonlinearity "
                "that "
                "fades, as sigma exp(-|sigma|) does, need not bring it back although every linear gain may be stable"
            )
        if not self.observable:
            return (
                "the eigenvalue 0 is simple but unobservable (c^T r = 0): sigma does not see the mode, so the feedback "
                "drives it without ever correcting it; remove the mode or choose another output"
            )
        if not self.controllable:
            return (
                "the eigenvalue 0 is simple but uncontrollable (l^T b = 0): the feedback cannot move the mode, which "
                "stays where it starts; remove the mode or choose another input"
            )
        if not self.critical:
            return (
                f"the residue of H at 0 is {_decimal(self.residue)}, and the critical case needs a positive one: under "
                "mu = -kappa sigma with a small kappa > 0 the eigenvalue 0 moves into the right half-plane"
            )
        return f"the eigenvalue 0 is simple and the residue of H at 0 is {_decimal(self.residue)} > 0"

    def require(self) -> ZeroEigenvalue:
        """Itself if :attr:`critical`.

        Raises
        ------
        AssumptionError
            It is not; the message is :attr:`reason`.
        """
        if not self.critical:
            raise AssumptionError(self.reason)
        return self

    def __str__(self) -> str:
        return self.reason[0].upper() + self.reason[1:] + "."


def zero_eigenvalue(block: LinearBlock) -> ZeroEigenvalue:
    """The eigenvalue 0 of a block and the residue of ``H`` from ``mu`` to ``sigma`` there.

    The entries mean the doubles they are.  A zero that is double by physics is double here only if the doubles say so:
    pass exact numbers to :func:`exact_zero_eigenvalue` where they do not.

    Parameters
    ----------
    block : LinearBlock
        At most 1000 states.

    Raises
    ------
    InputError
        There are more states.

    Examples
    --------
    >>> print(zero_eigenvalue(LinearBlock([[0, 1], [0, -2]], [0, 1], [0, 0], [1, 0])))
    The eigenvalue 0 is simple and the residue of H at 0 is 0.5 > 0.
    """
    _check_order(block.order)
    return exact_zero_eigenvalue(block.dense(), block.b1, block.c)


def exact_zero_eigenvalue(
    A: Sequence[Sequence[Number]] | NDArray[Any],
    b: Sequence[Number] | NDArray[Any],
    c: Sequence[Number] | NDArray[Any],
) -> ZeroEigenvalue:
    r"""The eigenvalue 0 of ``x' = A x + b mu``, ``sigma = c^T x``, for exact entries.

    .. math:: \rho_0 = \lim_{s \to 0} s\,H(s) = \frac{(c^T r)(l^T b)}{l^T r}, \\
        A r = 0, \quad l^T A = 0, \quad H(s) = c^T (sI - A)^{-1} b .

    Parameters
    ----------
    A : array_like
        (n, n), ``1 <= n <= 1000``: ints and Fractions as they are, floats as the doubles they are [1/s].
    b, c : array_like
        (n,) input of the nonlinearity and output.

    Raises
    ------
    InputError
        The shapes do not fit, an entry is not a finite number, or ``n`` is too large.

    Notes
    -----
    No eigenvalue solver and no tolerance: see :mod:`lure.analysis.numerics.exact_matrix` for what bounds the ranks
    from both sides.
    A dense double matrix takes a fraction of a second for ``n = 100`` and seconds for ``n = 400``; entries whose
    exponents differ by hundreds take longer.

    Examples
    --------
    The double integrator with a zero, ``H = (s + 1)/s^2``:

    >>> found = exact_zero_eigenvalue([[0, 1], [0, 0]], [0, 1], [1, 1])
    >>> found.algebraic, found.geometric, found.residue
    (2, 1, None)
    """
    matrix, right, output = (np.asarray(values, dtype=object) for values in (A, b, c))
    n = right.size
    if matrix.shape != (n, n) or right.shape != (n,) or output.shape != (n,) or n == 0:
        shapes = f"A {matrix.shape}, b {right.shape}, c {output.shape}"
        raise InputError(f"zero_eigenvalue needs A (n, n), b (n,), c (n,) with n >= 1; got {shapes}")
    _check_order(n)
    b_exact = [exact_entry(value, f"b[{i}]") for i, value in enumerate(right)]
    c_exact = [exact_entry(value, f"c[{i}]") for i, value in enumerate(output)]
    integers = integer_multiple(matrix, "A")
    kernel = null_space(integers)
    geometric = kernel.ncols()
    algebraic = zero_multiplicity(integers, geometric)
    observable, controllable, residue = None, None, None
    if algebraic == 1:
        r, left = column_of(kernel), column_of(null_space(integers.transpose()))
        seen, moved = dot(c_exact, r), dot(b_exact, left)
        observable, controllable, residue = seen != 0, moved != 0, seen * moved / dot(left, r)
    return ZeroEigenvalue(
        order=n,
        geometric=geometric,
        algebraic=algebraic,
        observable=observable,
        controllable=controllable,
        residue=residue,
    )


def _check_order(n: int) -> None:
    if n > LARGEST_ORDER:
        raise InputError(
            f"zero_eigenvalue is for at most {LARGEST_ORDER} states; got {n}: exact arithmetic would take too long "
            "(the rod has a closed form, lure.analysis.rod.spectrum.rod_spectrum)"
        )


def _decimal(value: Fraction | None) -> str:
    return f"{float(value or 0):.6g}"


def _times(multiplicity: int) -> str:
    return {2: "double", 3: "triple"}.get(multiplicity, f"of multiplicity {multiplicity}")


def _count(eigenvectors: int) -> str:
    return "one eigenvector only" if eigenvectors == 1 else f"{eigenvectors} independent eigenvectors only"
