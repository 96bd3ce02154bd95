"""From a point that violates to the simplest number that does, as plainly."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from lure.analysis.testing.subject import Subject
from lure.arrays import NDArray, Reals, np
from lure.errors import InputError
from lure.exact import Exact, exact_number

# Where a law is tested: an interval, and the points of it that are tried first.

_DECADES = (-12.0, 12.0)
_SHARE_OF_LINEAR = 0.25
_NEAR = (0.0, 1e-3, -1e-3, 1e-6, -1e-6, 1e-9, -1e-9)


@dataclass(frozen=True, kw_only=True, slots=True)
class Domain:
    """The interval ``[low, high]`` in doubles.

    Attributes
    ----------
    low, high : float
        Its ends; ``-1e12, 1e12`` stand for all of R where nothing was given.
    given : tuple of Fraction or None
        The ends as they were given, None for all of R.
    scale : float
        The evenly spaced points have at most this size.
    """

    low: float
    high: float
    given: tuple[Fraction, Fraction] | None
    scale: float

    def __str__(self) -> str:
        return f"[{self.low:g}, {self.high:g}]"

    def points(self, samples: int, breakpoints: Sequence[float]) -> NDArray[np.float64]:
        """Ascending points: many decades on both sides of 0, evenly spaced ones, and some near breakpoints."""
        reach = max(abs(self.low), abs(self.high))
        top = np.log10(reach)
        sizes = np.logspace(min(_DECADES[0], top - 12.0), top, max(samples * 3 // 8, 4))
        linear = np.linspace(
            max(self.low, -self.scale), min(self.high, self.scale), int(samples * _SHARE_OF_LINEAR) + 2
        )
        kinks = np.array([b for b in breakpoints if np.isfinite(b)], dtype=float)
        near = [kinks + shift * np.maximum(np.abs(kinks), 1e-3 * self.scale) for shift in _NEAR]
        x = np.unique(np.concatenate([-sizes, sizes, linear, *near, [0.0, self.low, self.high]]))
        return np.asarray(x[(x >= self.low) & (x <= self.high)])

    @property
    def rounding_scale(self) -> float:
        """Size of ``sigma`` below which ``phi`` is taken to carry the rounding of its largest value there."""
        return min(self.scale, 1.0)

    @property
    def unit(self) -> float:
        """The power of ten in which simple numbers of the interval are written."""
        return 1.0 if self.given is None else float(f"1e{math.floor(math.log10(self.scale))}")

    def holds(self, sigma: float) -> bool:
        """Whether a point belongs to the interval."""
        return self.low <= sigma <= self.high


def domain(on: tuple[Exact, Exact] | None) -> Domain:
    """The interval of a test.

    Parameters
    ----------
    on : (low, high) or None
        Ends, exact numbers; None for all of R, of which ``|sigma| <= 1e12`` is sampled.

    Raises
    ------
    InputError
        It is not a pair of numbers in ascending order.
    """
    if on is None:
        return Domain(low=-1e12, high=1e12, given=None, scale=1.0)
    if isinstance(on, str) or not isinstance(on, Sequence) or len(on) != 2:
        raise InputError(f"on is {on!r:.60}; give a pair (low, high), or None for all of R")
    low, high = exact_number(on[0], "on[0]"), exact_number(on[1], "on[1]")
    if not low < high:
        raise InputError(f"on is ({float(low):g}, {float(high):g}); give low < high")
    ends = float(low), float(high)
    return Domain(low=ends[0], high=ends[1], given=(low, high), scale=max(map(abs, ends)))


# How far a law is outside what is asserted of it, and how much of that may be rounding.

_RELATIVE = 1e-12
_ABSOLUTE = 4e-15
_ARGUMENT = 2e-15


@dataclass(frozen=True, kw_only=True, slots=True)
class Limits:
    """What a quantity must lie between, and by how much it may miss: ``lower - tolerance`` to ``upper + tolerance``."""

    lower: float | Fraction
    upper: float | Fraction
    tolerance: float

    @property
    def size(self) -> float:
        """The larger of the finite bounds, in size; 0 if there is none."""
        return max((abs(float(b)) for b in (self.lower, self.upper) if abs(b) != math.inf), default=0.0)

    @property
    def sides(self) -> tuple[int, ...]:
        """1 if there is an upper bound, -1 if there is a lower one."""
        return tuple(side for side, bound in ((1, self.upper), (-1, self.lower)) if abs(bound) != math.inf)

    def outside(self, values: Reals) -> Reals:
        """Signed distance to the limits without the tolerance, positive outside; ``-inf`` where nothing bounds."""
        return np.maximum(values - float(self.upper), float(self.lower) - values)

    def allowance(self, values: Reals, coarseness: float) -> Reals:
        """The tolerance, and what rounding may do to a value whatever the law."""
        return self.tolerance + coarseness * _RELATIVE * np.maximum(np.abs(values), self.size)


@dataclass(frozen=True, kw_only=True, slots=True)
class Chord:
    """``phi(sigma)/sigma``, for ``sigma`` not 0."""

    subject: Subject
    limits: Limits
    noise: float

    def quantity(self, x: Reals) -> Reals:
        """The chord slopes."""
        return np.asarray(self.subject(x) / x)

    def allowance(self, x: Reals, values: Reals) -> Reals:
        """Tolerance and rounding."""
        return np.asarray(self.limits.allowance(values, self.subject.coarseness) + self.noise / np.abs(x))


@dataclass(frozen=True, kw_only=True, slots=True)
class Mirror:
    """``phi(sigma) + phi(-sigma)``, which is 0 for an odd law."""

    subject: Subject
    limits: Limits
    noise: float

    def quantity(self, x: Reals) -> Reals:
        """The sums."""
        return self.subject(x) + self.subject(-x)

    def allowance(self, x: Reals, values: Reals) -> Reals:
        """Tolerance and rounding."""
        sizes = np.maximum(np.abs(self.subject(x)), np.abs(values))
        return self.limits.allowance(sizes, self.subject.coarseness) + 2 * self.noise


@dataclass(frozen=True, kw_only=True, slots=True)
class Quotient:
    """``(phi(y) - phi(x))/(y - x)``, for pairs ``x < y``."""

    subject: Subject
    limits: Limits
    noise: float

    def quantity(self, x: Reals, phi: Reals) -> Reals:
        """The difference quotients of consecutive points."""
        with np.errstate(over="ignore"):
            return np.diff(phi) / np.diff(x)

    def allowance(self, x: Reals, phi: Reals, values: Reals) -> Reals:
        """Tolerance and rounding: of the values, and of the argument inside the law."""
        steps = np.diff(x)
        coarse = self.subject.coarseness
        sizes = coarse * (np.abs(phi[1:]) + np.abs(phi[:-1]))
        argument = coarse * _ARGUMENT * (np.abs(x[1:]) + np.abs(x[:-1])) * np.maximum(np.abs(values), self.limits.size)
        with np.errstate(over="ignore"):
            return self.limits.allowance(values, coarse) + (2 * self.noise + 1e-15 * sizes + argument) / steps


def rounding(subject: Subject, x: Reals, where: Domain) -> float:
    """The absolute rounding error granted to a law in doubles: 4e-15 of its largest value near 0."""
    inner = x[np.abs(x) <= where.rounding_scale]
    return subject.coarseness * _ABSOLUTE * float(np.abs(subject(inner)).max(initial=0.0))


# The search for a point, or a pair of points, at which a law breaks what is asserted of it.

_JUMPS, _PEAKS, _PAIRS = 24, 12, 16
_HALVINGS, _STEPS = 52, 40
_PARTS, _ROUNDS = 8, 18
_CLOSEST = 1e-7

Worst: TypeAlias = tuple[float, tuple[float, ...]]
"""The largest excess over limits and allowance (positive: a violation), and the point or pair where it is."""


def worst_point(measure: Chord | Mirror, x: Reals) -> Worst:
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


def worst_pair(measure: Quotient, x: Reals) -> Worst:
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


def _worst(measure: Chord | Mirror, x: Reals, values: Reals) -> Worst:
    if x.size == 0:
        return -np.inf, ()
    excess = measure.limits.outside(values) - measure.allowance(x, values)
    i = int(np.argmax(excess))
    return float(excess[i]), (float(x[i]),)


def _worst_of_pairs(measure: Quotient, x: Reals, phi: Reals) -> Worst:
    values = measure.quantity(x, phi)
    excess = measure.limits.outside(values) - measure.allowance(x, phi, values)
    excess[np.isnan(excess)] = -np.inf
    i = int(np.argmax(excess))
    return float(excess[i]), (float(x[i]), float(x[i + 1]))


def _beside_jumps(measure: Chord | Mirror, x: Reals, values: Reals) -> Reals:
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


def _peaks(measure: Chord | Mirror, x: Reals, values: Reals, side: int) -> Reals:
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


def _local_maxima(values: Reals) -> NDArray[np.intp]:
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


_PLAIN = (1.0, 2.0, 0.5, 3.0, 10.0, 0.1, 5.0, 0.2, 1.5, 100.0, 0.01, 1000.0, 0.001)
_SHARE = 0.2
_DIGITS = 17
_HALF = 0.5


def simplest_point(
    excess: Callable[[float], float], worst: tuple[float, float], *, size: float, unit: float = 1.0
) -> float:
    """A number of few digits with a violation worth showing.

    Parameters
    ----------
    excess : callable
        How far a point violates, positive if it does; ``-inf`` where nothing is asserted.
    worst : (excess, sigma)
        The violation to begin with.
    size : float
        Size of the bounds: a violation of a fifth of it is worth showing, however large the worst is.
    unit : float
        Power of ten in which plain numbers are tried.
    """
    enough = _enough(worst[0], size)
    for sigma in _points(worst[1], unit):
        if excess(sigma) >= enough:
            return sigma
    return worst[1]


def simplest_pair(
    excess: Callable[[float, float], float], worst: tuple[float, float, float], *, size: float, unit: float = 1.0
) -> tuple[float, float]:
    """A pair of numbers of few digits with a violation worth showing.

    Parameters
    ----------
    excess : callable
        How far a pair violates, positive if it does.
    worst : (excess, sigma, sigma)
        The violation to begin with.
    size : float
        Size of the bounds.
    unit : float
        Power of ten in which plain numbers are tried.
    """
    enough = _enough(worst[0], size)
    for pair in _pairs(worst[1], worst[2], unit):
        if excess(*pair) >= enough:
            return pair
    return worst[1], worst[2]


def _enough(worst: float, size: float) -> float:
    return _SHARE * min(worst, size) if size > 0 else _SHARE * min(worst, 1.0)


def _points(worst: float, unit: float) -> Iterator[float]:
    for plain in _plain(unit):
        yield plain
        yield -plain
    for digits in range(1, _DIGITS + 1):
        step = _step(worst, digits)
        steps = round(worst / step)
        for number in (steps, steps + 1, steps - 1):
            yield float(f"{number * step:.{digits}g}")


def _pairs(low: float, high: float, unit: float) -> Iterator[tuple[float, float]]:
    for plain in _plain(unit):
        for sign in (1.0, -1.0) if high > 0 else (-1.0, 1.0):
            first, second = sorted((0.0, sign * plain))
            yield first, second
            first, second = sorted((sign * plain, sign * 2 * plain))
            yield first, second
            first, second = sorted((sign * _HALF * plain, sign * plain))
            yield first, second
    middle = 0.5 * low + 0.5 * high
    for digits in range(1, _DIGITS + 1):
        step = _step(max(abs(low), abs(high)), digits)
        numbers = [math.floor(middle / step) + shift for shift in (-1, 0, 1, 2)]
        grid = [float(f"{number * step:.{digits}g}") for number in numbers]
        for i, j in ((1, 2), (0, 1), (2, 3), (0, 2), (1, 3)):
            if grid[i] < grid[j]:
                yield grid[i], grid[j]


def _plain(unit: float) -> list[float]:
    """The plainest numbers, in a unit."""
    return [float(f"{plain * unit:.3g}") for plain in _PLAIN]


def _step(value: float, digits: int) -> float:
    """The last of so many decimal digits of a number."""
    return float(f"1e{math.floor(math.log10(abs(value))) - digits + 1}") or 5e-324 if value else 1e-12
