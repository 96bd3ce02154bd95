"""Semidefinite programmes, proposed by Clarabel: what it returns is a proposal, whatever its status says."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from lure.analysis.deadline import checkpoint
from lure.arrays import NDArray, Reals, np

_FEW, _MANY = 1e-4, 1e-8  # tolerances
_EACH, _MORE, _VIOLATED, _FALSE = 8, 12, 1e-8, 1e-5  # to begin with every 8th inequality; 12 more where violated


class Block(NamedTuple):
    """A linear matrix inequality ``constant + sum_k x_k slopes[k] >= 0``: (p, p) and (K, p, p), symmetric."""

    constant: NDArray[np.float64]
    slopes: NDArray[np.float64]


class Limits:
    """Rows of a programme, ``sum_j parts_j x_j <= limit``, of which few entries are not 0.

    Parameters
    ----------
    total : int
        The number of unknowns.
    """

    def __init__(self, total: int) -> None:
        self.total, self._rows, self._most = total, list[Reals](), list[float]()

    def at_most(self, parts: Mapping[int, float], limit: float) -> None:
        """Add a row.

        ``parts``: the factors of the unknowns in it; ``limit``: what their sum is at most.
        """
        row = np.zeros(self.total)
        row[list(parts)] = list(parts.values())
        self._rows.append(row)
        self._most.append(limit)

    def arrays(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """All rows, (r, total), and their limits, (r,)."""
        return np.array(self._rows).reshape(-1, self.total), np.array(self._most)


def symmetric_basis(p: int) -> NDArray[np.float64]:
    """The matrices with ``x_ij = x_ji = 1`` and no other entry, row by row of the lower triangle: (p (p + 1)/2, p, p).

    ``p``: order.
    """
    rows, columns = np.tril_indices(p)
    found, k = np.zeros((len(rows), p, p)), np.arange(len(rows))
    found[k, rows, columns] = found[k, columns, rows] = 1.0
    return np.asarray(found)


def proposed(
    cost: NDArray[np.float64],
    blocks: Sequence[Block],
    rows: NDArray[np.float64],
    most: NDArray[np.float64],
    *,
    logarithms: Sequence[tuple[int, int]] = (),
) -> NDArray[np.float64] | None:
    """About the largest ``cost x`` with every block positive semidefinite and ``rows x <= most``.

    Parameters
    ----------
    cost : ndarray
        (K,).
    blocks : sequence of Block
        Linear matrix inequalities.
    rows, most : ndarray
        (r, K) and (r,).
    logarithms : sequence of (int, int)
        Pairs ``(j, k)`` with ``x_j <= log x_k``.

    Returns
    -------
    ndarray or None
        (K,), feasible and optimal up to some 1e-8 at best; None where the solver has nothing finite to say.

    Raises
    ------
    ModuleNotFoundError
        Clarabel is not installed.
    """
    return _solved(cost, blocks, (rows, most), logarithms, _MANY)


def roughly(
    cost: NDArray[np.float64], blocks: Sequence[Block], rows: NDArray[np.float64], most: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """As :func:`proposed`, with few digits.

    Parameters
    ----------
    cost : ndarray
        (K,).
    blocks : sequence of Block
        Linear matrix inequalities.
    rows, most : ndarray
        (r, K) and (r,).
    """
    return _solved(cost, blocks, (rows, most), (), _FEW)


def in_stages(
    cost: NDArray[np.float64],
    parts: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]],
    limits: Limits,
    chosen: Sequence[set[int]],
    sure: float,
) -> NDArray[np.float64] | None:
    """As :func:`proposed`, with few of the inequalities first, and with those that a solution violates, till none is.

    Parameters
    ----------
    cost : ndarray
        (K,).
    parts : sequence of (ndarray, ndarray)
        Inequalities of one size each: constants (r, p, p), and slopes (r, K, p, p).
    limits : Limits
        The rows.
    chosen : sequence of set of int
        Which of each are to begin with besides every eighth; those that were needed are added.
    sure : float
        A solution of which the last unknown is no larger is returned at once: with more inequalities it only falls.
    """
    for (constant, _), own in zip(parts, chosen, strict=True):
        own.update(range(0, len(constant), _EACH))
    while True:
        checkpoint()
        blocks = [Block(part[0][i], part[1][i]) for part, own in zip(parts, chosen, strict=True) for i in sorted(own)]
        found = proposed(cost, blocks, *limits.arrays())
        if found is None or not found[-1] > sure:
            return found
        more, worst = 0, 0.0
        for (constant, slopes), own in zip(parts, chosen, strict=True):
            least = np.linalg.eigvalsh(constant + np.tensordot(slopes, found, (1, 0)))[:, 0]
            violated = [int(i) for i in np.argsort(least)[:_MORE] if least[i] < -_VIOLATED and int(i) not in own]
            own.update(violated)
            more, worst = more + len(violated), min(worst, float(least.min()))
        if not more:
            return found if worst > -_FALSE else None


def _solved(
    cost: NDArray[np.float64],
    blocks: Sequence[Block],
    given: tuple[NDArray[np.float64], NDArray[np.float64]],
    logarithms: Sequence[tuple[int, int]],
    digits: float,
) -> NDArray[np.float64] | None:
    import clarabel
    from scipy import sparse

    (rows, most), size = given, len(cost)
    sides, limits = [_entries(rows)], [most]
    cones = [clarabel.NonnegativeConeT(len(most))]
    for constant, slopes in blocks:
        i, j = np.tril_indices(len(constant))  # row by row below is column by column above, as the cone has it
        scale = np.where(i == j, 1.0, np.sqrt(2.0))
        sides.append(_entries(-(slopes[:, i, j] * scale).T))
        limits.append(constant[i, j] * scale)
        cones.append(clarabel.PSDTriangleConeT(len(constant)))
    for under, over in logarithms:  # (x_j, 1, x_k) in the exponential cone
        sides.append((np.array([0, 2]), np.array([under, over]), np.array([-1.0, -1.0])))
        limits.append(np.array([0.0, 1.0, 0.0]))
        cones.append(clarabel.ExponentialConeT())
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = digits
    starts = np.cumsum([0, *map(len, limits)])
    down, across, values = (np.concatenate(part) for part in zip(*sides, strict=True))
    down = down + np.repeat(starts[:-1], [len(one[0]) for one in sides])
    whole = sparse.csc_matrix((values, (down, across)), shape=(starts[-1], size))
    solver = clarabel.DefaultSolver(
        sparse.csc_matrix((size, size)), -np.asarray(cost), whole, np.concatenate(limits), cones, settings
    )
    try:
        found = np.array(solver.solve().x)
    except BaseException as error:  # a panic of the compiled solver is no Exception
        if type(error).__name__ != "PanicException":
            raise
        return None
    return found if found.shape == (size,) and np.isfinite(found).all() else None


def _entries(rows: NDArray[np.float64]) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]]:
    """Where a matrix is not 0, and what it is there."""
    down, across = np.nonzero(rows)
    return down, across, rows[down, across]


def hermitian_rows(X: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Hermitian ``X`` as the scaled triangle of ``(Re X, -Im X; Im X, Re X)``, column after column.

    ``X``: (.., m, m).
    """
    whole = np.block([[X.real, -X.imag], [X.imag, X.real]])
    i, j = np.tril_indices(whole.shape[-1])  # row by row below is column by column above
    return np.asarray(whole[..., i, j] * np.where(i == j, 1.0, math.sqrt(2)))


