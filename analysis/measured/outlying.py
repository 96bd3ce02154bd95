"""Readings that stand out from the law and from their neighbours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_FLAGGED = 0.01
_NEIGHBOURS = 3
_SHARED = 1 / 3
_FEW, _SOME = 3, 0.05


def outlying(x: Array, scores: Array, *, parameters: int) -> NDArray[np.bool_]:
    """Whether each reading is so far off that one clean set in a hundred has such a one.

    A run of readings that are off together shows that the law has another shape there, as at a sudden onset or drop of
    the load, and none of them is an outlier: the three neighbours on either side must not be off as well, and none of
    the readings next to it, in displacement or in time, may share a third of its distance.
    Where more than one reading in twenty stands out, the errors have another distribution, and none is an outlier.

    Parameters
    ----------
    x : ndarray
        (n,) displacements, in the order of recording.
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
        beside = [order[r] for r in (ranks[i] - 1, ranks[i] + 1) if 0 <= r < order.size]
        beside += [j for j in (i - 1, i + 1) if 0 <= j < order.size]
        alone = all(scores[j] / scores[i] < _SHARED for j in beside)
        found[i] = alone and abs(scores[i] - np.median(scores[around])) > limit
    return found if found.sum() <= max(_FEW, _SOME * x.size) else np.zeros_like(found)
