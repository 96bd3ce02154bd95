"""The search for a switched gain that makes a loop grow, in floating point: a proposal, never a proof."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction

from lure.analysis.counterexamples.linear import Exponential, Realisation, doubles
from lure.analysis.deadline import checkpoint
from lure.arrays import NDArray, Reals, np, optimize

MAX_SWITCHES = 12
RUNGS = 45
ROUNDING = 1e-12
MAX_EXPONENTIALS = 60_000  # up to order 5, then fewer: a few seconds
GRID_COST = 1_500  # a grid of 48 x 48 products, in exponentials


@dataclass(frozen=True, slots=True)
class Pattern:
    """Durations in which the gain is ``lower, k, lower, k, ...``, and the ``k`` at which the loop starts to grow."""

    times: Reals
    k: float


@dataclass(frozen=True, slots=True)
class SwitchingSearch:
    """The search for one block.

    Attributes
    ----------
    system : Realisation
        The block.
    lower : Fraction
        Lower gain.
    circle, omega : float
        Where the circle criterion stops, and at which frequency [rad/s]: nothing below it is worth a search.
    limit : float
        The first gain that is itself unstable: nothing at or above it is wanted.
    spent : list of int
        Matrix exponentials computed so far; past a limit nothing grows any more, and the search ends with what it has.
    known : dict
        Exponentials of the closed-loop matrices by gain.
    """

    system: Realisation
    lower: Fraction
    circle: float
    omega: float
    limit: float
    spent: list[int] = field(default_factory=lambda: [0], repr=False, compare=False)
    known: dict[float, Exponential] = field(default_factory=dict, repr=False, compare=False)

    def closed(self, k: float) -> Exponential:
        """Of ``A - b c k/(1 + k d)``, remembered: it is computed exactly and asked for again and again."""
        if k not in self.known:
            self.known[k] = Exponential(doubles(self.system.closed(Fraction(k))))
        return self.known[k]

    def growth(self, times: Reals, k: float) -> float:
        """Logarithm of the spectral radius over the period, per unit of time; ``-inf`` once the work is used up.

        What may be rounding is none: over short periods, or with a pole on the axis, it would seem to grow.
        """
        self.spent[0] += len(times)
        checkpoint()
        if self.spent[0] * max(1, self.system.order // 3) > MAX_EXPONENTIALS:
            return -math.inf
        radius = _radius(self.transition(times, k))
        if not 0 < radius < math.inf:
            return -math.inf
        grown = math.log(radius)
        return grown / float(times.sum()) if abs(grown) > ROUNDING else 0.0

    def transition(self, times: Reals, k: float) -> Reals:
        """The matrix of one period."""
        pair = self.closed(float(self.lower)), self.closed(k)
        product = np.eye(self.system.order)
        with np.errstate(all="ignore"):
            for i, t in enumerate(times):
                product = pair[i % 2].over(t) @ product
        return product

    def run(self) -> Pattern | None:
        """The pattern with the smallest ``k`` found, or None."""
        if not self.circle < math.inf:
            return None
        floor, best = float(self.lower), None
        reach = self.circle - floor if self.circle > floor else 1e-3 * min(self.limit - floor, 1.0)
        for i in range(1, RUNGS):
            k = min(floor + reach * 1.3**i, self.limit)
            best = self.two_times(k)
            if best is not None or k >= self.limit:
                break
        if best is None:
            return None
        for _ in range(6):
            polished = self.polish(best)
            richer = self.more_switches(polished)
            settled = richer is None or richer.k > polished.k * (1 - 1e-7)
            best = polished if richer is None or richer.k > polished.k else richer
            if settled:
                break
        return best if best.k < self.limit else None

    def above(self, k: float, factor: float) -> float:
        """``lower + (k - lower) factor``."""
        return float(self.lower) + (k - float(self.lower)) * factor

    def two_times(self, k: float) -> Pattern | None:
        """The two durations found with the largest growth, if the loop grows with them."""
        starts = [self.best_of_grid(k)]
        if self.omega > 0:  # the gain turns twice as fast as the motion
            starts.append(np.full(2, math.pi / (2 * self.omega)))
        found = max((self.faster(times, k) for times in starts), key=lambda times: self.growth(times, k))
        return Pattern(found, k) if self.growth(found, k) > 0 else None

    def best_of_grid(self, k: float) -> Reals:
        """The two durations of a grid with the largest growth."""
        self.spent[0] += GRID_COST
        pair = self.closed(float(self.lower)), self.closed(k)
        rates = np.abs(np.concatenate([one.values for one in pair]))
        rates = rates[rates > 1e-6 * rates.max()]
        times = np.geomspace(0.05 / rates.max(), 8 / rates.min(), 48)
        with np.errstate(all="ignore"):
            low, high = (one.over(times) for one in pair)
            products = np.einsum("aij,bjk->abik", high, low)
            finite = np.isfinite(products).all(axis=(-1, -2))
            radius = np.abs(np.linalg.eigvals(np.where(finite[..., None, None], products, 0.0))).max(axis=-1)
            rate = np.nan_to_num(np.log(radius) / (times[:, None] + times[None, :]), nan=-np.inf)
        j, i = np.unravel_index(int(rate.argmax()), rate.shape)
        return np.array([times[i], times[j]])

    def faster(self, times: Reals, k: float) -> Reals:
        """Times near the given ones with the largest growth."""

        def slowness(logarithms: Reals) -> float:
            """Negative growth, for a minimiser."""
            return -self.growth(np.exp(logarithms), k) if np.abs(logarithms).max() < 60 else math.inf

        options = {"xatol": 1e-7, "fatol": 1e-14, "maxiter": 150 * len(times)}
        found: Reals = optimize.minimize(slowness, np.log(times), method="Nelder-Mead", options=options).x
        return np.exp(found)

    def polish(self, pattern: Pattern) -> Pattern:
        """Lower ``k`` with the times fixed, then better the times with ``k`` fixed, until neither helps."""
        for _ in range(12):
            k = self.threshold(pattern)
            times = self.faster(pattern.times, k)
            done = abs(k - pattern.k) <= 1e-10 * abs(k)
            pattern = Pattern(times, k)
            if done:
                break
        return Pattern(pattern.times, self.threshold(pattern))

    def threshold(self, pattern: Pattern) -> float:
        """Where the growth with these times vanishes, at or below the pattern's ``k``."""
        high, low = pattern.k, max(self.circle, self.above(pattern.k, 0.5))
        while self.growth(pattern.times, low) > 0 and low > self.circle:
            high, low = low, max(self.circle, self.above(low, 0.5))
        if low >= high or not self.growth(pattern.times, low) < 0 < self.growth(pattern.times, high):
            return pattern.k
        return float(
            optimize.brentq(lambda k: self.growth(pattern.times, k), low, high, xtol=1e-13 * (high - low), rtol=1e-13)
        )

    def more_switches(self, pattern: Pattern) -> Pattern | None:
        """A pattern with a smaller ``k`` that the switching function leads to, or None."""
        best = None
        for repeat in (1, 2):
            times = np.tile(pattern.times, repeat)
            bins = _Bins(self, pattern.k, float(times.sum()), 120)
            richer = bins.improved(times)
            if richer is None or len(richer) > MAX_SWITCHES:
                continue
            richer = self.faster(richer, pattern.k)
            if self.growth(richer, pattern.k) > 0:
                candidate = Pattern(richer, self.threshold(Pattern(richer, pattern.k)))
                best = candidate if best is None or candidate.k < best.k else best
        return best


