r"""The mean law as a continuous function, affine between knots, with ``f(0) = 0``: fitted, with its covariance.

Near ``sigma = 0`` no measured load is divided by a small displacement: on the pieces beside 0 the ratio ``f/sigma`` is
the slope of the piece, which all of its points determine together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.measured.noise import Noise, noise_of
from analysis.measured.outlying import outlying
from lure.errors import InputError

Array = NDArray[np.float64]
LEAST_ROWS = 12
_PER_PIECE = 6
_MOST_PIECES = 64
BENT = 0.05
_TUKEY, _HUBER = 4.685, 1.345
_ROUNDS = 30


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class MeanLaw:
    """The fitted mean law.

    Attributes
    ----------
    knots, values : ndarray
        (K + 1,) places [m], 0 among them, and values there [unit of the load].
    covariance : ndarray
        (K + 1, K + 1) of the values, already scaled; the row and column of the knot 0 vanish unless it was free.
    degrees : int
        Rows less parameters, outliers left out.
    noise : Noise
        Standard deviation of one reading.
    scores : ndarray
        (n,) residuals in standard deviations of a residual, in the order of the rows.
    outliers : ndarray of int
        Rows left out.
    curved : float
        p-value of the test that twice as many pieces fit no better; small means that the class is contradicted.
    """

    knots: Array
    values: Array
    covariance: Array
    degrees: int
    noise: Noise
    scores: Array
    outliers: NDArray[np.intp]
    curved: float

    def __call__(self, sigma: ArrayLike) -> Array:
        """The law [unit of the load] at ``sigma`` [m], elementwise; only between the first knot and the last."""
        return np.asarray(np.interp(np.asarray(sigma, dtype=float), self.knots, self.values))

    def error(self, sigma: ArrayLike) -> Array:
        """Standard error of the law [unit of the load], elementwise."""
        rows = _weights_at(np.asarray(sigma, dtype=float), self.knots)
        return np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", rows, self.covariance, rows), 0.0))

    def slopes(self) -> Array:
        """(K, K + 1) the slope on each piece as a combination of the values."""
        widths = np.diff(self.knots)
        pieces = np.zeros((widths.size, self.knots.size))
        index = np.arange(widths.size)
        pieces[index, index], pieces[index, index + 1] = -1 / widths, 1 / widths
        return pieces

    def bends(self) -> Array:
        """(K,) at least the change of slope within each piece of a smooth law: to the next piece on either side."""
        change = np.abs(np.diff(self.slopes() @ self.values))
        return np.maximum(np.append(change, 0.0), np.insert(change, 0, 0.0))

    def missed(self, sigma: ArrayLike) -> Array:
        """About how far from the law a curve may run between its knots [unit of the load], elementwise."""
        index, _ = _places(np.asarray(sigma, dtype=float), self.knots)
        return np.asarray(0.25 * (self.bends() * np.diff(self.knots))[index])

    def end_slopes(self) -> Array:
        """(at most 2, K + 1) slopes at the two ends, extrapolated from two pieces where these differ by two errors."""
        slopes = self.slopes()
        found = []
        for last, before in ((0, 1), (-1, -2)):
            if len(slopes) < 2 or self.knots[1 if last == 0 else -2] == 0:
                continue
            change = slopes[last] - slopes[before]
            if abs(change @ self.values) > 2 * np.sqrt(max(change @ self.covariance @ change, 0.0)):
                found.append(slopes[last] + 0.5 * change)
        return np.array(found).reshape(-1, self.knots.size)

    def chords(self) -> Array:
        """(K, K + 1) the chord ``f/sigma`` at each knot but 0, as a combination of the values."""
        away = np.flatnonzero(self.knots)
        chords = np.zeros((away.size, self.knots.size))
        chords[np.arange(away.size), away] = 1 / self.knots[away]
        return chords


def mean_law(sigma: Array, load: Array, *, pieces: int | None = None, free: bool = False) -> MeanLaw:
    """The mean law through measured points, by weighted least squares without outliers.

    The number of pieces is doubled until a test at the level 5 % sees nothing in the last doubling: what the pieces
    leave out is then small beside the noise.

    Parameters
    ----------
    sigma, load : ndarray
        (n,) [m] and [N] or [Pa].
    pieces : int, optional
        About as many pieces instead.
    free : bool
        Whether the value at 0 is fitted too, instead of being 0.

    Raises
    ------
    InputError
        There are fewer than 12 rows or 4 different displacements.
    """
    distinct = np.unique(sigma).size
    if sigma.size < LEAST_ROWS or distinct < 4:
        raise InputError(
            f"the measurements have {sigma.size} rows and {distinct} different displacements; a mean law needs at "
            f"least {LEAST_ROWS} rows at 4"
        )
    most = max(1, min(_MOST_PIECES, sigma.size // _PER_PIECE, distinct // 2))
    count = min(pieces or 2, most)
    scale = _Scaled(sigma, load)
    fit, settled = scale.fit(count, free=free), bool(pieces)
    while not settled and 2 * count <= most:
        finer = scale.fit(2 * count, free=free)
        settled = _p_value(fit, finer, scale) >= BENT
        fit, count = finer, 2 * count
    curved = 1.0 if settled and not pieces else _p_value(fit, scale.fit(2 * count, free=free), scale)
    return scale.law(fit, curved)


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    knots: Array
    values: Array
    inverse: Array
    noise: Noise
    robust: Array
    scores: Array
    free: bool

    @property
    def parameters(self) -> int:
        return int(self.knots.size - (not self.free))


class _Scaled:
    """The points in units of their own size, where every number is of order one."""

    def __init__(self, sigma: Array, load: Array) -> None:
        self.units = float(np.abs(sigma).max()), float(np.abs(load).max()) or 1.0
        self.x, self.y = sigma / self.units[0], load / self.units[1]

    def fit(self, pieces: int, *, free: bool) -> _Fit:
        """Reweighted least squares: the noise from the residuals, large ones turned down and at last left out."""
        knots = _knots(self.x, pieces)
        index, share = _places(self.x, knots)
        weights, noise = np.ones_like(self.x), Noise(constant=1.0, proportional=0.0)
        robust = np.ones_like(self.x)
        values, inverse = np.zeros_like(knots), np.zeros((knots.size, knots.size))
        scores, previous = robust, values + 1
        for turn in range(_ROUNDS):
            values, inverse = _solve(index, share, weights * robust, self.y, knots, free)
            residuals = self.y - np.interp(self.x, knots, values)
            parameters = knots.size - (not free)
            noise = noise_of(residuals, np.interp(self.x, knots, values), parameters=parameters)
            weights = 1 / noise(np.interp(self.x, knots, values)) ** 2
            leverage = np.clip(weights * robust * _quadratic(inverse, index, share), 0, 0.9)
            scores = residuals * np.sqrt(weights / (1 - leverage))
            size = np.abs(scores)
            if turn < 4:
                robust = np.minimum(1.0, _HUBER / np.maximum(size, 1e-300))
            else:
                robust = np.maximum(1 - (size / _TUKEY) ** 2, 0.0) ** 2
            if turn > 4 and np.abs(values - previous).max() < 1e-9:
                break
            previous = values
        return self._final(_Fit(knots, values, inverse, noise, robust, scores, free))

    def _final(self, fit: _Fit) -> _Fit:
        """Plain weighted least squares through the points that are no outliers."""
        knots, noise = fit.knots, fit.noise
        index, share = _places(self.x, knots)
        scores, values, inverse = fit.scores, fit.values, fit.inverse
        kept = np.ones_like(self.x)
        for _ in range(3):
            kept = 1.0 - outlying(self.x, scores, parameters=fit.parameters)
            weights = 1 / noise(np.interp(self.x, knots, values)) ** 2
            values, inverse = _solve(index, share, weights * kept, self.y, knots, fit.free)
            residuals = (self.y - np.interp(self.x, knots, values)) * np.sqrt(weights)
            leverage = np.clip(weights * kept * _quadratic(inverse, index, share), 0, 0.9)
            degrees = max(1.0, kept.sum() - fit.parameters)
            scale = np.sqrt(np.sum(kept * residuals**2) / degrees)
            noise = Noise(constant=noise.constant * scale, proportional=noise.proportional * scale)
            inverse = inverse * scale**2
            scores = residuals / (scale * np.sqrt(np.where(kept > 0, 1 - leverage, 1 + leverage)))
        return _Fit(knots, values, inverse, noise, kept, scores, fit.free)

    def law(self, fit: _Fit, curved: float) -> MeanLaw:
        """The fit in the units of the points."""
        length, force = self.units
        noise = Noise(constant=fit.noise.constant * force, proportional=fit.noise.proportional)
        return MeanLaw(
            knots=fit.knots * length,
            values=fit.values * force,
            covariance=fit.inverse * force**2,
            degrees=int(fit.robust.sum()) - fit.parameters,
            noise=noise,
            scores=fit.scores,
            outliers=np.flatnonzero(fit.robust == 0),
            curved=curved,
        )


def _p_value(coarse: _Fit, fine: _Fit, scaled: _Scaled) -> float:
    """How likely noise alone makes the finer law fit as much better as it does (F test, outliers of either left out)."""
    from scipy.stats import f as fisher

    extra = fine.parameters - coarse.parameters
    kept = coarse.robust * fine.robust
    degrees = int(kept.sum()) - fine.parameters
    if extra <= 0 or degrees <= 0:
        return 1.0
    weights = kept / fine.noise(np.interp(scaled.x, fine.knots, fine.values)) ** 2
    sums = []
    for fit in (coarse, fine):
        index, share = _places(scaled.x, fit.knots)
        values, _ = _solve(index, share, weights, scaled.y, fit.knots, fit.free)
        sums.append(float(np.sum(weights * (scaled.y - np.interp(scaled.x, fit.knots, values)) ** 2)))
    if sums[1] <= 1e-24 * float(np.sum(weights * scaled.y**2)):
        return 1.0 if sums[0] <= 1e-24 * float(np.sum(weights * scaled.y**2)) else 0.0
    return float(fisher.sf((sums[0] - sums[1]) / extra / (sums[1] / degrees), extra, degrees))


def _knots(x: Array, pieces: int) -> Array:
    """Knots with about as many points on each piece: 0, and quantiles on either side of it."""
    knots = [np.zeros(1)]
    for side in (x[x < 0], x[x > 0]):
        if not np.unique(side).size:
            continue
        share = round(pieces * side.size / x.size)
        count = max(1, min(share, np.unique(side).size // 2, side.size // 3))
        places = np.quantile(side, np.arange(count + 1) / count)
        knots.append(places[1:] if side[0] > 0 else places[:-1])
    return _fused(np.unique(np.concatenate(knots)), x)


def _fused(knots: Array, x: Array) -> Array:
    """Knots without those that leave a piece with fewer than two different points."""
    values = np.unique(x)
    kept = list(knots)
    i = 0
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


def _places(x: Array, knots: Array) -> tuple[NDArray[np.intp], Array]:
    """The piece of each point, and how far along it the point lies."""
    index = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, knots.size - 2)
    return index, (x - knots[index]) / (knots[index + 1] - knots[index])


def _weights_at(x: Array, knots: Array) -> Array:
    index, share = _places(np.atleast_1d(x), knots)
    rows = np.zeros((index.size, knots.size))
    rows[np.arange(index.size), index], rows[np.arange(index.size), index + 1] = 1 - share, share
    return rows


def _quadratic(matrix: Array, index: NDArray[np.intp], share: Array) -> Array:
    """The quadratic form of the matrix at the weights of each point."""
    a, b = 1 - share, share
    return a**2 * matrix[index, index] + 2 * a * b * matrix[index, index + 1] + b**2 * matrix[index + 1, index + 1]


def _solve(
    index: NDArray[np.intp], share: Array, weights: Array, y: Array, knots: Array, free: bool
) -> tuple[Array, Array]:
    """Values at the knots and the inverse of the normal matrix; the value at 0 is 0 unless it is free."""
    size, a, b = knots.size, 1 - share, share
    normal = np.zeros((size, size))
    np.add.at(normal, (index, index), weights * a**2)
    np.add.at(normal, (index + 1, index + 1), weights * b**2)
    np.add.at(normal, (index, index + 1), weights * a * b)
    normal += np.triu(normal, 1).T
    right = np.bincount(index, weights * a * y, size) + np.bincount(index + 1, weights * b * y, size)
    open_ = np.flatnonzero(knots) if not free else np.arange(size)
    inverse = np.zeros((size, size))
    inverse[np.ix_(open_, open_)] = np.linalg.pinv(normal[np.ix_(open_, open_)], rcond=1e-13, hermitian=True)
    return inverse @ right, inverse
