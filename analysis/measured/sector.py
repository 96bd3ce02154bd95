"""The smallest sector and slope bounds of the mean nonlinearity behind measurements, with stated confidence."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lure.analysis.measured.mean_nonlinearity import BENT, LEAST_ROWS, MeanNonlinearity, mean_nonlinearity
from lure.analysis.measured.measured_sector import Bound, Hysteresis, MeasuredSector, Outlier
from lure.analysis.measured.reading import Branch, Direction, Measurements
from lure.arrays import one_thread
from lure.errors import InputError
from lure.record import described, quantity

# Whether the load depends on the direction of travel, decided from the branches themselves.
#
# Each branch is compared with the one before it at equal displacements.  What is asked of the difference is whether it
# has one sign on loading against unloading, an area, and whether it comes back cycle after cycle.

# Whether loading and unloading follow one nonlinearity, and what correlated errors do to such questions.

Array = NDArray[np.float64]
_DIRECTIONS: tuple[Direction, Direction] = ("loading", "unloading")
_PLACES = 65
_CORRELATED = 2.6
_ROUNDING = 1e-12


def branch_rows(measurements: Measurements) -> list[NDArray[np.intp]]:
    """The rows on loading and those on unloading, if both have enough for a mean nonlinearity; else an empty list.

    ``measurements``: what is cut.
    """
    rows = [measurements.rows(direction) for direction in _DIRECTIONS]
    enough = all(part.size >= LEAST_ROWS and np.unique(measurements.displacement[part]).size >= 4 for part in rows)
    return rows if enough else []


def hysteresis_from_data(measurements: Measurements) -> Hysteresis | None:
    """The loop between loading and unloading; None where there is none to be seen, or there are no two branches.

    Whether there is one is decided by ``has_loop``; its size is that between the mean nonlinearities
    of the two directions.

    Parameters
    ----------
    measurements : Measurements
        In the order of recording.
    """
    rows = branch_rows(measurements)
    if not rows or not has_loop(measurements):
        return None
    origin = 0.5 * float(measurements.displacement.min() + measurements.displacement.max())
    nonlinearities = [
        mean_nonlinearity(measurements.displacement[r] - origin, measurements.load[r], free=True) for r in rows
    ]
    places = np.linspace(
        max(nonlinearity.knots[0] for nonlinearity in nonlinearities),
        min(nonlinearity.knots[-1] for nonlinearity in nonlinearities),
        _PLACES,
    )
    apart = nonlinearities[0](places) - nonlinearities[1](places)
    i = int(np.argmax(np.abs(apart)))
    return Hysteresis(
        width=float(abs(apart[i])),
        at=float(places[i]) + origin,
        share=float(abs(apart[i])) / float(max(np.abs(nonlinearity.values).max() for nonlinearity in nonlinearities)),
        dissipated=float(np.trapezoid(apart, places)),
        rows=(rows[0].size, rows[1].size),
        branches=len(measurements.branches),
    )


def correlation_of(nonlinearity: MeanNonlinearity) -> float:
    """Correlation of the errors of neighbouring rows; 0 where it is no more than chance, or errors are rounding.

    ``nonlinearity``: with the residuals in the order of recording.
    """
    scores = np.delete(nonlinearity.scores, nonlinearity.outliers)
    exact = float(nonlinearity.noise(nonlinearity.values).max()) < _ROUNDING * float(np.abs(nonlinearity.values).max())
    if exact or not scores.any():
        return 0.0
    found = float(np.sum(scores[1:] * scores[:-1]) / np.sum(scores**2))
    return min(found, 0.99) if found * math.sqrt(scores.size) > _CORRELATED else 0.0


def widening(nonlinearity: MeanNonlinearity) -> float:
    """By how much errors that form a first-order autoregressive sequence widen an interval; 1 if they look independent.

    ``nonlinearity``: with the residuals in the order of recording.
    """
    correlation = correlation_of(nonlinearity)
    return math.sqrt((1 + correlation) / (1 - correlation))


_POINTS = 1000  # a branch is compared on at most
_LEAST, _ENOUGH = 4, 8  # readings in common: for an area, and for a noise to be known
_REPEATED = 6  # comparisons that can show repetition
_SHARE = 0.75  # of what one reading leaves unsure
_RARE = 0.002
_FAR = 5.0  # standard errors
_CREDIBLE, _CAUTIOUS = 0.5, 1.5  # standard errors of the correlation: with few branches, and where repetition decides
_STRIDES = (1, 2, 4, 8, 16)
_SCATTER = 2.0  # of the logarithm of a variance of second differences, times the root of the rows
_MOST, _OF_MOST = 0.8, 0.4377  # the mean of the smaller 80 % of squares of normal numbers of variance one
_CORRELATIONS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.94, 0.97, 0.985, 0.995)


@described(frozen=True, slots=True)
class Pair:
    """Loading less unloading of two neighbouring branches, along the displacements that both have."""

    apart: Array = quantity(
        "(n,) load on loading less load on unloading [unit of the load], at the readings of the shorter branch and "
        "ordered from the turn between the two"
    )
    mean: float = quantity("The mean over the readings of both branches, so that errors of interpolation cancel")
    unsure: float = quantity(
        "How far a reading typically lies from the line between its neighbours [unit of the load], by noise and "
        "curvature; at least the last digit of the load"
    )


def has_loop(measurements: Measurements) -> bool:
    """Whether loading and unloading follow different nonlinearities.

    Differences that noise or curvature make between two readings are no loop, nor is a jump.  Else a loop is seen by
    one of two tests:

    - The areas between neighbouring branches repeat: of six or more, the mean is further from 0 than their scatter
      explains (level 0.2 %).  Nothing is assumed of the noise within a branch.
    - The mean difference along a branch, or along one half of it, is five standard errors from 0.  These are
      those of errors that form a first-order autoregressive sequence, whose variance and correlation are read off
      second differences of the difference itself: a loop has few corners and else none, and is not taken for noise.

    In simulations (``tests/measured/test_measured_loops.py``) at least 99 % of the loops with a mean width of three
    deviations of the noise and 40 readings in common were seen, and of the elements without memory at most 1 % were
    taken for a loop with errors that are independent or correlated by up to 0.6 from row to row, 5 % with 0.8, and 15 %
    with 0.95: errors correlated over a whole branch and a loop measured once cannot be told apart.

    ``measurements``: in the order of recording.
    """
    pairs = pairs_of(measurements)
    return bool(pairs) and (_repeats(pairs) or _beyond_noise(pairs))


def pairs_of(measurements: Measurements) -> list[Pair]:
    """Neighbouring branches compared, those with at least four displacements in common.

    ``measurements``: in the order of recording.
    """
    branches = measurements.branches
    curves = [_curve(measurements, branch) for branch in branches]
    distinct = np.unique(measurements.load)
    resolved = float(np.diff(distinct).min(initial=np.inf))
    found = [
        _pair(a, b, resolved, up=branch.direction == "loading")
        for a, b, branch in zip(curves[:-1], curves[1:], branches, strict=False)
    ]
    return [pair for pair in found if pair is not None]


def _curve(measurements: Measurements, branch: Branch) -> tuple[Array, Array]:
    """A branch as ascending displacements with their loads, long ones as means of neighbouring readings."""
    u, p = (values[branch.start : branch.stop] for values in (measurements.displacement, measurements.load))
    block = -(-u.size // _POINTS)
    starts = np.arange(0, u.size, block)
    counts = np.diff(np.append(starts, u.size))
    u, p = np.add.reduceat(u, starts) / counts, np.add.reduceat(p, starts) / counts
    places, index, counts = np.unique(u, return_inverse=True, return_counts=True)
    return places, np.bincount(index, p) / counts


def _pair(first: tuple[Array, Array], second: tuple[Array, Array], resolved: float, *, up: bool) -> Pair | None:
    """The first branch less the second, or the reverse where the first is unloading; loads are digits of some size."""
    low, high = max(first[0][0], second[0][0]), min(first[0][-1], second[0][-1])
    inside = [(u >= low) & (u <= high) for u, _ in (first, second)]
    if min(int(part.sum()) for part in inside) < _LEAST:
        return None
    sign = 1.0 if up else -1.0
    apart = [
        sign * (p[part] - np.interp(u[part], *other))
        for (u, p), part, other in ((first, inside[0], second), (second, inside[1], first))
    ]
    apart[1] = -apart[1]
    unsure = [_unsure(u[part], p[part]) for (u, p), part in ((first, inside[0]), (second, inside[1]))]
    shorter = 0 if apart[0].size <= apart[1].size else 1
    return Pair(
        apart=apart[shorter][:: -1 if up else 1],
        mean=0.5 * float(_smoothed(apart[0]).mean() + _smoothed(apart[1]).mean()),
        unsure=max(*unsure, resolved),
    )


def _unsure(u: Array, p: Array) -> float:
    """Mean distance of a reading from the line between its neighbours."""
    share = (u[1:-1] - u[:-2]) / (u[2:] - u[:-2])
    return float(np.median(np.abs(p[1:-1] - (1 - share) * p[:-2] - share * p[2:])))


def _smoothed(values: Array) -> Array:
    """Running medians of seven: a jump between two readings moves up to three differences, a loop more."""
    from scipy.ndimage import median_filter

    return np.asarray(median_filter(values, 7, mode="mirror"))


def _repeats(pairs: list[Pair]) -> bool:
    """Whether the mean differences of neighbouring branches have one sign beyond their scatter.

    Neighbouring differences share a branch, so that independent branches correlate them by one half: the variance of
    their mean is then twice that of independent ones, and they count for two thirds as many.
    """
    from scipy.stats import t as student

    if len(pairs) < _REPEATED:
        return False
    means = np.array([pair.mean for pair in pairs])
    centre = float(means.mean())
    if abs(centre) <= _SHARE * float(np.median([pair.unsure for pair in pairs])):
        return False
    error = math.sqrt(2 / means.size) * float(means.std(ddof=1))
    return abs(centre) > float(student.isf(_RARE / 2, (means.size - 1) / 1.5)) * error


def _beyond_noise(pairs: list[Pair]) -> bool:
    """Whether a difference along the branches has an area that first-order autoregressive errors do not make."""
    means = [pair.mean for pair in pairs]
    some = []
    for i, pair in enumerate(pairs):
        beside = means[max(i - 1, 0) : i] + means[i + 1 : i + 2]
        # a drift of the load changes its sign at each turn
        drifts = bool(beside) and all(mean * pair.mean < -(pair.mean**2) / 3 for mean in beside)
        wide = float(np.abs(_smoothed(pair.apart)).mean()) > _SHARE * pair.unsure
        if wide and not drifts and pair.apart.size >= _ENOUGH:
            some.append(pair)
    return bool(some) and _largest(pairs, some) > _FAR


def _largest(pairs: list[Pair], some: list[Pair]) -> float:
    """The largest mean difference of some pairs in standard errors, of those of its two halves too."""
    innovation, correlation = _errors(pairs)
    found = 0.0
    for pair in some:
        smooth = _smoothed(pair.apart)
        half, rows = pair.apart.size // 2, pair.apart.size
        for start, stop in ((0, rows), (0, half), (half, rows)):
            spread = _spread(start, stop, correlation) * innovation
            found = max(found, abs(float(smooth[start:stop].mean())) / max(spread, 1e-300))
    return found


def _spread(start: int, stop: int, correlation: float) -> float:
    """Standard deviation of the mean of rows of a sequence with innovations of deviation 1, counted from the turn.

    At the turn both branches have one error, and the sequence begins at 0: no mean varies more than a random walk's.
    """
    rows = stop - start
    walk = start + rows / 3
    if correlation == 1:
        return math.sqrt(walk)
    lags = np.arange(1, rows)
    total = rows + 2 * float(((rows - lags) * correlation**lags).sum())
    return math.sqrt(min(total / (1 - correlation**2) / rows**2, walk))


def _errors(pairs: list[Pair]) -> tuple[float, float]:
    """Innovation and the largest credible correlation of the errors of a difference, from second differences.

    Second differences over s rows see no slope, and few of them a corner, which medians forgive; of an autoregressive
    sequence with variance v they have the variance ``2 v (1 - r^s) (3 - r^s)``.
    """
    rows = sum(pair.apart.size for pair in pairs)
    longest = max(pair.apart.size for pair in pairs)
    strides = [s for s in _STRIDES if s == 1 or 12 * s <= longest]
    logs = np.array([math.log(max(_second(pairs, s), 1e-300)) for s in strides])
    r = np.array(_CORRELATIONS)[:, None] ** np.array(strides)
    model = np.log((1 - r) * (3 - r))
    sure = rows / (_SCATTER**2 * np.array(strides))
    rest = logs - model
    level = (rest * sure).sum(axis=1) / sure.sum()
    misfit = ((rest - level[:, None]) ** 2 * sure).sum(axis=1)
    i = int(np.flatnonzero(misfit <= misfit.min() + (_CREDIBLE if len(pairs) < _REPEATED else _CAUTIOUS) ** 2)[-1])
    correlation = _CORRELATIONS[i]
    variance = math.exp(level[i]) / 2
    last = correlation == _CORRELATIONS[-1]
    return math.sqrt(variance * (1 - correlation**2)), 1.0 if last else correlation


def _second(pairs: list[Pair], stride: int) -> float:
    """Variance of the second differences over so many rows, by their median."""
    found = [
        np.abs(y[: -2 * stride] - 2 * y[stride:-stride] + y[2 * stride :])
        for y in (pair.apart for pair in pairs)
        if y.size > 2 * stride
    ]
    size = np.sort(np.concatenate(found)) ** 2
    return max(float(size[: max(1, round(_MOST * size.size))].mean()) / _OF_MOST, 0.01 * float(size.mean()))


_DRAWS = 8_000
_FARTHEST = 1e100
_SEED = 20_000
_SURE = 0.999
_POORLY = 3.0  # times what an end may miss, where pieces are too few for the nonlinearity
_CORRELATED_READINGS = (
    "Errors of neighbouring rows are correlated ({:.2f}), against what is assumed: intervals are widened as for a "
    "first-order autoregressive sequence, and their confidence is approximate."
)
_REPEATED_READINGS = (
    "Each row is there {} times or more, the same in all digits: rows that are copies are not independent, and count "
    "once."
)
_TOO_FEW = (
    "The rows are too few to see a nonlinearity bend within its pieces, against what is assumed: no confidence is "
    "stated; measure at least 24 rows at 8 displacements."
)
_TWO_GROUPS = (
    "The readings lie in two groups, above and below one curve, as those of a loop do whose rows were sorted: no "
    "confidence is stated; give the rows in the order of recording, in which loading and unloading can be told apart."
)
_WIDE_GAP, _UNLIKE = 1 / 4, 8  # of the displacements measured, and times the gap that is usual


@one_thread
def sector_from_data(
    measurements: Measurements, *, confidence: float = 0.95, origin: float = 0.0, pieces: int | None = None
) -> MeasuredSector:
    r"""Bounds on ``f(sigma)/sigma`` and on the slope of the mean nonlinearity ``f`` behind noisy measurements.

    ``sigma`` is the displacement less ``origin``.  Assumed are: ``load_i = f(sigma_i) + e_i`` with independent normal
    errors of mean 0 whose standard deviation is ``s0 + s1 |f|``, both unknown; displacements without error, or with
    errors whose effect (slope times error) is part of ``e``; ``f(0) = 0``; ``f`` continuous and affine between the
    knots, whose number is chosen by a test.  Under these, with the confidence given, *all* chords and slopes of ``f``
    lie within the bounds at once: they are simultaneous intervals of a multivariate t distribution.  Nothing is divided
    by a small ``sigma``: beside 0 the chord is the slope of the adjoining piece.

    Nothing follows for displacements outside those measured, and nothing is proved inside: the evidence is OBSERVED.

    Parameters
    ----------
    measurements : Measurements
        At least 12 rows.
    confidence : float
        Between 0.5 and 0.9999.
    origin : float
        Displacement [m] at which ``sigma = 0``: where the loop is at rest, or where contact begins.
    pieces : int, optional
        About as many pieces instead of as many as the test finds.

    Returns
    -------
    MeasuredSector
        Where loading and unloading form a loop (``hysteresis``), no confidence is stated, the bounds are estimates for
        both mean branches, and no criterion for memoryless nonlinearities applies.

    Raises
    ------
    InputError
        There are too few rows or displacements, the load is 0 in all rows, or an argument is not as described.

    Notes
    -----
    Simulated nonlinearities of the class lay inside as often as stated.  Smooth nonlinearities are not of the class:
    their slope varies within a piece, most at the ends and beside 0.  Slopes there are extrapolated, and all bounds
    widened by what the next term of the expansion, read off the pieces nearby, may add.  Of eight smooth nonlinearities
    on 60 to 120 rows with noise of 0.2 to 5 % of the largest load, at most 4 in 60 simulated sets were given a
    confidence of 95 % and did not lie inside.  Where twice as many pieces fit better, and the rows allow no more of
    them, the nonlinearity is not ``resolved``: the bounds are widened further, and no confidence is stated; up to 10 in
    60 such sets did not lie inside.  Nor is it with fewer than 24 rows or 8 displacements, of which no bend is seen.

    Readings so far off that a hundred clean sets hold one are outliers: named, and left out.  Errors found correlated
    from row to row widen the intervals as for a first-order autoregressive sequence, with a warning; so do rows that
    are all there several times, the same in all digits.  A wide gap between the displacements is named.

    Examples
    --------
    >>> import numpy as np
    >>> u = np.linspace(-1e-3, 1e-3, 200)
    >>> noise = np.random.default_rng(0).normal(scale=0.5, size=200)
    >>> found = sector_from_data(Measurements.from_arrays(u, 1e5 * u + noise))
    >>> found.lower.bound < 1e5 < found.upper.bound
    True
    """
    if not (isinstance(confidence, float) and 0.5 <= confidence <= 0.9999):
        raise InputError(f"confidence is {confidence!r:.40}; give a number between 0.5 and 0.9999")
    if not (isinstance(origin, int | float) and abs(origin) < _FARTHEST):
        raise InputError(f"origin is {origin!r:.40}; give a displacement in the SI unit")
    if not measurements.load.any():
        raise InputError(
            f"the load is 0 {measurements.unit} in every row, and nothing is measured; give another column"
        )
    sigma = measurements.displacement - origin
    apart = hysteresis_from_data(measurements)
    rows = [np.arange(sigma.size)] if apart is None else branch_rows(measurements)
    nonlinearities = tuple(mean_nonlinearity(sigma[part], measurements.load[part], pieces=pieces) for part in rows)
    offsets = [
        _offset(sigma[part], measurements.load[part], nonlinearity)
        for part, nonlinearity in zip(rows, nonlinearities, strict=True)
    ]
    if any(offsets):
        nonlinearities = tuple(
            mean_nonlinearity(sigma[part], measurements.load[part], pieces=pieces, free=True) for part in rows
        )
    each = 1 - (1 - confidence) / len(nonlinearities)
    warnings = [
        _CORRELATED_READINGS.format(correlation_of(nonlinearity))
        for nonlinearity in nonlinearities
        if correlation_of(nonlinearity)
    ]
    times = _times_there(measurements)
    warnings += [_REPEATED_READINGS.format(times)] * (times > 1) + _unmeasured(sigma, measurements.displacement_unit)
    multipliers = tuple(
        _multiplier(nonlinearity, each) * widening(nonlinearity) * math.sqrt(times) for nonlinearity in nonlinearities
    )
    bounds = [
        _bounds(nonlinearity, multiplier) for nonlinearity, multiplier in zip(nonlinearities, multipliers, strict=True)
    ]
    lower, upper, least, most = (
        (min if i % 2 == 0 else max)((found[i] for found in bounds), key=lambda bound: bound.bound) for i in range(4)
    )
    for offset in filter(None, offsets):
        lower, upper = _unbounded(offset, sigma, lower, upper)
        if apart is None:  # a loop is open at 0, and that is no offset
            warnings.append(_offset_text(offset, measurements.unit))
    for nonlinearity in nonlinearities:
        if nonlinearity.twofold and apart is None:
            warnings.append(_TWO_GROUPS)
        if nonlinearity.curved < BENT and apart is None:
            warnings.append(
                f"The nonlinearity bends or jumps within its pieces (p = {nonlinearity.curved:.1g}), against what is "
                "assumed: the bounds are widened by the change of slope from piece to piece, and no confidence is "
                "stated; measure more points."
            )
        elif nonlinearity.sparse and apart is None:
            warnings.append(_TOO_FEW)
    return MeasuredSector(
        measurements=measurements,
        confidence=confidence,
        origin=float(origin),
        lower=lower,
        upper=upper,
        slope_lower=least,
        slope_upper=most,
        nonlinearities=nonlinearities,
        outliers=_outliers(measurements, nonlinearities, rows),
        hysteresis=apart,
        warnings=tuple(warnings),
        multipliers=multipliers,
    )


def _times_there(measurements: Measurements) -> int:
    """How often every row is there at least, the same in all digits."""
    rows = np.column_stack([measurements.displacement, measurements.load])
    return int(np.unique(rows, axis=0, return_counts=True)[1].min())


def _unmeasured(sigma: Array, unit: str) -> list[str]:
    """That the displacements leave a wide gap, in a sentence, if they do."""
    places = np.unique(sigma)
    gaps = np.diff(places)
    i = int(gaps.argmax())
    if gaps[i] <= max(_WIDE_GAP * (places[-1] - places[0]), _UNLIKE * float(np.median(gaps))):
        return []
    return [
        f"No row lies between sigma = {places[i]:.3g} and {places[i + 1]:.3g} {unit}: that the nonlinearity is affine "
        "between its knots there is assumed, and no test of these data can contradict it."
    ]


def _bounds(nonlinearity: MeanNonlinearity, multiplier: float) -> tuple[Bound, Bound, Bound, Bound]:
    """Least and largest chord, least and largest slope, so many standard errors outside the fitted ones."""
    found = []
    ends, beyond, at = nonlinearity.end_slopes()
    middles = np.append(0.5 * (nonlinearity.knots[1:] + nonlinearity.knots[:-1]), at)
    away, beside = nonlinearity.knots[nonlinearity.knots != 0], at == 0
    # the least-squares value at a knot lies beside a curve by a twelfth of the bend, a third of what is missed between
    missed = np.maximum(nonlinearity.missed(away * (1 - 1e-9)), nonlinearity.missed(away * (1 + 1e-9))) / np.abs(away)
    bent = (
        missed / 3,
        nonlinearity.bow() / 3,
    )  # a parabola of slopes rises within its piece by a sixth at most, a peak by more
    if not nonlinearity.resolved:  # the pieces are as many as the rows allow, and too few for the nonlinearity
        bent, beyond = (missed, np.maximum(0.5 * nonlinearity.bends(), bent[1])), _POORLY * beyond
    for combination, places, shape in (
        (
            np.vstack([nonlinearity.chords(), ends[beside]]),
            np.append(away, at[beside]),
            np.append(bent[0], beyond[beside]),
        ),
        (np.vstack([nonlinearity.slopes(), ends]), middles, np.append(bent[1], beyond)),
    ):
        values = combination @ nonlinearity.values
        errors = multiplier * _fitted_errors(combination, nonlinearity) + shape
        i, j = int(np.argmin(values - errors)), int(np.argmax(values + errors))
        found.append(Bound(bound=float(values[i] - errors[i]), fitted=float(values.min()), at=float(places[i])))
        found.append(Bound(bound=float(values[j] + errors[j]), fitted=float(values.max()), at=float(places[j])))
    return found[0], found[1], found[2], found[3]


def _fitted_errors(combination: Array, nonlinearity: MeanNonlinearity) -> Array:
    return np.asarray(
        np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", combination, nonlinearity.covariance, combination), 0.0))
    )


def _multiplier(nonlinearity: MeanNonlinearity, confidence: float) -> float:
    """How many standard errors hold all chords and slopes at once: the quantile of the largest of correlated t."""
    combination = np.vstack([nonlinearity.chords(), nonlinearity.slopes(), nonlinearity.end_slopes()[0]])
    errors = _fitted_errors(combination, nonlinearity)
    combination = combination[errors > 0] / errors[errors > 0, None]
    if not len(combination):
        return 0.0
    scales = np.sqrt(np.maximum(np.diag(nonlinearity.covariance), 1e-300))
    values, vectors = np.linalg.eigh(nonlinearity.covariance / np.outer(scales, scales))
    # the symmetric root: it depends on no choice of signs, so that the draws are the same in all units
    root = combination @ (scales[:, None] * ((vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T))
    random = np.random.default_rng(_SEED)
    draws = np.abs(random.standard_normal((_DRAWS, root.shape[1])) @ root.T).max(axis=1)
    draws /= np.sqrt(random.chisquare(nonlinearity.degrees, _DRAWS) / nonlinearity.degrees)
    spread = math.sqrt(confidence * (1 - confidence) / _DRAWS)
    return float(np.quantile(draws, min(confidence + 2 * spread, 1 - 1 / _DRAWS)))


def _offset(sigma: Array, load: Array, nonlinearity: MeanNonlinearity) -> tuple[float, float] | None:
    """The mean load at 0 and its standard error if they contradict ``f(0) = 0``."""
    from scipy.stats import t as student

    if not (sigma.min() <= 0 <= sigma.max()):
        return None
    free = mean_nonlinearity(sigma, load, pieces=max(2, nonlinearity.knots.size - 1), free=True)
    value, error = float(free(0.0)), float(free.error(0.0)[0])
    limit = float(student.isf((1 - _SURE) / 2, free.degrees)) * error + _corner(free)
    limit += 1e-9 * float(np.abs(load).max())
    return (value, error) if abs(value) > limit else None


def _corner(nonlinearity: MeanNonlinearity) -> float:
    """How far the value at 0 may lie from a nonlinearity that bends on the pieces beside it."""
    i = int(np.flatnonzero(nonlinearity.knots == 0)[0])
    beside = [j for j in (i - 1, i, i + 1) if 0 <= j < nonlinearity.knots.size - 1]
    slopes, widths = (nonlinearity.slopes() @ nonlinearity.values)[beside], np.diff(nonlinearity.knots)[beside]
    return 0.25 * float(np.abs(np.diff(slopes)).max(initial=0.0) * widths.max())


def _unbounded(offset: tuple[float, float], sigma: Array, lower: Bound, upper: Bound) -> tuple[Bound, Bound]:
    """Chords of a nonlinearity that does not vanish at 0 grow without bound on the sides measured."""
    up = (offset[0] > 0 and sigma.max() > 0) or (offset[0] < 0 and sigma.min() < 0)
    down = (offset[0] < 0 and sigma.max() > 0) or (offset[0] > 0 and sigma.min() < 0)
    return (
        Bound(bound=-math.inf, fitted=-math.inf, at=0.0) if down else lower,
        Bound(bound=math.inf, fitted=math.inf, at=0.0) if up else upper,
    )


def _offset_text(offset: tuple[float, float], unit: str) -> str:
    return (
        f"The mean load at sigma = 0 is {offset[0]:.3g} +- {offset[1]:.1g} {unit}, not 0: such a nonlinearity lies in "
        f"no finite "
        "sector; give the origin where the load vanishes, or subtract the offset of the instrument."
    )


def _outliers(
    measurements: Measurements, nonlinearities: tuple[MeanNonlinearity, ...], rows: list[NDArray[np.intp]]
) -> tuple[Outlier, ...]:
    found = [
        Outlier(index=int(part[i]), line=int(measurements.lines[part[i]]), score=float(nonlinearity.scores[i]))
        for nonlinearity, part in zip(nonlinearities, rows, strict=True)
        for i in nonlinearity.outliers
    ]
    return tuple(sorted(found, key=lambda outlier: outlier.index))
