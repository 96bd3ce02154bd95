r"""The mean law as a continuous function, affine between knots, with ``f(0) = 0``: fitted, with its covariance.

Near ``sigma = 0`` no measured load is divided by a small displacement: on the pieces beside 0 the ratio ``f/sigma`` is
the slope of the piece, which all of its points determine together.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import ParamSpec, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.measured.hats import HatFit, Hats, hat_fit, misfit, places
from analysis.measured.knots import spread_knots
from analysis.measured.noise import Noise
from lure.errors import InputError
from lure.values import by_value

Array = NDArray[np.float64]
LEAST_ROWS = 12
_PER_PIECE = 6
_MOST_PIECES = 64
BENT = 0.05
P = ParamSpec("P")
R = TypeVar("R")


def one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """The function with linear algebra on one thread: matrices here are small, and threads cost more than they save.

    Parameters
    ----------
    function : callable
        What is called.
    """

    @wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> R:
        from threadpoolctl import threadpool_limits

        with threadpool_limits(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return limited


@by_value
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
        """(K,) the change of slope to the next piece on either side, but not across 0, where laws may have a corner."""
        change = np.where(self.knots[1:-1] == 0, 0.0, np.abs(np.diff(self.slopes() @ self.values)))
        return np.asarray(np.maximum(np.append(change, 0.0), np.insert(change, 0, 0.0)))

    def missed(self, sigma: ArrayLike) -> Array:
        """About how far from the law a curve may run between its knots [unit of the load], elementwise."""
        index, _ = places(np.asarray(sigma, dtype=float), self.knots)
        return np.asarray(0.25 * (self.bends() * np.diff(self.knots))[index])

    @property
    def sides(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """The pieces below 0 and those above: a law may have a corner at 0."""
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
            (e,) how far they may be off for a smooth law [unit of the load / m]: for pieces of widths ``a`` and ``b``
            and a parabola of slopes with second derivative ``q``, extrapolation leaves out ``q a (a + b)/6``.
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
    units = float(np.abs(sigma).max()), float(np.abs(load).max()) or 1.0
    x, y = sigma / units[0], load / units[1]

    def fitted(count: int) -> HatFit:
        """The fit with so many pieces."""
        return hat_fit(Hats(x=x, y=y, knots=spread_knots(x, count), free=free))

    most = max(1, min(_MOST_PIECES, sigma.size // _PER_PIECE, distinct // 2))
    count = min(pieces or 2, most)
    fit, settled = fitted(count), bool(pieces)
    while not settled and 2 * count <= most:
        finer = fitted(2 * count)
        settled = misfit(fit.hats, finer) >= BENT
        fit, count = finer, 2 * count
    curved = 1.0 if settled and not pieces else misfit(fit.hats, fitted(2 * count))
    return _in_units(fit, units, curved)


def _in_units(fit: HatFit, units: tuple[float, float], curved: float) -> MeanLaw:
    """The fit in the units of the points."""
    length, force = units
    return MeanLaw(
        knots=fit.hats.knots * length,
        values=fit.values * force,
        covariance=fit.covariance * force**2,
        degrees=int(fit.kept.sum()) - fit.hats.parameters,
        noise=Noise(constant=fit.noise.constant * force, proportional=fit.noise.proportional),
        scores=fit.scores,
        outliers=np.flatnonzero(~fit.kept),
        curved=curved,
    )
