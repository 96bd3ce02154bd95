"""Where the pieces of a fitted law end: at 0, and at quantiles of the displacements."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def spread_knots(x: Array, pieces: int) -> Array:
    """Knots with about as many points on each piece: 0, and quantiles on either side of it.

    Parameters
    ----------
    x : ndarray
        (n,) displacements.
    pieces : int
        About how many.
    """
    knots = [np.zeros(1)]
    for side in (x[x < 0], x[x > 0]):
        distinct = np.unique(side).size
        if not distinct:
            continue
        count = max(1, min(round(pieces * side.size / x.size), distinct // 2, side.size // 3))
        quantiles = np.quantile(side, np.arange(count + 1) / count)
        knots.append(quantiles[1:] if side[0] > 0 else quantiles[:-1])
    return _merged(np.unique(np.concatenate(knots)), np.unique(x))


def _merged(knots: Array, values: Array) -> Array:
    """Knots without those that leave a piece with fewer than two different points."""
    kept, i = list(knots), 0
    while i < len(kept) - 1:
        inside = np.count_nonzero((values >= kept[i]) & (values <= kept[i + 1]))
        if inside >= 2 or len(kept) == 2:
            i += 1
        elif kept[i + 1] != 0 and i + 1 < len(kept) - 1:
            del kept[i + 1]
        elif kept[i] != 0 and i > 0:
            del kept[i]
            i -= 1
        else:
            i += 1
    return np.array(kept)
