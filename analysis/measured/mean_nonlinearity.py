r"""The mean nonlinearity, continuous and affine between knots, with ``f(0) = 0``: fitted, with its covariance.

Near ``sigma = 0`` no measured load is divided by a small displacement: on the pieces beside 0 the ratio ``f/sigma`` is
the slope of the piece, which all of its points determine together.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import InputError
from lure.record import Record, described, quantity

# How much one reading scatters: a constant part and a part in proportion to the load.

Array = NDArray[np.float64]
_TO_DEVIATION = 1.4826022185056018  # of a median absolute value, for normal errors
_SCALE = 1.2533141373155001  # of a mean absolute value, likewise: sqrt(pi/2)
_FLOOR = 0.05
_ROUNDS = 4
_LEAST, _LEAST_SCALE = 1e-100, 1e-3  # of noise, so that its square is no 0 where the loads do not scatter at all


class Noise(Record):
    """Standard deviation ``constant + proportional |f|`` of a reading about the mean nonlinearity ``f``."""

    constant: float = quantity("The part that every reading has", "unit of the load")
    proportional: float = quantity("The part in proportion to the load", "1")

    def __call__(self, mean: Array) -> Array:
        """Standard deviation [unit of the load] where the nonlinearity has the value ``mean``, elementwise."""
        return np.asarray(self.constant + self.proportional * np.abs(mean))


def noise_of(residuals: Array, mean: Array, *, parameters: int) -> Noise:
    """The noise behind residuals, little moved by outliers.

    The two parts are fitted to the absolute residuals, of which those beyond three deviations are cut down to three.
    The constant part is at least 5 % of the whole, so that no reading counts as exact.

    ``residuals``, ``mean``: (n,) residuals and the nonlinearity they are about [unit of the load]; ``parameters``: how
    many were fitted: residuals are smaller than errors by the square root of ``1 - parameters/n``.
    """
    from scipy.optimize import nnls

    lost = np.sqrt(residuals.size / max(residuals.size - parameters, 1))
    size = np.abs(residuals) * lost
    typical = max(
        _TO_DEVIATION * float(np.median(size)), 1e-14 * float(np.abs(mean).max()), 1e-14 * float(size.max()), _LEAST
    )
    level = np.abs(mean)
    deviation = np.full_like(size, typical)
    constant, proportional = typical, 0.0
    for _ in range(_ROUNDS):
        cut = np.minimum(_SCALE * size, 3 * deviation) / deviation
        constant, proportional = nnls(np.column_stack([1 / deviation, level / deviation]), cut)[0]
        floor = _FLOOR * (constant + proportional * float(np.mean(level)))
        constant = max(constant, floor, 1e-3 * typical)
        deviation = constant + proportional * level
    return Noise(constant=float(constant), proportional=float(proportional))


# Readings that stand out from the nonlinearity and from their neighbours.

_FLAGGED = 0.01
_NEIGHBOURS = 3
_SHARED = 1 / 3
_FEW, _SOME = 3, 0.05


def outlying(x: Array, scores: Array, *, parameters: int) -> NDArray[np.bool_]:
    """Whether each reading is so far off that one clean set in a hundred has such a one.

    A run of readings that are off together shows that the nonlinearity has another shape there, as at a sudden onset or
    drop of the load, and none of them is an outlier: the three neighbours on either side must not be off as well, and
    none of the readings next to it, in displacement or in time, may share a third of its distance. Where more than one
    reading in twenty stands out, the errors have another distribution, and none is an outlier.

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


# Where the pieces of a fitted nonlinearity end: at 0, and at quantiles of the displacements.


