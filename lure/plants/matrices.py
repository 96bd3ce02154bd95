"""From matrices to an exact transfer function, by characteristic polynomials of integer matrices."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Literal, cast

from lure.arrays import is_array, np
from lure.errors import InputError
from lure.plants.rational import RationalPlant
from lure.plants.realisation import Realisation, Row
from lure.plants.state_space import StateSpace
from lure.plants.text import exact_coefficient

if TYPE_CHECKING:
    from flint import fmpz_mat

MAX_EXACT_STATES = 60
ONE_PAIR = "a block has one input and one output; choose a pair, e.g. sys[0, 0]"


def rational_block(
    A: object,
    B: object,
    C: object,
    D: object = None,
    *,
    dt: int | float | Fraction | None = None,
) -> RationalPlant:
    r"""The exact block of ``x' = A x + B mu``, ``sigma = C x + D mu`` (or ``x[k+1] = ...``), of any order up to 1000.

    .. math:: H(s) = D + \frac{\det(sI - A + BC) - \det(sI - A)}{\det(sI - A)}

    Modes that ``B`` does not reach or ``C`` does not see stay as factors of numerator and denominator.  The matrices
    themselves stay with the block, exactly, as :attr:`lure.plants.rational.RationalPlant.matrices`.

    Parameters
    ----------
    A : array_like
        (n, n) ints, Fractions, Decimals, texts such as ``"1/3"``, or floats, each the double it is.
    B, C : array_like
        (n,), (n, 1) or (1, n).
    D : object
        A number, perhaps inside brackets; None is 0.
    dt : int, float, Fraction, True or None
        Sampling time [s]; True where its period is not stated; None for continuous time.

    Raises
    ------
    InputError
        Shapes do not fit, an entry is not a finite real number, or there is no state and no ``D`` is given.

    Notes
    -----
    FLINT's characteristic polynomial of integer matrices: about a second for 60 states with doubles for entries; the
    cost grows with the fourth power of the order.

    Examples
    --------
    >>> print(rational_block([[-1, 1], [0, 0]], [0, 1], [-1, 2]))
    (2 s + 1) / (s^2 + s)
    """
    state, input_, output, direct = checked_matrices(A, B, C, D)
    if not state:
        if D is None or not _entries(D):
            raise InputError(
                "the system is empty: it has no states and no feedthrough; give matrices of order 1 or more"
            )
        return RationalPlant([direct], [1], dt)
    scale = math.lcm(*(v.denominator for row in state for v in row))
    outer = [[b * c for c in output] for b in input_]
    scale = math.lcm(scale, *(v.denominator for row in outer for v in row))
    changed = [[a - o for a, o in zip(*rows, strict=True)] for rows in zip(state, outer, strict=True)]
    open_, closed = (_monic(_integers(rows, scale), scale) for rows in (state, changed))
    top = [c - o + direct * o for c, o in zip(closed, open_, strict=True)]
    matrices = Realisation(tuple(state), input_, output, direct)
    return RationalPlant(top, open_, dt, matrices=matrices)


def checked_matrices(A: object, B: object, C: object, D: object) -> tuple[list[Row], Row, Row, Fraction]:
    """The entries as exact numbers, shapes checked.

    Raises
    ------
    InputError
        As for :func:`rational_block`.
    """
    state = [_row(row, f"A[{i}]") for i, row in enumerate(rows_of(A, "A"))]
    n = len(state)
    for i, row in enumerate(state):
        if len(row) != n:
            entries = f"{len(row)} {'entry' if len(row) == 1 else 'entries'}"
            raise InputError(f"A is not square: it has {n} row{'s' * (n != 1)}, and A[{i}] has {entries}")
    if n > 1 and _nested(B) and len(rows_of(B, "B")) == 1 and len(rows_of(C, "C")) == n:  # each is lenient alone
        raise InputError(f"B is 1 x {n} and C is {n} x 1, as if C stood before B; give (A, B, C, D) in this order")
    return state, _vector(B, "B", n), _vector(C, "C", n), _direct(D)


def float_block(
    A: object,
    B: object,
    C: object,
    D: object = None,
    *,
    dt: Fraction | Literal[True] | None = None,
) -> StateSpace:
    """The block of the same matrices in floating point.

    ``A``, ``B``, ``C``, ``D``: as for :func:`rational_block`; entries that are no doubles are rounded.  ``dt``:
    sampling time [s]; True where its period is not stated; None for continuous time.

    Raises
    ------
    InputError
        Shapes do not fit, or an entry is not a finite real number.
    """
    dense = A.toarray() if hasattr(A, "toarray") else A
    if is_array(dense) and dense.dtype.kind in "iuf":
        state, n = dense, dense.shape[0]
        if dense.shape != (n, n):
            raise InputError(f"A is not square: it is {' x '.join(map(str, dense.shape))}")
        input_, output, direct = _vector(B, "B", n), _vector(C, "C", n), _direct(D)
    else:
        exact, input_, output, direct = checked_matrices(dense, B, C, D)
        state = np.array(exact, dtype=float)
    step = cast("Fraction | None", dt)  # True is taken too, and kept as a Fraction
    return StateSpace(state, np.array(input_, dtype=float), np.array(output, dtype=float), float(direct), step)


def _entries(D: object) -> list[Fraction]:
    return [] if D is None else [entry for row in rows_of(D, "D") for entry in _row(row, "D")]


def _direct(D: object) -> Fraction:
    entries = _entries(D)
    if len(entries) > 1:
        raise InputError(f"D has {len(entries)} entries: {ONE_PAIR}")
    return entries[0] if entries else Fraction(0)


def _listed(values: object) -> object:
    """Arrays and sparse matrices as nested lists, everything else as it is."""
    if hasattr(values, "toarray"):
        values = values.toarray()
    return values.tolist() if hasattr(values, "tolist") else values


def _nested(values: object) -> bool:
    """Whether a matrix is written as rows, not as a plain list."""
    listed = _listed(values)
    rows = [] if isinstance(listed, str) or not isinstance(listed, Sequence) else list(map(_listed, listed))
    return any(isinstance(row, Sequence) and not isinstance(row, str) for row in rows)


def rows_of(values: object, name: str) -> list[object]:
    """Rows of a matrix; a number or a plain list counts as one row.

    ``values``: nested lists, an array or a sparse matrix; ``name``: what it is called, for errors.

    Raises
    ------
    InputError
        Numbers and lists are mixed.
    """
    listed = _listed(values)
    if not isinstance(listed, Sequence) or isinstance(listed, str):
        return [[listed]]
    rows = [_listed(row) for row in listed]
    nested = [isinstance(row, Sequence) and not isinstance(row, str) for row in rows]
    if all(nested):
        return list(rows)
    if any(nested):
        raise InputError(f"{name} mixes numbers and lists; give a list of rows of equal length")
    return [rows]


def _row(row: object, name: str) -> Row:
    assert isinstance(row, Sequence), "rows_of returns lists of entries"
    return tuple(exact_coefficient(entry, f"{name}[{j}]") for j, entry in enumerate(row))


def _vector(values: object, name: str, n: int) -> Row:
    rows = [_row(row, name) for row in rows_of(values, name)]
    widths = {len(row) for row in rows}
    flat = tuple(entry for row in rows for entry in row)
    if len(flat) == n and (len(rows) <= 1 or widths == {1}):
        return flat
    if len(widths) == 1 and n > 0 and len(flat) > n and n in (len(rows), *widths):
        count = len(flat) // n
        which = "inputs" if name == "B" else "outputs"
        raise InputError(f"{name} has {count} {which}: {ONE_PAIR}")
    shape = f"{len(rows)} x {'/'.join(map(str, sorted(widths)))}"
    raise InputError(f"{name} is {shape} and A is {n} x {n}; give {n} entries")


def _integers(rows: Sequence[Sequence[Fraction]], scale: int) -> fmpz_mat:
    from flint import fmpz_mat

    return fmpz_mat([[v.numerator * (scale // v.denominator) for v in row] for row in rows])


def _monic(matrix: fmpz_mat, scale: int) -> list[Fraction]:
    """``det(s I - M/q)``, highest power first: ``q^-n det(q s I - M)``."""
    return [Fraction(int(c), scale**i) for i, c in enumerate(reversed(matrix.charpoly().coeffs()))]
