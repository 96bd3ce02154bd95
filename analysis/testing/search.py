"""The search for a point, or a pair of points, at which a law breaks what is asserted of it."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from analysis.testing.measures import Chord, Mirror, Quotient
from analysis.testing.subject import Array

_JUMPS, _PEAKS, _PAIRS = 24, 12, 16
_HALVINGS, _STEPS = 52, 40
_PARTS, _ROUNDS = 8, 18
_CLOSEST = 1e-7

Worst: TypeAlias = tuple[float, tuple[float, ...]]
"""The largest excess over limits and allowance (positive: a violation), and the point or pair where it is."""


def worst_point(measure: Chord | Mirror, x: Array) -> Worst:
    """The worst point found: on the grid, next to what looks like jumps, and at local maxima between the points.

    Parameters
    ----------
    measure : Chord or Mirror
        What is measured.
    x : NDArray[np.float64]
        Ascending points to begin with, without 0.

    Notes
    -----
    The intervals over which the quantity changes most are halved towards the larger change, which finds the two sides
    of a jump to the last digit; then the distance to the limits is maximised by a bounded search between the neighbours
    of the largest local maxima.  A spike that leaves no trace on the points is not found.
    """
    values = measure.quantity(x)
    best = _worst(measure, x, values)
    if best[0] > 0 or x.size < 3:
        return best
    jumps = _beside_jumps(measure, x, values)
    best = max(best, _worst(measure, jumps, measure.quantity(jumps)))
    if best[0] > 0:
        return best
    for side in measure.limits.sides:
        peaks = _peaks(measure, x, side * values, side)
        best = max(best, _worst(measure, peaks, measure.quantity(peaks)))
    return best


def worst_pair(measure: Quotient, x: Array) -> Worst:
    """The worst pair found: consecutive points, then ever closer ones where the quotient is largest or changes most.

    Parameters
    ----------
    measure : Quotient
        What is measured.
    x : NDArray[np.float64]
        Ascending points to begin with.

    Notes
    -----
    A quotient over an interval is a mean of those over its parts: consecutive pairs are the worst of all pairs of
    points.  The search divides the worst intervals, with their neighbours, until they are ``1e-7`` of ``|sigma|`` long.
    """
    phi = measure.subject(x)
    best = _worst_of_pairs(measure, x, phi)
    if best[0] > 0 or x.size < 3:
        return best
    values = measure.quantity(x, phi)
    turns = np.argsort(-np.abs(np.diff(values, prepend=values[0])))[:_PAIRS]
    for side in measure.limits.sides:
        for i in sorted({*_local_maxima(side * values)[:_PAIRS], *turns}):
            best = max(best, _closer(measure, float(x[max(i - 1, 0)]), float(x[min(i + 2, x.size - 1)]), side))
            if best[0] > 0:
                return best
    return best


def _worst(measure: Chord | Mirror, x: Array, values: Array) -> Worst:
    if x.size == 0:
        return -np.inf, ()
    excess = measure.limits.outside(values) - measure.allowance(x, values)
    i = int(np.argmax(excess))
    return float(excess[i]), (float(x[i]),)


def _worst_of_pairs(measure: Quotient, x: Array, phi: Array) -> Worst:
    values = measure.quantity(x, phi)
    excess = measure.limits.outside(values) - measure.allowance(x, phi, values)
    excess[np.isnan(excess)] = -np.inf
    i = int(np.argmax(excess))
    return float(excess[i]), (float(x[i]), float(x[i + 1]))


def _beside_jumps(measure: Chord | Mirror, x: Array, values: Array) -> Array:
    """Points on both sides of the largest changes between neighbours of one sign."""
    changes = np.where(x[:-1] * x[1:] > 0, np.abs(np.diff(values)), 0.0)
    chosen = np.argsort(-changes)[:_JUMPS]
    chosen = chosen[changes[chosen] > 0]
    low, high, at_low, at_high = x[chosen], x[chosen + 1], values[chosen], values[chosen + 1]
    met = [low, high]
    for _ in range(_HALVINGS):
        middle = 0.5 * low + 0.5 * high
        inner = (middle > low) & (middle < high)
        if not inner.any():
            break
        low, high, at_low, at_high, middle = (a[inner] for a in (low, high, at_low, at_high, middle))
        at_middle = measure.quantity(middle)
        met.append(middle)
        left = np.abs(at_middle - at_low) >= np.abs(at_high - at_middle)
        low, at_low = np.where(left, low, middle), np.where(left, at_low, at_middle)
        high, at_high = np.where(left, middle, high), np.where(left, at_middle, at_high)
    return np.concatenate(met)


def _peaks(measure: Chord | Mirror, x: Array, values: Array, side: int) -> Array:
    """Points towards the local maxima of the values, by a bounded search between the neighbours of the largest."""
    from scipy.optimize import minimize_scalar

    met: list[float] = []

    def inwards(sigma: float) -> float:
        """What is minimised."""
        met.append(float(sigma))
        return -side * float(measure.quantity(np.array([sigma]))[0])

    for i in _local_maxima(values)[:_PEAKS]:
        low, high = float(x[max(i - 1, 0)]), float(x[min(i + 1, x.size - 1)])
        for a, b in ((low, float(x[i])), (float(x[i]), high)):
            if a < b and a * b > 0:
                options = {"maxiter": _STEPS, "xatol": 1e-12 * (b - a)}
                minimize_scalar(inwards, bounds=(a, b), method="bounded", options=options)
    return np.array(met)


def _local_maxima(values: Array) -> NDArray[np.intp]:
    """Indices of local maxima that are higher than a neighbour, the highest first."""
    padded = np.concatenate([[-np.inf], values, [-np.inf]])
    left, right = values - padded[:-2], values - padded[2:]
    with np.errstate(invalid="ignore"):
        found = np.flatnonzero((left >= 0) & (right >= 0) & ((left > 0) | (right > 0)))
    return np.asarray(found[np.argsort(-values[found], kind="stable")])


def _closer(measure: Quotient, low: float, high: float, side: int) -> Worst:
    """The worst pair of an interval, which is divided around the steepest part again and again."""
    best: Worst = (-np.inf, ())
    for _ in range(_ROUNDS):
        x = np.unique(np.linspace(low, high, _PARTS + 1))
        if x.size < 3 or (high - low) / _PARTS < _CLOSEST * max(abs(low), abs(high)):
            break
        phi = measure.subject(x)
        best = max(best, _worst_of_pairs(measure, x, phi))
        i = int(np.argmax(side * measure.quantity(x, phi)))
        low, high = float(x[max(i - 1, 0)]), float(x[min(i + 2, x.size - 1)])
    return best