def spread_knots(x: Array, pieces: int) -> Array:
    """Knots with about as many points on each piece: 0, and quantiles on either side of it.

    ``x``: (n,) displacements; ``pieces``: about how many.
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


# Continuous functions that are affine between knots, fitted by reweighted least squares without outliers.

_TUKEY, _HUBER = 4.685, 1.345
_HUBER_ROUNDS, _HATS_ROUNDS = 3, 12


@described(frozen=True, kw_only=True, eq=False)  # without slots, for the cached property
class Hats:
    """Points and knots: the value of the function at a point is a mean of its values at two knots."""

    x: Array = quantity("(n,) points, of order one")
    y: Array = quantity("(n,) values there, of order one")
    knots: Array = quantity("(K + 1,) ascending, 0 among them")
    free: bool = quantity("Whether the value at the knot 0 is fitted, instead of being 0")

    @cached_property
    def places(self) -> tuple[NDArray[np.intp], Array]:
        """The piece of each point, and how far along it the point lies."""
        return places(self.x, self.knots)

    @property
    def parameters(self) -> int:
        """How many values are fitted."""
        return int(self.knots.size - (not self.free))

    def solved(self, weights: Array) -> tuple[Array, Array]:
        """Values at the knots by weighted least squares, and the inverse of the normal matrix."""
        (index, share), size = self.places, self.knots.size
        a, b = 1 - share, share
        diagonal = np.bincount(index, weights * a**2, size) + np.bincount(index + 1, weights * b**2, size)
        beside = np.bincount(index, weights * a * b, size)[:-1]
        normal = np.diag(diagonal) + np.diag(beside, 1) + np.diag(beside, -1)
        right = np.bincount(index, weights * a * self.y, size) + np.bincount(index + 1, weights * b * self.y, size)
        fitted = np.arange(size) if self.free else np.flatnonzero(self.knots)
        inverse = np.zeros((size, size))
        inverse[np.ix_(fitted, fitted)] = np.linalg.pinv(normal[np.ix_(fitted, fitted)], rcond=1e-13, hermitian=True)
        return inverse @ right, inverse

    def leverages(self, inverse: Array, weights: Array) -> Array:
        """How much of its own value each point determines."""
        index, share = self.places
        a, b = 1 - share, share
        quadratic = a**2 * inverse[index, index] + 2 * a * b * inverse[index, index + 1]
        return np.asarray(np.clip(weights * (quadratic + b**2 * inverse[index + 1, index + 1]), 0, 0.9))

    def at(self, values: Array) -> Array:
        """The function at the points."""
        index, share = self.places
        return np.asarray(values[index] + share * np.diff(values)[index])


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class HatFit:
    """A fit: values at the knots, their covariance, the noise, which points were kept, and residuals in deviations."""

    hats: Hats
    values: Array
    covariance: Array
    noise: Noise
    kept: NDArray[np.bool_]
    scores: Array

    @property
    def weights(self) -> Array:
        """One over the variance of each point, 0 for outliers."""
        return np.asarray(self.kept / self.noise(self.hats.at(self.values)) ** 2)


def hat_fit(hats: Hats) -> HatFit:
    """Least squares with weights from the residuals: large ones are turned down, and outliers at last left out.

    ``hats``: points and knots.
    """
    weights, robust = np.ones_like(hats.x), np.ones_like(hats.x)
    values, noise, scores = np.zeros_like(hats.knots), Noise(constant=1.0, proportional=0.0), robust
    for turn in range(_HATS_ROUNDS):
        previous = values
        values, inverse = hats.solved(weights * robust)
        mean = hats.at(values)
        noise = noise_of(hats.y - mean, mean, parameters=hats.parameters)
        weights = 1 / noise(mean) ** 2
        scores = (hats.y - mean) * np.sqrt(weights / (1 - hats.leverages(inverse, weights * robust)))
        size = np.abs(scores)
        if turn < _HUBER_ROUNDS:
            robust = np.minimum(1.0, _HUBER / np.maximum(size, 1e-300))
        else:
            robust = np.maximum(1 - (size / _TUKEY) ** 2, 0.0) ** 2
        if turn > _HUBER_ROUNDS and np.abs(values - previous).max() < 1e-6:
            break
    return _final(hats, values, noise, scores)


def _final(hats: Hats, values: Array, noise: Noise, scores: Array) -> HatFit:
    """Plain weighted least squares through the points that are no outliers."""
    covariance, kept = np.zeros((values.size, values.size)), np.ones(hats.x.size, dtype=np.bool_)
    for _ in range(3):
        kept = ~outlying(hats.x, scores, parameters=hats.parameters)
        weights = 1 / noise(hats.at(values)) ** 2
        values, inverse = hats.solved(weights * kept)
        residuals = (hats.y - hats.at(values)) * np.sqrt(weights)
        degrees = max(1, int(kept.sum()) - hats.parameters)
        scale = max(float(np.sqrt(np.sum(kept * residuals**2) / degrees)), _LEAST_SCALE)
        noise = Noise(constant=noise.constant * scale, proportional=noise.proportional * scale)
        covariance = inverse * scale**2
        leverages = hats.leverages(inverse, weights * kept)
        scores = residuals / (scale * np.sqrt(np.where(kept, 1 - leverages, 1 + leverages)))
    return HatFit(hats=hats, values=values, covariance=covariance, noise=noise, kept=kept, scores=scores)


def dependent(fit: HatFit) -> float:
    """How many times the variance of a mean is that of independent errors if they are a first-order autoregression."""
    scores = fit.scores[fit.kept]
    found = float(np.sum(scores[1:] * scores[:-1]) / max(np.sum(scores**2), _LEAST))
    return (1 + min(max(found, 0.0), 0.99)) / (1 - min(max(found, 0.0), 0.99))


def misfit(coarse: Hats, fine: HatFit, times: float = 1.0) -> float:
    """p-value: how likely noise alone makes the finer function fit as much better than the coarser as it does.

    ``coarse``: fewer knots; ``fine``: the fit with more, whose noise and outliers are taken for both; ``times``: how
    much of this errors make that depend on one another, for each that independent ones make.
    """
    from scipy.stats import f as fisher

    extra = fine.hats.parameters - coarse.parameters
    weights = fine.weights
    degrees = int(fine.kept.sum()) - fine.hats.parameters
    if extra <= 0 or degrees <= 0:
        return 1.0
    before, after = (
        float(np.sum(weights * (hats.y - hats.at(hats.solved(weights)[0])) ** 2)) for hats in (coarse, fine.hats)
    )
    rounding = 1e-24 * float(np.sum(weights * coarse.y**2))
    if after <= rounding:
        return 1.0 if before <= rounding else 0.0
    return float(fisher.sf(max(before - after, 0.0) / extra / (after / degrees) / times, extra, degrees))


_USUAL, _JUMPS = 0.75, 2  # the quantile of differences that is taken for noise, and how many must be beyond it
_CREDIBLE = 2.0  # times that noise


def jumping(fit: HatFit) -> float:
    """p-value, with something to spare: how likely noise alone has residuals that jump from one row to the next so far.

    Noise makes the largest differences of neighbours, in the order of displacement, a few times as large as usual ones.
    A quantiser or a relay makes few that are much larger, whatever pieces are fitted.  Two are needed, since a single
    one may be chance.

    ``fit``: of which the outliers are left out.
    """
    from scipy.stats import norm

    order = np.argsort(fit.hats.x, kind="stable")
    steps = np.sort(np.abs(np.diff(fit.scores[order][fit.kept[order]])))
    usual = float(np.quantile(steps, _USUAL)) / float(norm.isf((1 - _USUAL) / 2))
    far = float(steps[-_JUMPS]) / (_CREDIBLE * max(usual, _LEAST))
    return min(1.0, 2 * steps.size * float(norm.sf(far)))


def places(x: Array, knots: Array) -> tuple[NDArray[np.intp], Array]:
    """The piece of each point, and how far along it the point lies; the outer pieces reach on.

    ``x``, ``knots``: points, and ascending knots.
    """
    index = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, knots.size - 2)
    return index, np.asarray((x - knots[index]) / (knots[index + 1] - knots[index]))


LEAST_ROWS = 12
_PER_PIECE = 6
_MOST_PIECES = 64
BENT = 0.05
_TWOFOLD, _ENOUGH = 1.4, 24  # a kurtosis, and of how many rows
_BENT_FARTHER = 1e-3  # of the most pieces, which are looked at in addition


@described(frozen=True, kw_only=True, slots=True, eq=False)
class MeanNonlinearity:
    """The fitted mean nonlinearity."""

    knots: Array = quantity("(K + 1,) places, 0 among them", "m")
    values: Array = quantity("(K + 1,) values there", "unit of the load")
    covariance: Array = quantity(
        "(K + 1, K + 1) of the values, already scaled; the row and column of the knot 0 vanish unless it was free"
    )
    degrees: int = quantity("Rows less parameters, outliers left out")
    noise: Noise = quantity("Standard deviation of one reading")
    scores: Array = quantity("(n,) residuals in standard deviations of a residual, in the order of the rows")
    outliers: NDArray[np.intp] = quantity("Rows left out")
    curved: float = quantity(
        "p-value of the tests that twice as many pieces fit no better, and that neighbours do not differ as at jumps; "
        "small means that the class is contradicted"
    )
    sparse: bool = quantity(
        "Whether the rows, or their displacements, are too few for that test to see a nonlinearity bend"
    )

    @property
    def resolved(self) -> bool:
        """Whether there are rows enough to see it bend within its pieces, and it does not."""
        return not self.sparse and self.curved >= BENT

    @property
    def twofold(self) -> bool:
        """Whether the residuals lie in two groups, as those of a loop whose rows were sorted: of a kurtosis near 1.

        Of normal errors it is 3, of rounded loads 1.8.
        """
        kept = np.delete(self.scores, self.outliers)
        return kept.size >= _ENOUGH and float(np.mean(kept**4)) < _TWOFOLD * float(np.mean(kept**2)) ** 2

    def __call__(self, sigma: ArrayLike) -> Array:
        """The load [unit of the load] at ``sigma`` [m], elementwise; only between the first knot and the last."""
        return np.asarray(np.interp(np.asarray(sigma, dtype=float), self.knots, self.values))

    def error(self, sigma: ArrayLike) -> Array:
        """Standard error of the nonlinearity [unit of the load], elementwise."""
        index, share = places(np.atleast_1d(np.asarray(sigma, dtype=float)), self.knots)
        a, b, c = 1 - share, share, self.covariance
        found = a**2 * c[index, index] + 2 * a * b * c[index, index + 1] + b**2 * c[index + 1, index + 1]
        return np.asarray(np.sqrt(np.maximum(found, 0.0)))

    def slopes(self) -> Array:
        """(K, K + 1) the slope on each piece as a combination of the values."""
        widths = np.diff(self.knots)
        pieces = np.zeros((widths.size, self.knots.size))
        index = np.arange(widths.size)
        pieces[index, index], pieces[index, index + 1] = -1 / widths, 1 / widths
        return pieces

    def bends(self) -> Array:
        """(K,) the change of slope to the next piece on either side, but not across 0, where a corner is allowed."""
        change = np.where(self.knots[1:-1] == 0, 0.0, np.abs(np.diff(self.slopes() @ self.values)))
        return np.asarray(np.maximum(np.append(change, 0.0), np.insert(change, 0, 0.0)))

    def missed(self, sigma: ArrayLike) -> Array:
        """About how far from the nonlinearity a curve may run between its knots [unit of the load], elementwise."""
        index, _ = places(np.asarray(sigma, dtype=float), self.knots)
        return np.asarray(0.25 * (self.bends() * np.diff(self.knots))[index])

    @property
    def sides(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """The pieces below 0 and those above: a nonlinearity may have a corner at 0."""
        return np.flatnonzero(self.knots[1:] <= 0), np.flatnonzero(self.knots[:-1] >= 0)

    def bow(self) -> Array:
        """(K,) second difference of the slopes at each piece, about the third derivative times the width squared.

        From the three nearest pieces on its side of 0; 0 where there are fewer.
        """
        slopes, widths = self.slopes() @ self.values, np.diff(self.knots)
        middles = 0.5 * (self.knots[1:] + self.knots[:-1])
        found = np.zeros(widths.size)
        for side in self.sides:
            if side.size > 2:
                x = middles[side]
                second = 2 * np.diff(np.diff(slopes[side]) / np.diff(x)) / (x[2:] - x[:-2])
                found[side] = np.abs(np.concatenate([second[:1], second, second[-1:]])) * widths[side] ** 2
        return found

    def end_slopes(self) -> tuple[Array, Array, Array]:
        """Slopes at the two ends and on either side of 0.

        Extrapolated from two pieces where these differ by two errors; where not, the difference may be missed.

        Returns
        -------
        combinations : ndarray
            (e, K + 1) the slopes as combinations of the values.
        missed : ndarray
            (e,) how far they may be off for a smooth nonlinearity [unit of the load / m]: for pieces of widths ``a``
            and ``b`` and a parabola of slopes with second derivative ``q``, extrapolation leaves out ``q a (a + b)/6``.
        at : ndarray
            (e,) where [m].
        """
        slopes, widths, bow = self.slopes(), np.diff(self.knots), self.bow()
        found, missed, at = [], [], []
        for side in self.sides:
            for last, before in ((side[0], side[1]), (side[-1], side[-2])) if side.size > 1 else ():
                reach = widths[last] / (widths[last] + widths[before])
                change = reach * (slopes[last] - slopes[before])
                seen = abs(change @ self.values) > 2 * np.sqrt(max(change @ self.covariance @ change, 0.0))
                found.append(slopes[last] + change if seen else slopes[last])
                missed.append(bow[last] / (6 * reach) + (0.0 if seen else abs(change @ self.values)))
                at.append(self.knots[last if last < before else last + 1])
        return np.array(found).reshape(-1, self.knots.size), np.array(missed), np.array(at)

    def chords(self) -> Array:
        """(K, K + 1) the chord ``f/sigma`` at each knot but 0, as a combination of the values."""
        away = np.flatnonzero(self.knots)
        chords = np.zeros((away.size, self.knots.size))
        chords[np.arange(away.size), away] = 1 / self.knots[away]
        return chords


def mean_nonlinearity(sigma: Array, load: Array, *, pieces: int | None = None, free: bool = False) -> MeanNonlinearity:
    """The mean nonlinearity through measured points, by weighted least squares without outliers.

    The number of pieces is doubled until a test at the level 5 % sees nothing in the last doubling, and one at the
    level 0.1 % nothing in as many pieces as the rows allow: what the pieces leave out is then small beside the noise.
    Steps that are narrower than all pieces are seen by their jumps.

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
            f"the measurements have {sigma.size} rows and {distinct} different displacements; a mean nonlinearity "
            f"needs at "
            f"least {LEAST_ROWS} rows at 4"
        )
    units = float(np.abs(sigma).max()), float(np.abs(load).max()) or 1.0
    x, y = sigma / units[0], load / units[1]

    def fitted(count: int) -> HatFit:
        """The fit with so many pieces."""
        return hat_fit(Hats(x=x, y=y, knots=spread_knots(x, count), free=free))

    most = max(1, min(_MOST_PIECES, sigma.size // _PER_PIECE, distinct // 2))
    count = min(pieces or 2, most)
    fit, settled = fitted(count), bool(pieces)
    finest = fit if settled else fitted(count << int(np.log2(most / count)))
    while not settled and 2 * count <= most:
        finer = fitted(2 * count)
        settled = misfit(fit.hats, finer) >= BENT and misfit(fit.hats, finest, dependent(fit)) >= _BENT_FARTHER
        fit, count = finer, 2 * count
    curved = 1.0 if settled and not pieces else misfit(fit.hats, fitted(2 * count))
    return _in_units(fit, units, min(curved, jumping(fit)), sparse=most < 4)


def _in_units(fit: HatFit, units: tuple[float, float], curved: float, *, sparse: bool) -> MeanNonlinearity:
    """The fit in the units of the points."""
    length, force = units
    return MeanNonlinearity(
        knots=fit.hats.knots * length,
        values=fit.values * force,
        covariance=fit.covariance * force**2,
        degrees=int(fit.kept.sum()) - fit.hats.parameters,
        noise=Noise(constant=fit.noise.constant * force, proportional=fit.noise.proportional),
        scores=fit.scores,
        outliers=np.flatnonzero(~fit.kept),
        curved=curved,
        sparse=sparse,
    )
