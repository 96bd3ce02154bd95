"""Chebyshev series on ``[-1, 1]``, many at once, and functions of time as such series on pieces."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from lure.errors import InputError
from lure.record import described, quantity

Array = NDArray[np.float64]
SAME = 2e-15  # edges closer than this, of a window of length 2, are one
NARROWEST = 1e-13
_HALVINGS = 44
_MOST = 5000
_CHECKS = np.array([-0.97, -0.43, 0.11, 0.71])
LOOKS = 2048
_DENORMAL = 1e-320
NOISE = 4e-16  # of a function: what its fit leaves of coefficients that are zero
_NEAR_END = 1e-6  # distance of the outermost checks from the ends, in half widths,
_CLEAR_OF_END = 2e-14  # but not less than this, for an end is known to rounding only


@described(frozen=True, kw_only=True, eq=False, slots=True)
class Basis:
    """Points and matrices of one degree ``N``; make one with :func:`basis`."""

    degree: int = quantity("``N``")
    inner: Array = quantity(
        "(N+1,) zeros of ``T_{N+1}``, ascending: data are read there, never on a jump at the end of a piece"
    )
    ends: Array = quantity("(N+1,) extrema of ``T_N``, ascending, both ends included")
    from_inner: Array = quantity("(N+1, N+1) from values at ``inner`` to coefficients")
    from_ends: Array = quantity("(N+1, N+1) from values at ``ends`` to coefficients")
    integral: Array = quantity(
        "(N+1, N+1) from coefficients to those of ``int_{-1}^x``, without its term of degree ``N+1``"
    )
    derivative: Array = quantity("(N+1, N+1) from coefficients to those of the derivative")
    collocation: Array = quantity(
        "(N, N) from values at ``ends[1:]`` to the integral from -1 of their interpolant there"
    )
    at_ends: Array = quantity("(N+1, N+1) from coefficients to values at ``ends``")
    at_gauss: Array = quantity("(N+1, N+1) from coefficients to values at the Gauss points")
    gauss: Array = quantity("(N+1,) Gauss points")
    weights: Array = quantity("(N+1,) Gauss weights")


@lru_cache(maxsize=8)
def basis(degree: int) -> Basis:
    """The points and matrices of the degree."""
    n = degree + 1
    inner = -np.cos(np.pi * (np.arange(n) + 0.5) / n)
    ends = -np.cos(np.pi * np.arange(n) / degree)
    ends[0], ends[-1] = -1.0, 1.0
    unit = np.eye(n)
    integral = np.column_stack([chebyshev.chebint(row, lbnd=-1)[:n] for row in unit])
    derivative = np.zeros((n, n))
    for k in range(1, n):
        derivative[:k, k] = chebyshev.chebder(unit[k])[:k]
    gauss, weights = np.polynomial.legendre.leggauss(n)
    right = _inverse(ends[1:], degree - 1)
    primitives = np.column_stack([chebyshev.chebint(column, lbnd=-1) for column in right.T])
    return Basis(
        degree=degree,
        inner=inner,
        ends=ends,
        from_inner=_inverse(inner, degree),
        from_ends=_inverse(ends, degree),
        integral=np.asarray(integral, dtype=float),
        derivative=derivative,
        collocation=np.asarray(chebyshev.chebvander(ends[1:], degree) @ primitives, dtype=float),
        at_ends=np.asarray(chebyshev.chebvander(ends, degree), dtype=float),
        at_gauss=np.asarray(chebyshev.chebvander(gauss, degree), dtype=float),
        gauss=gauss,
        weights=weights,
    )


def _inverse(points: Array, degree: int) -> Array:
    """From values at the points to coefficients."""
    return np.asarray(np.linalg.inv(chebyshev.chebvander(points, degree)), dtype=float)


@lru_cache(maxsize=32)
def products(size: int) -> Array:
    """Integrals of ``T_i T_j`` (size, size) over ``[-1, 1]``."""
    i, j = np.arange(size, dtype=float)[:, None], np.arange(size, dtype=float)[None, :]
    even = (i + j) % 2 == 0
    return np.where(even, 1.0 / (1.0 - (i + j) ** 2 * even) + 1.0 / (1.0 - (i - j) ** 2 * even), 0.0)


def values(coefficients: Array, x: Array) -> Array:
    """Values (m, j) of m series (m, N+1) at their own points ``x`` (m, j), by Clenshaw's recurrence."""
    if coefficients.shape[1] == 1:
        return np.asarray(coefficients + 0.0 * x)
    doubled, before = 2.0 * x, np.zeros_like(x)
    total = before + coefficients[:, -1, None]
    for k in range(coefficients.shape[1] - 2, 0, -1):
        above, before = before, total
        total = doubled * before
        total -= above
        total += coefficients[:, k, None]
    total *= x
    total -= before
    total += coefficients[:, 0, None]
    return total


def right_ends(coefficients: Array) -> Array:
    """Values (m,) at 1."""
    return np.asarray(coefficients.sum(axis=1))


def left_ends(coefficients: Array) -> Array:
    """Values (m,) at -1."""
    return np.asarray(coefficients[:, ::2].sum(axis=1) - coefficients[:, 1::2].sum(axis=1))


def restricted(coefficients: Array, low: Array, high: Array) -> Array:
    """The series (m, N+1) on ``[low, high]`` (m,), a part of ``[-1, 1]`` each, as series on ``[-1, 1]``."""
    space = basis(coefficients.shape[1] - 1)
    x = low[:, None] + 0.5 * (high - low)[:, None] * (space.inner + 1.0)
    return np.asarray(values(coefficients, x) @ space.from_inner.T)