def hermitian_duals(rows: NDArray[np.float64], m: int) -> NDArray[np.complex128]:
    """The Hermitian ``Z`` with ``tr Z X`` for the product of a dual variable with :func:`hermitian_rows` of ``X``.

    ``rows``: (k, m (2m + 1)) dual variables; ``m``: order of ``X``.
    """
    i, j = np.tril_indices(2 * m)
    Z = np.zeros((len(rows), 2 * m, 2 * m))
    Z[:, i, j] = Z[:, j, i] = rows * np.where(i == j, 1.0, math.sqrt(0.5))
    return np.asarray(Z[:, :m, :m] + Z[:, m:, m:] + 1j * (Z[:, m:, :m] - Z[:, :m, m:]))


def hermitian_programme(
    gain: NDArray[np.float64],
    equal: tuple[NDArray[np.float64], NDArray[np.float64]],
    most: tuple[NDArray[np.float64], NDArray[np.float64]],
    positive: Sequence[NDArray[np.float64]],
) -> tuple[NDArray[np.float64], NDArray[np.float64], list[NDArray[np.float64]]] | None:
    """``x`` with about the largest ``gain x``, the prices of ``most``, and the dual variables of the cones.

    Parameters
    ----------
    gain : ndarray
        (K,).
    equal, most : tuple of ndarray
        ``equal[0] x = equal[1]``, ``most[0] x <= most[1]``.
    positive : sequence of ndarray
        Each (k, r, K): every ``positive[..][k] x`` is the triangle of a matrix ``>= 0``.
    """
    import clarabel
    from scipy import sparse

    cones = [clarabel.ZeroConeT(len(equal[1])), clarabel.NonnegativeConeT(len(most[1]))]
    for one in positive:
        cones += [clarabel.PSDTriangleConeT((math.isqrt(8 * one.shape[1] + 1) - 1) // 2)] * len(one)
    size = len(gain)
    whole = np.vstack([equal[0], most[0], *(-one.reshape(-1, size) for one in positive)])
    limits = np.concatenate([equal[1], most[1], np.zeros(len(whole) - len(equal[1]) - len(most[1]))])
    settings = clarabel.DefaultSettings()
    settings.verbose, settings.max_threads = False, 1
    given = (sparse.csc_matrix((size, size)), -gain, sparse.csc_matrix(whole), limits, cones, settings)
    solution = clarabel.DefaultSolver(*given).solve()
    x, z = np.array(solution.x), np.array(solution.z)
    if not (np.isfinite(x).all() and np.isfinite(z).all()):
        return None
    first = len(equal[1])
    ends = np.cumsum([first + len(most[1]), *(one.shape[0] * one.shape[1] for one in positive)])
    duals = [z[low:high].reshape(one.shape[:2]) for one, low, high in zip(positive, ends, ends[1:], strict=False)]
    return x, z[first : ends[0]], duals
