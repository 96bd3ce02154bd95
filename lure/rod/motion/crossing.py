"""The first instant at which a piecewise polynomial becomes positive: by bounds on whole intervals, not by samples."""

from __future__ import annotations

import numpy as np

from lure.errors import AssumptionError
from lure.rod.motion.chebyshev import Array, directions, left_ends, restricted, right_ends, upper_bounds, values

_MOST_INTERVALS = 20_000
_THINNEST = 1e-14
_FLAT = 0.25  # of the tolerance: what varies less is not halved, for its sign of slope may be rounding


def first_crossing(series: Array, tolerance: float) -> tuple[int, float] | None:
    """Where ``f`` first passes from at most zero to above ``tolerance``.

    Parameters
    ----------
    series : ndarray
        (m, N+1) Chebyshev coefficients of ``f`` on consecutive pieces.
    tolerance : float
        Rounding of ``f``: an excursion above zero that stays below this counts as none (grazing).

    Returns
    -------
    tuple of (int, float) or None
        Piece, and place in ``[-1, 1]`` on it of the zero before the excursion.

    Raises
    ------
    AssumptionError
        ``f`` stays so close to the tolerance that its sign cannot be decided.
    """
    top = upper_bounds(series)
    for i in np.flatnonzero(top > tolerance):
        place = _on_piece(series[i : i + 1], tolerance)
        if place is not None:
            return int(i), place
    return None


def _on_piece(series: Array, tolerance: float) -> float | None:
    """The crossing on one piece, by halving until every part is below, or rises through zero."""
    todo, seen, below = [(-1.0, 1.0)], 0, -1.0
    while todo:
        low, high = todo.pop()
        seen += 1
        if seen > _MOST_INTERVALS:
            raise AssumptionError(
                "the end of the rod keeps within rounding of the obstacle over a long time, so that contact cannot be "
                "told from free flight; change the gap or the data a little"
            )
        part = series if (low, high) == (-1.0, 1.0) else restricted(series, np.array([low]), np.array([high]))
        start, stop = float(left_ends(part)[0]), float(right_ends(part)[0])
        if start <= 0.0:
            below = low
        if upper_bounds(part)[0] <= tolerance:
            continue
        if start > tolerance or (directions(part)[0] > 0 and start >= 0.0):
            return _zero(series, below, low) if low > below else low
        flat = float(np.abs(part[0, 1:]).sum()) <= _FLAT * tolerance or high - low < _THINNEST
        if directions(part)[0] > 0 or flat:
            if stop > tolerance:
                return _zero(series, below, high)
            continue
        middle = 0.5 * (low + high)
        todo += [(middle, high), (low, middle)]
    return None


def _zero(series: Array, low: float, high: float) -> float:
    """The zero in between, where ``f(low) <= 0 < f(high)``: regula falsi (Illinois), kept inside by bisection."""

    def f(x: float) -> float:
        """One value."""
        return float(values(series, np.array([[x]]))[0, 0])

    below, above, last = f(low), f(high), 0
    for step in range(200):
        if high - low <= 2.3e-16 * max(1.0, abs(low)) or below == 0.0:
            return low
        secant = step % 8 < 6 and above - below > 0.0
        x = (low * above - high * below) / (above - below) if secant else 0.5 * (low + high)
        if not low < x < high:
            x = 0.5 * (low + high)
            if not low < x < high:
                return low
        value = f(x)
        if value > 0.0:
            high, above = x, value
            below, last = below * (0.5 if last > 0 else 1.0), 1
        else:
            low, below = x, value
            above, last = above * (0.5 if last < 0 else 1.0), -1
            if value == 0.0:
                return x
    return low
