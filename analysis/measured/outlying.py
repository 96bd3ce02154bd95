"""Readings that stand out from the law and from their neighbours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_FLAGGED = 0.01
_NEIGHBOURS = 3


def outlying(x: Array, scores: Array, *, parameters: int) -> NDArray[np.bool_]:
    """Whether each reading is so far off that one clean set in a hundred has such a one.

    A run of readings that are off together shows that the law has another shape there, and none of them is an outlier:
    the three neighbours on either side must not be off as well.

    Parameters
    ----------
    x : ndarray
        (n,) displacements.
    scores : ndarray
        (n,) residuals in standard deviations.
    parameters : int
        How many were fitted.
    """
    from scipy.stats import t as student

    limit = float(student.isf(_FLAGGED / (2 * x.size), max(x.size - parameters, 3)))
    order = np.argsort(x, kind="stable")
    ranks = np.empty_like(order)
    ranks[order] = np.arange(order.size)
    found = np.zeros(scores.size, dtype=np.bool_)
    for i in np.flatnonzero(np.abs(scores) > limit):
        start = int(np.clip(ranks[i] - _NEIGHBOURS, 0, max(order.size - 2 * _NEIGHBOURS - 1, 0)))
        around = [j for j in order[start : start + 2 * _NEIGHBOURS + 1] if j != i]
        found[i] = abs(scores[i] - np.median(scores[around])) > limit
    return found