class _Bins:
    """One period cut into equal bins, each with one of the two gains."""

    def __init__(self, search: SwitchingSearch, k: float, period: float, count: int) -> None:
        self.edges = period * (np.arange(count) + 0.5) / count
        self.width = period / count
        with np.errstate(all="ignore"):
            self.steps = [search.closed(gain).over(self.width) for gain in (float(search.lower), k)]

    def improved(self, times: Reals) -> Reals | None:
        """Durations after the gain of every bin has been given the sign of the switching function, while that helps."""
        choice = (np.searchsorted(np.cumsum(times), self.edges, side="right") % 2).astype(int)
        radius, slope = self.slope(choice)
        first = choice
        for _ in range(30):
            for share in (1.0, 0.3, 0.1, 0.03):
                gain = np.where(choice == 1, -slope, slope)  # of changing the bin
                flip = gain > np.quantile(gain, 1 - share) if share < 1 else gain > 0
                trial = np.where(flip & (gain > 0), 1 - choice, choice)
                better, derivative = self.slope(trial)
                if better > radius * (1 + 1e-12):
                    choice, radius, slope = trial, better, derivative
                    break
            else:
                break
        return None if choice is first else self.durations(choice)

    def slope(self, choice: NDArray[np.int_]) -> tuple[float, Reals]:
        """Spectral radius, and its first-order change if a bin went from ``lower`` to ``k``."""
        n = len(self.steps[0])
        before = [np.eye(n)]
        for c in choice:
            before.append(self.steps[c] @ before[-1])
        if not np.isfinite(before[-1]).all():
            return 0.0, np.zeros(len(choice))
        values, left, right = _eigenvectors(before[-1])
        at = int(np.abs(values).argmax())
        y, x, value = left[at], right[:, at], values[at]
        if not 0 < abs(value) < math.inf:
            return 0.0, np.zeros(len(choice))
        change = self.steps[1] - self.steps[0]
        slopes, row = np.empty(len(choice)), y
        for i in range(len(choice) - 1, -1, -1):
            slopes[i] = (np.conj(value) * (row @ change @ before[i] @ x)).real / abs(value)
            row = row @ self.steps[choice[i]]
        return float(abs(value)), slopes

    def durations(self, choice: NDArray[np.int_]) -> Reals | None:
        """Lengths of the runs, from the start of a run of ``lower``."""
        starts = np.flatnonzero((choice == 0) & (np.roll(choice, 1) == 1))
        if len(starts) == 0:
            return None
        turned = np.roll(choice, -int(starts[0]))
        edges = np.flatnonzero(np.diff(turned)) + 1
        return np.diff(np.concatenate([[0], edges, [len(turned)]])) * self.width


def _radius(matrix: Reals) -> float:
    """Spectral radius; 0 for a matrix that is not finite, so that it is never taken for growth."""
    return float(np.abs(np.linalg.eigvals(matrix)).max()) if np.isfinite(matrix).all() else 0.0


def _eigenvectors(matrix: Reals) -> tuple[NDArray[np.complex128], NDArray[np.complex128], NDArray[np.complex128]]:
    """Eigenvalues, left eigenvectors as rows with ``y x = 1``, right eigenvectors as columns."""
    values, right = np.linalg.eig(matrix)
    left = np.linalg.pinv(right)
    return values.astype(complex), left.astype(complex), right.astype(complex)