def largest(coefficients: Array) -> float:
    """A bound on ``|f|`` for all series: the largest sum of ``|c_k|``."""
    return float(np.abs(coefficients).sum(axis=1).max(initial=0.0))


def tails(coefficients: Array) -> Array:
    """Size (m,) of the last two coefficients: what is left out is of that order or less if they fall off."""
    return np.asarray(np.abs(coefficients[:, -2:]).max(axis=1))


def upper_bounds(series: Array) -> Array:
    """Upper bounds (m,) on the largest value on each piece: the larger end where the derivative keeps its sign."""
    size = np.abs(series)
    top = series[:, 0] + size[:, 1:].sum(axis=1)
    ends = np.maximum(left_ends(series), right_ends(series))
    return np.where(directions(series) != 0, ends, top)


def directions(series: Array) -> Array:
    """1 or -1 (m,) where the function certainly rises or falls on the whole piece, else 0."""
    slope = series @ basis(series.shape[1] - 1).derivative.T
    rest = np.abs(slope[:, 1:]).sum(axis=1)
    return np.where(np.abs(slope[:, 0]) >= rest, np.sign(slope[:, 0]), 0.0)


def supremum(series: Array) -> tuple[float, float]:
    """Bracket on the largest value of a piecewise polynomial; ``series``: (m, N+1) Chebyshev coefficients.

    Returns
    -------
    low, high : float
        A value that is taken, and a bound that no value exceeds, up to rounding.

    Examples
    --------
    >>> low, high = supremum(np.array([[0.0, 0.5, -0.5]]))  # -x^2 + x/2 + 1/2 is largest at x = 1/4
    >>> low, bool(high - low < 1e-12)
    (0.5625, True)
    """
    space = basis(series.shape[1] - 1)
    size = float(np.abs(series).sum(axis=1).max())
    low, high = -np.inf, -np.inf
    for _ in range(_HALVINGS):
        low = max(low, float((series @ space.at_ends.T).max()))
        tops = upper_bounds(series)
        open_ = tops > low + 1e-15 * size
        high = max(high, float(tops[~open_].max(initial=-np.inf)))
        if not open_.any():
            return low, max(low, high)
        left, right = np.full(int(open_.sum()), -1.0), np.zeros(int(open_.sum()))
        series = np.concatenate((restricted(series[open_], left, right), restricted(series[open_], right, -left)))
    return low, max(low, high, float(upper_bounds(series).max()))


@described(frozen=True, eq=False, slots=True)
class Pieces:
    """A piecewise polynomial."""

    edges: Array = quantity("(m+1,) ascending ends of the pieces")
    series: Array = quantity("(m, N+1) Chebyshev coefficients on each")

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
    looks: int = LOOKS,
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
    looks : int
        Points at which hidden pulses are looked for; few do for a formula that has none.

    Returns
    -------
    pieces : Pieces
        The fit.
    error : float
        Sum over the pieces of what is left at the checking points or of the rounding there, times their widths.

    Raises
    ------
    InputError
        More than 5000 pieces are needed in a round trip.
    """
    space, n = basis(degree), degree + 1
    looks = 2 * max(8, looks // len(edges))
    starts, stops, error, halved = edges[:-1], edges[1:], 0.0, False
    done: list[tuple[float, float, Array]] = []
    while starts.size:
        half = 0.5 * (stops - starts)[:, None]
        last = np.maximum(1.0 - np.maximum(_NEAR_END, _CLEAR_OF_END / half), 0.5)
        looks //= 2
        checks = np.append(_CHECKS, (2.0 * np.arange(looks) + 0.74) / max(looks, 1) - 1.0)
        x = np.empty((len(starts), n + len(checks) + 2))
        x[:, :n], x[:, n:-2], x[:, -2:-1], x[:, -1:] = space.inner, checks, -last, last
        table, noise = (part.reshape(x.shape) for part in function((starts[:, None] + half * (x + 1.0)).ravel()))
        size = float(np.abs(table).max())
        scale, series = max(scale, size), table[:, :n] @ space.from_inner.T
        seen = np.abs(series).max(axis=0) > NOISE * size
        shown = values(series[:, : n - int(seen[::-1].argmax())], x[:, n:])
        miss = (np.abs(shown - table[:, n:]) - 8.0 * noise[:, n:]).max(axis=1)
        miss = np.maximum(miss, tails(series))
        doubt = np.partition(noise[:, :n], n - 3, axis=1)[:, n - 3]  # a jump near one node or two excuses nothing
        allowed = 3e-15 * scale + _DENORMAL + 8.0 * doubt
        if len(starts) + len(done) > _MOST * max(1.0, 0.5 * (edges[-1] - edges[0])):
            raise InputError(
                f"the loads and initial data need more than {_MOST} pieces in one round trip; give "
                "smoother or slower ones"
            )
        narrow = (miss > allowed) & (stops - starts < NARROWEST)
        series[narrow] = 0.0  # a straight ramp: a polynomial would ring about a jump
        series[narrow, 0], series[narrow, 1] = 0.5 * (table[narrow, n - 1] + [[1.0], [-1.0]] * table[narrow, 0])
        good = (miss <= allowed) | narrow
        error += float(((miss + doubt) * (stops - starts))[good].sum())
        if not halved and good.all():
            return Pieces(edges, series), error
        halved = True
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
