"""Semidefinite programmes, proposed by Clarabel: what it returns is a proposal, whatever its status says."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from lure.arrays import NDArray, np


class Block(NamedTuple):
    """A linear matrix inequality ``constant + sum_k x_k slopes[k] >= 0``: (p, p) and (K, p, p), symmetric."""

    constant: NDArray[np.float64]
    slopes: NDArray[np.float64]


def symmetric_basis(p: int) -> NDArray[np.float64]:
    """The matrices with ``x_ij = x_ji = 1`` and no other entry, row by row of the lower triangle: (p (p + 1)/2, p, p).

    Parameters
    ----------
    p : int
        Order.
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
    import clarabel
    from scipy import sparse

    sides, limits = [sparse.csc_matrix(rows)], [most]
    cones = [clarabel.NonnegativeConeT(len(most))]
    for constant, slopes in blocks:
        i, j = np.tril_indices(len(constant))  # row by row below is column by column above, as the cone has it
        scale = np.where(i == j, 1.0, np.sqrt(2.0))
        sides.append(sparse.csc_matrix(-(slopes[:, i, j] * scale).T))
        limits.append(constant[i, j] * scale)
        cones.append(clarabel.PSDTriangleConeT(len(constant)))
    for under, over in logarithms:  # (x_j, 1, x_k) in the exponential cone
        sides.append(sparse.csc_matrix(([-1.0, -1.0], ([0, 2], [under, over])), shape=(3, len(cost))))
        limits.append(np.array([0.0, 1.0, 0.0]))
        cones.append(clarabel.ExponentialConeT())
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    size = len(cost)
    whole = sparse.vstack(sides, format="csc")
    solver = clarabel.DefaultSolver(
        sparse.csc_matrix((size, size)), -np.asarray(cost), whole, np.concatenate(limits), cones, settings
    )
    found = np.array(solver.solve().x)
    return found if found.shape == (size,) and np.isfinite(found).all() else None
