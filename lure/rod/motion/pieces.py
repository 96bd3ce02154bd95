"""A function of time as Chebyshev series on pieces, which jumps and kinks separate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lure.errors import InputError
from lure.rod.motion.chebyshev import Array, basis, restricted, tails, values

SAME = 2e-15  # edges closer than this, of a window of length 2, are one
NARROWEST = 1e-13
_MOST = 5000
_CHECKS = np.array([-0.97, -0.43, 0.11, 0.71])
_LOOKS = 2048
_DENORMAL = 1e-320
_NEAR_END = 1e-6  # distance of the outermost checks from the ends, in half widths,
_CLEAR_OF_END = 2e-14  # but not less than this, for an end is known to rounding only


@dataclass(frozen=True, eq=False, slots=True)
class Pieces:
    """A piecewise polynomial.

    Attributes
    ----------
    edges : ndarray
        (m+1,) ascending ends of the pieces.
    series : ndarray
        (m, N+1) Chebyshev coefficients on each.
    """

    edges: Array
    series: Array

    @property
    def widths(self) -> Array:
        """Lengths (m,) of the pieces."""
        return np.diff(self.edges)

    def __call__(self, x: Array) -> Array:
        """Values (n,) at points (n,) between the first edge and the last; on an edge those from the right."""
        i = np.clip(np.searchsorted(self.edges, x, side="right") - 1, 0, len(self.series) - 1)
        low, high = self.edges[i], self.edges[i + 1]
        local = np.clip(((x - low) - (high - x)) / (high - low), -1.0, 1.0)
        return values(self.series[i], local[:, None])[:, 0]

    def on(self, edges: Array) -> Pieces:
        """The same function with more edges, or with fewer of it at the ends."""
        parent = np.clip(
            np.searchsorted(self.edges, 0.5 * (edges[:-1] + edges[1:])) - 1,
            0,
            len(self.series) - 1,
        )
        low, high = self.edges[parent], self.edges[parent + 1]
        series = self.series[parent]
        cut = np.flatnonzero((edges[:-1] != low) | (edges[1:] != high))
        if cut.size:
            low, high = low[cut], high[cut]
            a = ((edges[cut] - low) - (high - edges[cut])) / (high - low)
            b = ((edges[cut + 1] - low) - (high - edges[cut + 1])) / (high - low)
            series[cut] = restricted(series[cut], np.maximum(a, -1.0), np.minimum(b, 1.0))
        return Pieces(edges, series)


def joined(first: Pieces, second: Pieces) -> tuple[Pieces, Pieces]:
    """Both functions on the edges of both."""
    edges = union(first.edges, second.edges)
    return first.on(edges), second.on(edges)


def union(first: Array, second: Array) -> Array:
    """Edges of both, without any of the second that agrees with one of the first to rounding; the span of the first."""
    inside = second[(second > first[0] + SAME) & (second < first[-1] - SAME)]
    near = np.abs(first[np.clip(np.searchsorted(first, inside), 1, len(first) - 1)] - inside)
    near = np.minimum(
        near,
        np.abs(first[np.clip(np.searchsorted(first, inside) - 1, 0, len(first) - 1)] - inside),
    )
    return np.sort(np.concatenate((first, inside[near > SAME]))) if inside.size else first


def distinct(points: list[float], low: float, high: float) -> Array:
    """``low``, ``high`` and the points strictly between, sorted, those that agree to rounding once."""
    kept = [low]
    for point in sorted(points):
        if low + SAME < point < high - SAME and point > kept[-1] + SAME:
            kept.append(point)
    return np.array([*kept, high])


def fitted(
    function: Callable[[Array], tuple[Array, Array]],
    edges: Array,
    degree: int,
    scale: float,
) -> tuple[Pieces, float]:
    """A function from outside as pieces, halved until the series resolves it.

    Parameters
    ----------
    function : callable
        From points (n,) to values (n,) and the size (n,) of their rounding errors.
    edges : ndarray
        Where it may jump or have a kink; kinks that are not listed cost halvings down to a width of 1e-13, a jump that
        is not becomes a ramp of that width.  What shows at none of 2048 points is not seen.
    degree : int
        Of the series.
    scale : float
        Size to which errors are relative, if larger than the function itself.

    Returns
    -------
    pieces : Pieces
        The fit.
    error : float
        Sum over the pieces of what is left at the checking points or of the rounding there, times their widths.

    Raises
    ------
    InputError
        More than 5000 pieces are needed.
    """
    space, n = basis(degree), degree + 1
    looks = 2 * max(8, _LOOKS // len(edges))
    starts, stops, error = edges[:-1], edges[1:], 0.0
    done: list[tuple[float, float, Array]] = []
    while starts.size:
        half = 0.5 * (stops - starts)[:, None]
        last = np.maximum(1.0 - np.maximum(_NEAR_END, _CLEAR_OF_END / half), 0.5)
        looks //= 2
        checks = np.append(_CHECKS, (2.0 * np.arange(looks) + 0.74) / max(looks, 1) - 1.0)
        x = np.hstack((np.tile(np.append(space.inner, checks), (len(starts), 1)), -last, last))
        table, noise = (part.reshape(x.shape) for part in function((starts[:, None] + half * (x + 1.0)).ravel()))
        scale = max(scale, float(np.abs(table).max()))
        series = table[:, :n] @ space.from_inner.T
        miss = (np.abs(values(series, x[:, n:]) - table[:, n:]) - 8.0 * noise[:, n:]).max(axis=1)
        miss = np.maximum(miss, tails(series))
        doubt = np.partition(noise[:, :n], n - 3, axis=1)[:, n - 3]  # a jump near one node or two excuses nothing
        allowed = 3e-15 * scale + _DENORMAL + 8.0 * doubt
        if len(starts) + len(done) > _MOST:
            raise InputError(
                f"the loads and initial data need more than {_MOST} pieces in one round trip; give "
                "smoother or slower ones"
            )
        narrow = (miss > allowed) & (stops - starts < NARROWEST)
        series[narrow] = 0.0  # a straight ramp: a polynomial would ring about a jump
        series[narrow, 0], series[narrow, 1] = 0.5 * (table[narrow, n - 1] + [[1.0], [-1.0]] * table[narrow, 0])
        good = (miss <= allowed) | narrow
        error += float(((miss + doubt) * (stops - starts))[good].sum())
        done += list(zip(starts[good], stops[good], series[good], strict=True))
        middle = 0.5 * (starts[~good] + stops[~good])
        starts, stops = (
            np.concatenate((starts[~good], middle)),
            np.concatenate((middle, stops[~good])),
        )
    done.sort(key=lambda piece: piece[0])
    return Pieces(
        np.array([*(piece[0] for piece in done), edges[-1]]),
        np.array([piece[2] for piece in done]),
    ), error


def merged(pieces: Pieces, tolerance: float) -> Pieces:
    """The same function to the tolerance, neighbours made one piece where one series will do."""
    for first in (0, 1):
        pairs = np.arange(first, len(pieces.series) - 1, 2)
        if not pairs.size:
            return pieces
        space = basis(pieces.series.shape[1] - 1)
        low, high = pieces.edges[pairs], pieces.edges[pairs + 2]
        points = low[:, None] + 0.5 * (high - low)[:, None] * (space.inner + 1.0)
        series = pieces(points.ravel()).reshape(points.shape) @ space.from_inner.T
        good = np.ones(len(pairs), dtype=bool)
        for part in (0, 1):
            start, stop = pieces.edges[pairs + part], pieces.edges[pairs + part + 1]
            a, b = (
                2.0 * (start - low) / (high - low) - 1.0,
                2.0 * (stop - low) / (high - low) - 1.0,
            )
            again = restricted(series, a, b)
            good &= np.abs(again - pieces.series[pairs + part]).sum(axis=1) <= tolerance
        drop = pairs[good] + 1
        kept = pieces.series.copy()
        kept[pairs[good]] = series[good]
        pieces = Pieces(np.delete(pieces.edges, drop), np.delete(kept, drop, axis=0))
    return pieces
