r"""Whether the load depends on the direction of travel, decided from the branches themselves.

Each branch is compared with the one before it at equal displacements.  What is asked of the difference is whether it
has one sign on loading against unloading, an area, and whether it comes back cycle after cycle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lure.analysis.measured.mean_nonlinearity import LEAST_ROWS, MeanNonlinearity, mean_nonlinearity
from lure.analysis.measured.measured_sector import Hysteresis
from lure.analysis.measured.measurements import Branch, Direction, Measurements

# Whether loading and unloading follow one law, and what correlated errors do to such questions.

Array = NDArray[np.float64]
_DIRECTIONS: tuple[Direction, Direction] = ("loading", "unloading")
_PLACES = 65
_CORRELATED = 2.6
_ROUNDING = 1e-12


def branch_rows(measurements: Measurements) -> list[NDArray[np.intp]]:
    """The rows on loading and those on unloading, if both have enough for a mean law; else an empty list.

    Parameters
    ----------
    measurements : Measurements
        What is cut.
    """
    rows = [measurements.rows(direction) for direction in _DIRECTIONS]
    enough = all(part.size >= LEAST_ROWS and np.unique(measurements.displacement[part]).size >= 4 for part in rows)
    return rows if enough else []


def hysteresis_from_data(measurements: Measurements) -> Hysteresis | None:
    """The loop between loading and unloading; None where there is none to be seen, or there are no two branches.

    Whether there is one is decided by ``has_loop``; its size is that between the mean laws
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
    laws = [mean_nonlinearity(measurements.displacement[r] - origin, measurements.load[r], free=True) for r in rows]
    places = np.linspace(max(law.knots[0] for law in laws), min(law.knots[-1] for law in laws), _PLACES)
    apart = laws[0](places) - laws[1](places)
    i = int(np.argmax(np.abs(apart)))
    return Hysteresis(
        width=float(abs(apart[i])),
        at=float(places[i]) + origin,
        share=float(abs(apart[i])) / float(max(np.abs(law.values).max() for law in laws)),
        dissipated=float(np.trapezoid(apart, places)),
        rows=(rows[0].size, rows[1].size),
        branches=len(measurements.branches),
    )


def correlation_of(law: MeanNonlinearity) -> float:
    """Correlation of the errors of neighbouring rows; 0 where it is no more than chance, or errors are rounding.

    Parameters
    ----------
    law : MeanNonlinearity
        With the residuals in the order of recording.
    """
    scores = np.delete(law.scores, law.outliers)
    exact = float(law.noise(law.values).max()) < _ROUNDING * float(np.abs(law.values).max())
    if exact or not scores.any():
        return 0.0
    found = float(np.sum(scores[1:] * scores[:-1]) / np.sum(scores**2))
    return min(found, 0.99) if found * math.sqrt(scores.size) > _CORRELATED else 0.0


def widening(law: MeanNonlinearity) -> float:
    """By how much errors that form a first-order autoregressive sequence widen an interval; 1 if they look independent.

    Parameters
    ----------
    law : MeanNonlinearity
        With the residuals in the order of recording.
    """
    correlation = correlation_of(law)
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


@dataclass(frozen=True, slots=True)
class Pair:
    """Loading less unloading of two neighbouring branches, along the displacements that both have.

    Attributes
    ----------
    apart : ndarray
        (n,) load on loading less load on unloading [unit of the load], at the readings of the shorter branch and
        ordered from the turn between the two.
    mean : float
        The mean over the readings of both branches, so that errors of interpolation cancel.
    unsure : float
        How far a reading typically lies from the line between its neighbours [unit of the load], by noise and
        curvature; at least the last digit of the load.
    """

    apart: Array
    mean: float
    unsure: float


def has_loop(measurements: Measurements) -> bool:
    """Whether loading and unloading follow different laws.

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

    Parameters
    ----------
    measurements : Measurements
        In the order of recording.
    """
    pairs = pairs_of(measurements)
    return bool(pairs) and (_repeats(pairs) or _beyond_noise(pairs))


def pairs_of(measurements: Measurements) -> list[Pair]:
    """Neighbouring branches compared, those with at least four displacements in common.

    Parameters
    ----------
    measurements : Measurements
        In the order of recording.
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
