"""Gains of several channels that jump periodically between the ends of their intervals, in floating point.

Over one period the state is multiplied by ``M = ... exp(A_2 t_2) exp(A_1 t_1)``, ``A_j = A - B G_j (1 + D G_j)^-1 C``,
in discrete time by the product of these: with an eigenvalue of ``M`` outside the unit disc some solution grows.  The
derivative of the spectral radius chooses the gains instant by instant, then the switches are shifted, then the factor
of the classes is lowered, again and again.  That finds a good pattern, not the best; a checker decides.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import field
from fractions import Fraction
from functools import lru_cache
from itertools import groupby, product
from typing import Any, NamedTuple

from lure.analysis.counterexamples.channel_gains import GainsAround
from lure.analysis.deadline import checkpoint
from lure.arrays import NDArray, Reals, np, optimize
from lure.record import described, quantity

MOST_STATES = 30
_MOST_ENDS, _MOST_SETS = 32, 8  # of gains that a pattern may use, and of gains that stay
_BINS, _ROUNDS, _KEPT, _LONGEST, _DESCENTS, _SEED = 48, 25, 4, 24, 10, 20261122
_DRAWN, _STARTS = 200, 2  # patterns of a period
_PERIODS = (*range(2, 9), 10, 12, 16)  # in samples
_RUNGS = (1.5, 3.0, 10.0, 100.0)  # above what is proved, where nothing is known to be refuted
_SURE = 1e-11  # per period: below it growth is rounding
_BEYOND = (1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
_BITS = (192, 512, 2048)
_LARGEST, _FEW, _DIRECTIONS, _SQUARINGS, _EXACT = (
    1e300,
    16,
    8,
    7,
    1e-9,
)  # eigenvectors of larger matrices: by a power of 2^7
_TAYLOR = [[1 / math.factorial(4 * i + j) for j in range(4)] for i in range(4)]


class Pattern(NamedTuple):
    """Which of the gains of a set holds for how long [s, samples], over and over."""

    which: tuple[int, ...]
    times: tuple[float, ...]


class Switching(NamedTuple):
    """For the classes of a factor: the end, 0 or 1, of every channel, step after step, and what a certificate needs."""

    factor: float
    ends: list[tuple[int, ...]]
    times: list[Fraction]
    squarings: int
    bits: int


@described(frozen=True)
class SwitchedGains(GainsAround):
    """The search for one plant, see :class:`GainsAround`, and the classes ``[l_i, alpha u_i]``."""

    lower: Reals = quantity("(m,) lower bounds at ``alpha = 1``")
    upper: Reals = quantity("(m,) upper bounds at ``alpha = 1``")
    varying: tuple[bool, ...] = quantity("Which gains may depend on time; the others stay at one end")
    blocks: tuple[range, ...] = quantity("The channels with one nonlinearity each, hence one gain")
    discrete: bool = quantity("Whether in discrete time")
    random: np.random.Generator = field(default_factory=lambda: np.random.default_rng(_SEED), repr=False)

    def sets(self) -> list[NDArray[np.int_]]:
        """For each choice of the ends that stay, the ends (k, m) between which a pattern may jump."""
        moving = [block for block in self.blocks if self.varying[block[0]]]
        still = [block for block in self.blocks if not self.varying[block[0]]]
        return [
            self._ends([*zip(still, stay, strict=True)], moving)
            for stay in self._choices(len(still), _MOST_SETS)
            if moving
        ]

    def _ends(self, fixed: list[tuple[range, int]], moving: list[range]) -> NDArray[np.int_]:
        found = []
        for choice in self._choices(len(moving), _MOST_ENDS):
            ends = np.zeros(len(self.lower), dtype=int)
            for block, end in (*fixed, *zip(moving, choice, strict=True)):
                ends[list(block)] = end
            found.append(ends)
        return np.array(found)

    def _choices(self, count: int, most: int) -> list[tuple[int, ...]]:
        if 2**count <= most:
            return list(product((0, 1), repeat=count))
        drawn = self.random.integers(0, 2, (most - 2, count))
        return sorted({(0,) * count, (1,) * count, *(tuple(int(v) for v in row) for row in drawn)})

    def closed(self, ends: NDArray[np.int_], alpha: float) -> Reals:
        """The matrices of the loop: (k, n, n).

        ``ends``: (k, m) of 0 and 1; ``alpha``: the factor.
        """
        return self.closed_by(np.where(ends == 1, alpha * self.upper, self.lower))

    def _steps(self, closed: Reals, times: Reals) -> Reals:
        if self.discrete:
            return np.array([np.linalg.matrix_power(G, int(t)) for G, t in zip(closed, times, strict=True)])
        return exponentials(closed * np.asarray(times)[:, None, None])

    def growth(self, ends: NDArray[np.int_], pattern: Pattern, alpha: float) -> float:
        """Logarithm of the spectral radius over one period.

        ``ends``: (k, m), the set; ``alpha``: the factor.
        """
        return self._slopes(self.closed(ends, alpha), pattern)[0]

    def _slopes(self, closed: Reals, pattern: Pattern) -> tuple[float, Reals]:
        """Logarithm of the spectral radius, and its derivatives by the times."""
        used = closed[list(pattern.which)]
        bins, each = Bins(self._steps(used, np.array(pattern.times))), np.arange(len(used))
        value, row, column = leading(bins.whole(each))
        return value, bins.slopes(each, row, column, used @ bins.steps).diagonal()

    def chosen(self, bins: Bins, choice: NDArray[np.int_]) -> tuple[NDArray[np.int_], float]:
        """The gains of each bin after the derivatives of the spectral radius have chosen, while that helps.

        ``bins``: the matrices over one bin with each of the gains; ``choice``: which of the gains at first.
        """
        best, row, column = leading(bins.whole(choice))
        for _ in range(_ROUNDS if best > -math.inf else 0):
            checkpoint()
            slopes = bins.slopes(choice, row, column)
            most = slopes.max(axis=1) - slopes[np.arange(len(choice)), choice]
            ranks = np.sort(most)[::-1]
            least = [max(float(ranks[int(share * (len(ranks) - 1))]), 1e-13) for share in (1.0, 0.3, 0.1, 0.0)]
            for one in dict.fromkeys(least):
                trial = np.where(most >= one, slopes.argmax(axis=1), choice)
                value, row, column = leading(bins.whole(trial))
                if value > best + 1e-13:
                    choice, best = trial, value
                    break
            else:
                break
        return choice, best

    def _periods(self, closed: Reals) -> list[float]:
        if self.discrete:
            return [float(p) for p in _PERIODS]
        values = np.linalg.eigvals(closed).ravel()
        turns = np.abs(values.imag)[np.abs(values.imag) > 1e-6 * np.abs(values).max()]
        size = np.abs(values).max()
        spread = [math.pi / size, 2 * math.pi / size, 4 * math.pi / size, 12 * math.pi / size]
        found = np.unique([*(math.pi / turns), *(2 * math.pi / turns), *spread]) if turns.size else np.array(spread)
        return [float(v) for v in found[np.unique(np.linspace(0, len(found) - 1, 8).astype(int))]]

    def at(self, ends: NDArray[np.int_], alpha: float) -> list[tuple[float, Pattern]]:
        """Patterns with growth at a factor, the best first; ``ends``: (k, m), the set."""
        found: dict[Pattern, float] = {}
        closed = self.closed(ends, alpha)
        for period in self._periods(closed):
            count = int(period) if self.discrete else _BINS
            bins = Bins(self._steps(closed, np.full(len(ends), period / count)))
            for start in self.drawn(bins, count):
                checkpoint()
                choice, value = self.chosen(bins, start)
                pattern = runs(choice, period / count)
                if value > _SURE and pattern is not None:
                    found[pattern] = value / period
        ranked = sorted(found.items(), key=lambda item: -item[1])
        return [(value, pattern) for pattern, value in ranked[:_KEPT]]

    def drawn(self, bins: Bins, count: int) -> NDArray[np.int_]:
        """The fastest of many patterns of so many bins in up to four runs: (_STARTS, count)."""
        table = bins.powers(count)
        which = self.random.integers(0, table.shape[1], (_DRAWN, 4))
        which[::2, 2:] = which[::2, :2]  # half of them with two runs
        cuts = np.sort(self.random.integers(0, count + 1, (_DRAWN, 3)), axis=1)
        times = np.diff(np.concatenate([np.zeros((_DRAWN, 1), int), cuts, np.full((_DRAWN, 1), count)], axis=1), axis=1)
        runs = (np.arange(count)[None, :, None] >= cuts[:, None, :]).sum(axis=2)
        _, first, same = np.unique(np.take_along_axis(which, runs, 1), axis=0, return_index=True, return_inverse=True)
        whole = table[times[first, 0], which[first, 0]]
        for i in range(1, 4):
            whole = table[times[first, i], which[first, i]] @ whole
        best = np.argsort(-_squared(whole)[1][same], kind="stable")[:_STARTS]
        return np.array([np.repeat(which[i], times[i]) for i in best])

    def faster(self, ends: NDArray[np.int_], pattern: Pattern, alpha: float) -> Pattern:
        """Times near the given ones with the largest growth per unit of time.

        ``ends``: (k, m), the set; ``alpha``: the factor.
        """
        if self.discrete:
            return pattern
        closed = self.closed(ends, alpha)

        def slow(logarithms: Reals) -> tuple[float, Reals]:
            """Negative growth per unit of time, and its gradient."""
            times = np.exp(logarithms)
            value, slopes = self._slopes(closed, Pattern(pattern.which, tuple(times)))
            if value == -math.inf:
                return 1e9, np.zeros(len(times))
            total = float(times.sum())
            return -value / total, -(slopes - value / total) / total * times

        start = np.log(pattern.times)
        found = optimize.minimize(
            slow, start, jac=True, method="L-BFGS-B", bounds=[(v - 6, v + 2) for v in start], options={"maxiter": 40}
        )
        times = np.exp(found.x)
        kept = times > 1e-4 * times.sum()
        better = Pattern(
            tuple(w for w, k in zip(pattern.which, kept, strict=True) if k), tuple(float(t) for t in times[kept])
        )
        return better if self.growth(ends, better, alpha) / times.sum() > -slow(start)[0] else pattern

    def threshold(self, ends: NDArray[np.int_], pattern: Pattern, low: float, high: float) -> float:
        """The factor where the growth of a pattern vanishes, if it grows at ``high`` and not at ``low``.

        ``ends``: (k, m), the set.
        """

        def value(alpha: float) -> float:
            """Growth, without rounding."""
            return max(self.growth(ends, pattern, alpha), -1.0) - _SURE

        if value(low) >= 0 or value(high) <= 0:
            return high
        return float(optimize.brentq(value, low, high, xtol=1e-12 * high, rtol=1e-12))

    def lowered(self, ends: NDArray[np.int_], pattern: Pattern, low: float, alpha: float) -> tuple[float, Pattern]:
        """A smaller factor with a pattern like a given one.

        Parameters
        ----------
        ends : ndarray
            (k, m), the set.
        pattern : Pattern
            Of it.
        low : float
            Nothing grows there.
        alpha : float
            There the pattern grows.
        """
        for _ in range(_DESCENTS):
            checkpoint()
            before = alpha
            pattern = self.faster(ends, pattern, alpha)
            alpha = self.threshold(ends, pattern, low, alpha)
            richer = self._richer(ends, pattern, alpha)
            if richer is not None:
                reached = self.threshold(ends, richer, low, alpha)
                pattern, alpha = (richer, reached) if reached < alpha else (pattern, alpha)
            if alpha > before * (1 - 1e-7):
                break
        short = _once(pattern)
        return (alpha, short) if self.growth(ends, short, alpha * (1 + 1e-9)) > _SURE else (alpha, pattern)

    def _richer(self, ends: NDArray[np.int_], pattern: Pattern, alpha: float) -> Pattern | None:
        """A pattern with other switches and growth."""
        total = sum(pattern.times)
        bins = round(total) if self.discrete else 2 * _BINS
        at = (np.arange(bins) + 0.5) * total / bins
        choice = np.array(pattern.which)[np.searchsorted(np.cumsum(pattern.times), at).clip(0, len(pattern.which) - 1)]
        steps = self._steps(self.closed(ends, alpha * (1 - 1e-6)), np.full(len(ends), total / bins))
        choice, _ = self.chosen(Bins(steps), choice)
        found = runs(choice, total / bins)
        if found is None or len(found.which) > _LONGEST:
            return None
        found = self.faster(ends, found, alpha)
        return found if self.growth(ends, found, alpha) > _SURE else None

    def found(self, low: float, most: float) -> tuple[float, NDArray[np.int_], Pattern] | None:
        """The smallest factor that was found, the ends and the pattern; None if nothing grows.

        ``low``: up to it the loop is stable.  ``most``: the largest factor of interest; infinity: none.
        """
        rungs = [most] if most < math.inf else [(low or 1.0) * step for step in _RUNGS]
        for alpha in rungs:
            hits = [(ends, pattern) for ends in self.sets() for _, pattern in self.at(ends, alpha)]
            if hits:
                reached = [(*self.lowered(ends, pattern, low, alpha), ends) for ends, pattern in hits[:_KEPT]]
                best, pattern, ends = min(reached, key=lambda one: one[0])
                return best, ends, pattern
        return None

    def proposals(self, low: float, most: float) -> Iterator[Switching]:
        """What to certify, the smallest factor first; nothing if no class depends on time or the plant is too large.

        ``low``: up to it the loop is stable.  ``most``: the largest factor of interest; infinity: none.
        """
        if not any(self.varying) or not 0 < len(self.A) <= MOST_STATES or low >= most:
            return
        with np.errstate(all="ignore"):  # products overflow where the loop grows fast; such values are never chosen
            found = self.found(low, most)
            if found is None:
                return
            alpha, ends, pattern = found
            times = [_short(t) for t in pattern.times]
            if self.discrete:  # sample after sample
                which = [w for w, t in zip(pattern.which, times, strict=True) for _ in range(int(t))]
                times = [Fraction(1)] * len(which)
            else:
                which = list(pattern.which)
            for step in _BEYOND:
                factor = min(alpha * (1 + step), most)
                near = Pattern(tuple(which), tuple(float(t) for t in times))
                rate = self.growth(ends, near, factor)
                if rate > _SURE:
                    enough = math.log(4 * len(self.A)) + 2
                    squarings = min(max(math.ceil(math.log2(enough / rate)) + 2, 0), 64)
                    rows = [tuple(int(v) for v in ends[w]) for w in which]
                    yield from (Switching(factor, rows, times, squarings, bits) for bits in _BITS)


class Bins:
    """The parts of a period, in each of which one of a few matrices holds, most of them many times in turn.

    Parameters
    ----------
    steps : ndarray
        (k, n, n), over one of them.
    """

    def __init__(self, steps: Reals) -> None:
        self.steps, self._doubled = steps, [steps]  # to the powers 1, 2, 4, ...
        self._table = np.broadcast_to(np.eye(steps.shape[-1]), (1, *steps.shape))

    def powers(self, most: int) -> Reals:
        """Powers of the matrices up to some and beyond: (.., k, n, n)."""
        while len(self._table) <= most:
            self._table = np.concatenate([self._table, self._table @ (self._table[-1] @ self.steps)])
        return self._table

    def _power(self, level: int) -> Reals:
        while len(self._doubled) <= level:
            self._doubled.append(self._doubled[-1] @ self._doubled[-1])
        return self._doubled[level]

    def whole(self, choice: NDArray[np.int_]) -> Reals:
        """The product over a period, whose first factor is on the right."""
        whole = np.eye(self.steps.shape[-1])
        for k, count in _lengths(choice):
            for level in range(count.bit_length()):
                if count >> level & 1:
                    whole = self._power(level)[k] @ whole
        return whole

    def slopes(
        self, choice: NDArray[np.int_], row: NDArray[Any], column: NDArray[Any], instead: Reals | None = None
    ) -> Reals:
        """The real part of ``row whole column`` with each of the matrices, or of others, in each part: (.., k)."""
        found, lengths, n = list[list[Reals]](), _lengths(choice), len(row)
        for start, order, turned in ((column, lengths, False), (row, lengths[::-1], True)):
            sides, last = list[Reals](), np.stack([start.real, start.imag], axis=1)
            for k, count in order:
                side = last
                for level in range((count - 1).bit_length()):
                    power = self._power(level)[k]
                    side = np.concatenate([side, (power.T if turned else power) @ side], axis=1)
                sides.append(side[:, : 2 * count])
                last = (self.steps[k].T if turned else self.steps[k]) @ sides[-1][:, -2:]
            found.append(sides)
        before, after = (np.concatenate(sides, axis=1).reshape(n, -1, 2) for sides in found)
        reached = ((self.steps if instead is None else instead) @ before.reshape(n, -1)).reshape(-1, *before.shape)
        return np.asarray(((reached * after[:, ::-1]).sum(axis=1) @ (1.0, -1.0)).T)


def _lengths(choice: NDArray[np.int_]) -> list[tuple[int, int]]:
    """What is chosen, and how many times in turn."""
    return [(which, len(list(same))) for which, same in groupby(choice.tolist())]


def leading(whole: Reals) -> tuple[float, NDArray[Any], NDArray[Any]]:
    """Log of the spectral radius, and the row and the column of that eigenvalue with ``row whole column = 1``."""
    nothing = -math.inf, np.zeros(len(whole)), np.zeros(len(whole))
    if not np.abs(whole).max() < _LARGEST:
        return nothing
    row = column = None
    if len(whole) > _FEW:
        power, _ = _squared(whole)
        row, column = _fastest(whole.T, power.T), _fastest(whole, power)
    if row is None or column is None:
        values, vectors = np.linalg.eig(whole)
        k = int(np.abs(values).argmax())
        try:
            row, column = np.linalg.inv(vectors)[k], vectors[:, k]
        except np.linalg.LinAlgError:
            return nothing
    size = row @ whole @ column
    value = size / (row @ column)
    return (math.log(abs(value)), row / size, column) if 0 < abs(value) < math.inf else nothing


def _fastest(whole: Reals, power: Reals) -> NDArray[Any] | None:
    """The eigenvector of the spectral radius, in what a high power makes of a few directions; None if not seen."""
    sides, _ = np.linalg.qr(power @ _directions(len(whole)))
    values, vectors = np.linalg.eig(sides.T @ whole @ sides)
    vectors = sides @ vectors
    off = np.abs(whole @ vectors - values * vectors).max(axis=0)
    sizes = np.where(off <= _EXACT * np.abs(values), np.abs(values), 0.0)  # the others are of rounding
    k = int(sizes.argmax())
    vector = vectors[:, k] if values[k].imag >= 0 else vectors[:, k].conj()
    return np.asarray(vector) if sizes[k] > 0 else None


@lru_cache(maxsize=32)
def _directions(n: int) -> Reals:
    return np.random.default_rng(_SEED).standard_normal((n, _DIRECTIONS))


def _squared(power: Reals) -> tuple[Reals, Reals]:
    """High powers of matrices, times a number, and roughly the logs of their spectral radii: by how the powers grow."""
    power = np.where(np.isfinite(power), power, 0.0)
    logs = grown = np.zeros(power.shape[:-2])
    for level in range(_SQUARINGS + 1):
        power = power @ power if level else power
        size = np.maximum(np.abs(power).max(axis=(-2, -1)), 1e-300)
        power, grown = power / size[..., None, None], logs + np.log(size)  # from half of the power to the whole
        logs = logs + grown
    return power, grown / 2.0 ** (_SQUARINGS - 1)


def exponentials(X: Reals) -> Reals:
    """``exp`` of each of many small matrices: Taylor's formula to order 15, and squarings.

    ``X``: (.., n, n).
    """
    size = float(np.abs(X).sum(axis=-1).max())
    halvings = max(0, math.ceil(math.log2(max(size, 1e-300))) + 1) if size < 2.0**40 else 41
    X = X / 2.0**halvings
    square = X @ X
    powers = np.array([np.broadcast_to(np.eye(X.shape[-1]), X.shape), X, square, X @ square])
    terms, fourth = np.tensordot(_TAYLOR, powers, 1), square @ square
    found = terms[3]
    for term in terms[2::-1]:
        found = term + fourth @ found
    for _ in range(halvings):
        found = found @ found
    return np.asarray(found)


def runs(choice: NDArray[np.int_], width: float) -> Pattern | None:
    """The pattern of bins, equal neighbours together and repetitions left out; None if nothing changes."""
    bins = len(choice)
    edges = [i for i in range(bins) if choice[i] != choice[i - 1]]
    if not edges:
        return None
    turned = [int(v) for v in np.roll(choice, -edges[0])]
    period = next(p for p in range(1, bins + 1) if bins % p == 0 and turned == turned[:p] * (bins // p))
    runs = [(which, len(list(same))) for which, same in groupby(turned[:period])]
    return Pattern(tuple(which for which, _ in runs), tuple(count * width for _, count in runs))


def _once(pattern: Pattern) -> Pattern:
    """The first of the repetitions of a pattern."""
    count = len(pattern.which)
    fits = (p for p in range(1, count + 1) if count % p == 0 and pattern.which == pattern.which[:p] * (count // p))
    period = next(fits)
    return Pattern(pattern.which[:period], pattern.times[:period])


def _short(value: float) -> Fraction:
    """A double cut to 40 bits."""
    mantissa, exponent = math.frexp(value)
    return Fraction(round(math.ldexp(mantissa, 40))) * Fraction(2) ** (exponent - 40)
