"""A Popov multiplier for a curve that is only drawn: the line with the most room, of those the simplest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_HALVINGS = 60
_ANY = 1e-4  # of the size of the curve: where 1/k = 0, all room vanishes at infinity
Floats = NDArray[np.float64]


def searched_theta(x: Floats, y: Floats, k: float) -> float:
    r"""The ``theta`` nearest to 0 for which the points keep half of the best room from the line, or the best there is.

    The room is ``min_i (1/k + x_i - theta y_i)``, concave and piecewise linear in ``theta``; its maximum is found by
    halving, to about twice the rounding error.  Where some ``theta`` leaves room, the line returned leaves at least
    half of the most (for ``k = inf`` any); where none does, it falls short by the least.

    Parameters
    ----------
    x, y : ndarray
        (m,) ``Re H`` and ``omega Im H`` at the points drawn, finite.
    k : float
        Upper end of the sector, positive or ``inf``.

    Returns
    -------
    float
        ``theta`` [s], of either sign; for ``k = inf`` not negative, as Popov's theorem asks.
    """
    ease = 0.0 if np.isinf(k) else 1.0 / k
    start = float(np.min(x)) + ease  # theta = 0 leaves that much
    low, high = start, max(start, ease or float(np.max(np.abs(x))))
    if start < high and _window(x, y, ease - high, k) is None:
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            if _window(x, y, ease - middle, k) is None:
                high = middle
            else:
                low = middle
        best = low
    else:
        best = high
    level = max(start, (_ANY if np.isinf(k) else 0.5) * best) if best > 0 else best
    left, right = _window(x, y, ease - level, k) or (0.0, 0.0)
    return min(max(0.0, left), right)


def _window(x: Floats, y: Floats, ease: float, k: float) -> tuple[float, float] | None:
    """All ``theta`` with ``ease + x - theta y >= 0`` at every point, None if there are none."""
    room = x + ease
    if bool((room[y == 0] < 0).any()):
        return None
    up, down = y > 0, y < 0
    with np.errstate(over="ignore"):  # a point with y next to nothing asks for nothing that doubles could say
        right = float(np.min(room[up] / y[up])) if up.any() else np.inf
        left = float(np.max(room[down] / y[down])) if down.any() else -np.inf
    left = max(left, 0.0) if np.isinf(k) else left
    return (left, right) if left <= right and np.isfinite(min(max(0.0, left), right)) else None
