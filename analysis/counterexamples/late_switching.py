"""Gains beside dead times, in floating point: constant ones, and patterns with a solution ``x(t + P) = rho x(t)``.

A first search takes steps of a fraction of the longest dead time, over which what arrives late is interpolated between
samples.  Then the period is made a multiple ``q h`` of a common part ``h`` of the dead times: with ``X_j(t) = x(t + j
h)`` the solution over a period is one of ``X' = L(rho) X`` on ``[0, h]``, and ``det(S(rho) - Phi(rho)) = 0``.  Then the
times are shifted until ``|rho| = 1`` at the smallest factor of the classes, or ``|rho|`` is the largest.

With constant gains the rightmost roots are those of ``det(s - A_0 - sum A_k e^(-s T_k))``: eigenvalues of the
generator, collocated at Chebyshev's points (Breda, Maset, Vermiglio 2005), from which Newton's method goes to roots.
Nothing here is believed: a checker decides.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import Any, NamedTuple

from lure.analysis.counterexamples.channel_switching import Bins, Pattern, SwitchedGains, exponentials, leading, runs
from lure.analysis.deadline import checkpoint
from lure.analysis.verdict import Evidence, Witness
from lure.arrays import NDArray, Reals, np, optimize
from lure.plants.delay import DelayPlant
from lure.plants.delay_matrix import DelayMatrix, one_channel_of
from lure.record import described, quantity

_LEAST_NODES, _MOST_NODES, _NEWTON, _ROOTS, _AT_ROOT = 12, 60, 12, 6, 1e-13
_AT_DOUBLE_ROOT = 1e-7  # of Newton's steps near a root that is not simple
BITS = 128, 256
_NOTHING = 1e300  # in place of infinity, of which no difference is a number
_BINS, _SAMPLES, _MOST_STATES, _MOST_PARTS = (
    72,
    48,
    12,
    64,
)  # of half a turn; what is kept of the past; of the plant; of X
_SLOW, _LOWER, _RANK = 1e-3, 0.03, 1e-12
_SHARE = 0.99  # of what the circle criterion proves, on some frequencies
_PERIODS = (((0.97, 1.07), 0.0), ((1.95, 2.06), 0.025), ((0.4, 2.6), 0.22))  # half turns: from, to, step
_PATTERNS, _GRIDS, _DESCENTS = 3, 3, 4
_RUNGS = (1.2, 2.0, 5.0, 20.0)  # above what is proved, where nothing is known to be refuted
_NEAR = (3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1)  # from a first estimate
_BEYOND = (1e-8, 1e-7, 1e-6, 1e-5, 1e-4)
_ABOVE = tuple(10.0**-k for k in range(9, 1, -1))  # 1: multipliers
_WIDTH, _SECANTS, _CLOSE = 0.5, 8, 1e-11  # of the logarithm of a ratio of times
_SURE, _REAL, _SMALL = 1e-9, 1e-6, 4e-4  # of a grid: what a state more costs, as a share of the period


class LateRoots:
    """The roots of a plant that is no neutral equation, for gains that are to come.

    Parameters
    ----------
    plant : DelayMatrix
        The plant.
    """

    def __init__(self, plant: DelayMatrix) -> None:
        self.sides, self.delays = plant.base.doubles(), tuple(float(delay) for delay, _ in plant.late)
        self.seen = [np.array(rows, dtype=float) for _, rows in plant.late]
        none = np.zeros((plant.order,) * 2)
        self.back = [np.array(rows, dtype=float) for rows in plant.inner] or [none] * len(self.seen)

    @cached_property
    def _nodes(self) -> int:
        size = float(np.abs(np.linalg.eigvals(self.sides[0])).max()) * self.delays[-1]
        return min(max(_LEAST_NODES, math.ceil(4 * size)), _MOST_NODES)

    def closed(self, gains: Reals) -> tuple[NDArray[np.float64], list[NDArray[np.float64]]]:
        """``A_0`` and the ``A_k`` with ``mu = -g sigma``; ``gains``: (m,), one of each channel."""
        A, B, C, D = self.sides
        closed = np.linalg.solve(np.eye(len(D)) + np.diag(gains) @ D, np.diag(gains))
        return A - B @ closed @ C, [own - B @ closed @ side for own, side in zip(self.back, self.seen, strict=True)]

    def spectrum(self, gains: Reals) -> NDArray[np.complex128]:
        """Eigenvalues of the collocated generator, the rightmost first; ``gains``: (m,), one of each channel."""
        checkpoint()
        now, later = self.closed(gains)
        weights, turn = _collocation(self._nodes, self.delays)
        n = len(now)
        whole = np.kron(turn, np.eye(n))
        whole[:n] = np.kron(weights[0], now) + sum(np.kron(w, M) for w, M in zip(weights[1:], later, strict=True))
        roots = np.linalg.eigvals(whole).astype(complex)
        return np.asarray(roots[np.argsort(-roots.real)])

    def rightmost(self, gains: Reals) -> complex:
        """The rightmost root to which Newton's method goes; of a pair that with ``Im s >= 0``.

        ``gains``: (m,), one of each channel.
        """
        now, later = self.closed(gains)
        one, found, starts = np.eye(len(now)), list[complex](), self.spectrum(gains)
        for start in starts[: _ROOTS * len(now)]:
            s = complex(start)
            for _ in range(_NEWTON):
                waits = [np.exp(-s * delay) * M for delay, M in zip(self.delays, later, strict=True)]
                slope = one + sum(delay * M for delay, M in zip(self.delays, waits, strict=True))
                try:
                    step = 1 / np.trace(np.linalg.solve(s * one - now - sum(waits), slope))
                except np.linalg.LinAlgError:  # a root
                    step = 0.0
                s -= step
                if abs(step) <= _AT_ROOT * abs(s):
                    break
            if abs(step) <= _AT_DOUBLE_ROOT * abs(s):
                found.append(complex(s.real, abs(s.imag)))
        return max(found, key=lambda s: s.real, default=complex(starts[0]))


@lru_cache(maxsize=8)
def _collocation(count: int, delays: tuple[float, ...]) -> tuple[list[NDArray[np.float64]], NDArray[np.float64]]:
    """Rows that interpolate at 0 and at each ``-T_k`` from Chebyshev's points on ``[-T, 0]``, and the derivative."""
    angles = np.pi * np.arange(count + 1) / count
    points = (np.cos(angles) - 1) * delays[-1] / 2
    signs = (-1.0) ** np.arange(count + 1)
    signs[[0, -1]] /= 2
    gaps = points[:, None] - points + np.eye(count + 1)
    turn = signs / signs[:, None] / gaps
    np.fill_diagonal(turn, 0)
    np.fill_diagonal(turn, -turn.sum(axis=1))
    rows = [np.eye(count + 1)[:1]]
    for delay in delays:
        away = -delay - points
        at = np.abs(away) < 1e-14 * delays[-1]
        row = at.astype(float) if at.any() else signs / away
        rows.append((row / row.sum())[None])
    return rows, turn


class LatePattern(NamedTuple):
    """For the classes of a factor: the end, 0 or 1, of each channel in turn, and what a certificate needs."""

    factor: float
    ends: list[tuple[int, ...]]
    times: list[Fraction]
    multiplier: tuple[Fraction, Fraction]
    bits: int

    @property
    def numbers(self) -> dict[str, Any]:
        """What a certificate has of them beside the gains."""
        return {"times": [*map(str, self.times)], "multiplier": [*map(str, self.multiplier)], "bits": self.bits}


@described()
class LateSwitching:
    """The search for one plant that is no neutral equation, and the classes ``[l_i, alpha u_i]``."""

    plant: DelayMatrix = quantity("The plant")
    lower: Reals = quantity("(m,) lower bounds at ``alpha = 1``")
    upper: Reals = quantity("(m,) upper bounds at ``alpha = 1``")
    varying: tuple[bool, ...] = quantity("Which gains may depend on time; the others stay at one end")
    blocks: tuple[range, ...] = quantity("The channels with one nonlinearity each")
    _half: float = 0.0
    _bin: float = 0.0

    @cached_property
    def _jumps(self) -> SwitchedGains:
        sides = self.plant.base.doubles()
        return SwitchedGains(*sides, self.lower, self.upper, varying=self.varying, blocks=self.blocks, discrete=False)

    @cached_property
    def _roots(self) -> LateRoots:
        return LateRoots(self.plant)

    @cached_property
    def _late(self) -> Reals:
        """Rows (r, n) of what arrives late of the state."""
        _, sizes, rows = np.linalg.svd(np.vstack([*self._roots.seen, *self._roots.back]))
        return np.asarray(rows[: max(int((sizes > _RANK * sizes[0]).sum()), 1)])

    @cached_property
    def _common(self) -> Fraction:
        """The greatest common part of the dead times."""
        found = Fraction(0)
        for part, _ in self.plant.late:
            one = part
            while one:
                found, one = one, found % one
        return found

    def _begin(self, alpha: float) -> None:
        """About half a turn of the loop with the upper gains [s], and steps of which the longest dead time has some."""
        roots, most = self._roots.spectrum(alpha * self.upper)[: 4 * self.plant.order], self._roots.delays[-1]
        turns = roots[roots.imag > _SLOW * np.abs(roots).max()]
        self._half = math.pi / float(turns[0].imag) if len(turns) else 2 * most
        self._bin = most / max(min(round(_BINS * most / self._half), _SAMPLES // len(self._late)), 1)

    def _counts(self) -> list[int]:
        """Periods that are tried, in steps: close to a half and a whole turn one after the other, some others."""
        half, found = self._half / self._bin, set[int]()
        for (low, high), step in _PERIODS:
            found |= {*range(round(low * half), round(high * half) + 1, max(round(step * half), 1))}
        return sorted(count for count in found if 2 <= count <= 4 * _BINS)

    def _closed(self, ends: NDArray[np.int_], alpha: float) -> list[list[Reals]]:
        """For each row of ends the matrices of the loop, of what arrives at once and after each dead time."""
        rows = np.where(ends == 1, alpha * self.upper, self.lower)
        return [[now, *later] for now, later in (self._roots.closed(row) for row in rows)]

    def _steps(self, ends: NDArray[np.int_], alpha: float) -> Reals:
        """Over one step: of ``x`` and of the samples before it of what arrives late, from any gains."""
        n, h, delays = self.plant.order, self._bin, self._roots.delays
        closed = self._closed(ends, alpha)
        R, back = self._late, math.ceil(delays[-1] / h) + 1
        r = len(R)
        found = []
        for now, *later in closed:
            wide = np.zeros((n * 3,) * 2)  # x' = A x + u + (v - u) t/h
            wide[:n] = np.hstack([now * h, np.eye(n) * h, np.zeros((n, n))])
            wide[n : 2 * n, 2 * n :] = np.eye(n)
            flow = exponentials(wide)[:n]
            Z = np.zeros((n + back * r,) * 2)
            Z[:n, :n] = flow[:, :n]
            Z[n : n + r, :n] = R
            Z[n + r :, n : n + (back - 1) * r] = np.eye((back - 1) * r)
            for tau, M in zip(delays, later, strict=True):
                into = M @ R.T
                for side, at in ((flow[:, n : 2 * n] - flow[:, 2 * n :], tau / h), (flow[:, 2 * n :], tau / h - 1)):
                    before = max(at, 0.0)
                    k, part = int(before), before - int(before)
                    for sample, share in ((k, 1 - part), (k + 1, part)):
                        if not share:
                            continue
                        if sample:
                            Z[:n, n + (sample - 1) * r : n + sample * r] += share * side @ into
                        else:
                            Z[:n, :n] += share * side @ into @ R
            found.append(Z)
        return np.array(found)

    def _hits(self, alpha: float) -> list[tuple[float, NDArray[np.int_], NDArray[np.int_]]]:
        """Growth in a unit of time, the set of ends and which of them in each step; the largest first."""
        found = []
        for ends in self._jumps.sets():
            bins = Bins(self._steps(ends, alpha))
            for count in self._counts():
                starts = [*self._jumps.drawn(bins, count)]
                starts += [(np.arange(count) * 6 >= count).astype(int) * (len(ends) - 1)]
                for start in starts:
                    checkpoint()
                    choice, value = self._jumps.chosen(bins, start)
                    found.append((value / (count * self._bin), ends, choice))
        return sorted(found, key=lambda one: -one[0])

    def _lowered(
        self, ends: NDArray[np.int_], choice: NDArray[np.int_], low: float, alpha: float
    ) -> tuple[float, NDArray[np.int_]]:
        """The factor at which the first search sees the growth of a pattern, and of those near by, end."""

        def value(factor: float) -> float:
            """The growth over one period."""
            return leading(Bins(self._steps(ends, factor)).whole(choice))[0]

        for _ in range(_DESCENTS):
            checkpoint()
            if value(low) >= 0 or value(alpha) <= 0:
                break
            before, alpha = alpha, float(optimize.brentq(value, low, alpha, rtol=1e-6))
            choice, better = self._jumps.chosen(Bins(self._steps(ends, alpha)), choice)
            if better < _SURE or alpha > before * (1 - 1e-5):
                break
        return alpha, choice

    def determinant(
        self, closed: Sequence[Sequence[Reals]], pattern: Pattern, grid: tuple[int, Fraction], rho: float
    ) -> float:
        """``det(S - Phi)`` of a pattern whose times add up to ``q h``.

        Parameters
        ----------
        closed : sequence of sequence of ndarray
            The matrices with each of the gains, of what arrives at once and after each dead time.
        pattern : Pattern
            Which gains for how long.
        grid : (int, Fraction)
            ``q`` and ``h`` [s].
        rho : float
            The multiplier.
        """
        (q, part), n = grid, self.plant.order
        h, until = float(part), np.cumsum(pattern.times)
        waits = [0, *(int(tau / part) for tau, _ in self.plant.late)]
        cuts = np.unique(np.concatenate([[0.0, h], until[:-1] % h]))
        cuts = cuts[np.concatenate([[True], np.diff(cuts) > 1e-14 * h])]
        middles, j = (cuts[1:] + cuts[:-1]) / 2, np.arange(q)
        at = np.searchsorted(until, j * h + middles[:, None]).clip(0, len(until) - 1)
        L, G = np.zeros((len(middles), q, n, q, n)), np.array(closed)[np.array(pattern.which)[at]]
        for k, wait in enumerate(waits):
            laps, place = np.divmod(j - wait, q)
            L[:, j, :, place] += (rho ** laps.astype(float))[:, None, None, None] * G[:, :, k].swapaxes(0, 1)
        Phi = np.eye(q * n)
        for step in exponentials(L.reshape(-1, q * n, q * n) * np.diff(cuts)[:, None, None]):
            Phi = step @ Phi
        S = np.roll(np.eye(q * n), n, axis=1)
        S[(q - 1) * n :, :n] *= rho
        return float(np.linalg.det(S - Phi))

    def _grids(self, period: float) -> list[tuple[int, Fraction]]:
        """Multiples of parts of the dead times near a period, the nearest first."""
        most = _MOST_PARTS // self.plant.order
        tried = {
            Fraction(q, parts): (q, self._common / parts)
            for parts in range(1, 2 * most)
            for q in [round(period * parts / float(self._common))]
            if 0 < q <= most
        }
        near = sorted(
            tried.values(),
            key=lambda grid: abs(math.log(grid[0] * float(grid[1]) / period)) + _SMALL * grid[0] * self.plant.order,
        )
        return near[:_GRIDS]

    def _best(
        self, pattern: Pattern, grid: tuple[int, Fraction], judged: Callable[[Pattern], float]
    ) -> tuple[float, Pattern]:
        """The least of what is judged, with times near the given ones that add up to the period of a grid."""
        period = grid[0] * float(grid[1])
        start = np.log(np.array(pattern.times[:-1]) / pattern.times[-1])

        def at(shares: Reals) -> Pattern:
            """The pattern of these logarithms of times, over the last one."""
            weights = np.exp(np.append(shares, 0.0))
            return Pattern(pattern.which, tuple(float(v) for v in period * weights / weights.sum()))

        if not len(start):
            return judged(at(start)), at(start)

        def value(shares: Reals) -> float:
            """What is judged of them."""
            return min(judged(at(shares)), _NOTHING)

        if len(start) == 1:
            ends, options = (start[0] - _WIDTH, start[0] + _WIDTH), {"xatol": 3e-4}
            found = optimize.minimize_scalar(value, bounds=ends, method="bounded", options=options)
        else:
            options = {"maxfev": 25 * len(start), "xatol": 1e-3, "fatol": 1e-9}
            found = optimize.minimize(value, start, method="Nelder-Mead", options=options)
        return float(found.fun), at(found.x)

    def _threshold(
        self, ends: NDArray[np.int_], grid: tuple[int, Fraction], sign: int, near: float
    ) -> Callable[[Pattern], float]:
        """The factor at which a pattern has the multiplier ``sign``, near an estimate; infinity if none is seen."""

        def judged(pattern: Pattern) -> float:
            """That factor."""
            checkpoint()
            return _root(lambda alpha: self.determinant(self._closed(ends, alpha), pattern, grid, sign), near)

        return judged

    def proposals(self, low: float, most: float) -> Iterator[LatePattern]:
        """What to certify; nothing if no class depends on time, or the dead times have no common part that serves.

        ``low``: up to it the loop is stable.  ``most``: the largest factor of interest; infinity: none.
        """
        if not any(self.varying) or self.plant.rates or not 0 < self.plant.order <= _MOST_STATES or low >= most:
            return
        with np.errstate(all="ignore"):
            for alpha in [most] if most < math.inf else [(low or 1.0) * step for step in _RUNGS]:
                reached = self._reached(low, alpha)
                if reached:
                    yield from self._certifiable(reached, most)
                    return

    def _reached(self, low: float, alpha: float) -> list[tuple[float, NDArray[np.int_], NDArray[np.int_]]]:
        """The factors at which patterns seem to end, these and their sets of ends, the smallest factor first."""
        best: list[tuple[float, NDArray[np.int_], NDArray[np.int_]]] = []
        for _ in range(_DESCENTS):
            self._begin(alpha)
            found = [hit for hit in self._hits(alpha) if hit[0] > _SURE][:_PATTERNS]
            if not found:
                break
            lowered = [(*self._lowered(ends, choice, low, alpha), ends) for _, ends, choice in found]
            best, before, alpha = sorted(lowered, key=lambda one: one[0]), alpha, min(one[0] for one in lowered)
            if alpha > before * (1 - _LOWER):  # else another period may serve
                break
        return best

    def _certifiable(
        self, lowered: list[tuple[float, NDArray[np.int_], NDArray[np.int_]]], most: float
    ) -> Iterator[LatePattern]:
        """The pattern of the smallest factor, on a grid of the dead times."""
        best: tuple[float, Pattern, NDArray[np.int_], tuple[int, Fraction], int] | None = None
        for alpha, choice, ends in lowered:
            found = self._pattern(ends, choice, alpha)
            if found is None:
                continue
            short, sign = found
            for grid in self._grids(sum(short.times)):
                factor, one = self._best(short, grid, self._threshold(ends, grid, sign, alpha))
                if factor < math.inf and (best is None or factor < best[0]):
                    best = factor, one, ends, grid, sign
            if best is not None:
                break
        if best is None:
            return
        alpha, pattern, ends, grid, sign = best
        times, rows = _exact(pattern.times, grid), [tuple(int(v) for v in ends[k]) for k in pattern.which]
        for factor in (min(float(f"{alpha * (1 + step):.10g}"), most) for step in _BEYOND):  # of few digits
            rho = self._grown(self._closed(ends, factor), Pattern(pattern.which, tuple(map(float, times))), grid, sign)
            if rho < math.inf:
                a, b = sorted(sign * (1 + Fraction(f"{(rho - 1) * share:.2g}")) for share in (0.5, 1.5))
                yield from (LatePattern(factor, rows, times, (a, b), bits) for bits in BITS)

    def slower(self, rate: float) -> Iterator[tuple[Fraction, LatePattern]]:
        """Patterns of the classes themselves that decay more slowly than a rate, and what rates they seem to refute.

        ``rate``: that of constant gains.
        """
        if not any(self.varying) or self.plant.rates or not 0 < self.plant.order <= _MOST_STATES:
            return
        with np.errstate(all="ignore"):
            self._begin(1.0)
            for growth, ends, choice in [hit for hit in self._hits(1.0) if hit[0] > -rate + _SURE][:_PATTERNS]:
                found = self._pattern(ends, choice, 1.0)
                if found is None:
                    continue
                short, sign = found
                tried = [
                    (*self._best(short, grid, self._decay(self._closed(ends, 1.0), grid, sign, growth)), grid)
                    for grid in self._grids(sum(short.times))
                ]
                least, pattern, grid = min(tried, key=lambda one: one[0], default=(rate, short, None))
                if grid is None or least >= rate:
                    continue
                times = _exact(pattern.times, grid)
                one, period = Pattern(pattern.which, tuple(map(float, times))), float(grid[0] * grid[1])
                left = self._decay(self._closed(ends, 1.0), grid, sign, -least)(one)
                rows = [tuple(int(v) for v in ends[k]) for k in pattern.which]
                for near in _BEYOND:
                    sizes = [sign * math.exp(-left * period) * (1 + near * side) for side in (-1, 1)]
                    slower = Fraction(left + 2 * near / period).limit_denominator(10**12)
                    a, b = sorted(map(Fraction, sizes))
                    yield from ((slower, LatePattern(1.0, rows, times, (a, b), bits)) for bits in BITS)
                return

    def _decay(
        self, closed: Sequence[Sequence[Reals]], grid: tuple[int, Fraction], sign: int, growth: float
    ) -> Callable[[Pattern], float]:
        """The rate of a pattern by its multiplier of that sign, near an estimate; infinity if none is seen."""
        period = float(grid[0] * grid[1])

        def judged(pattern: Pattern) -> float:
            """That rate."""
            checkpoint()
            rho = _root(lambda rho: self.determinant(closed, pattern, grid, sign * rho), math.exp(growth * period))
            return -math.log(rho) / period if 0 < rho < math.inf else math.inf

        return judged

    def _pattern(self, ends: NDArray[np.int_], choice: NDArray[np.int_], alpha: float) -> tuple[Pattern, int] | None:
        """The pattern and the sign of its multiplier, if it is real; of two halves alike, each by ``-1``, one."""
        found = runs(choice, self._bin)
        if found is None:
            return None
        whole = Bins(self._steps(ends, alpha)).whole(choice[: round(sum(found.times) / self._bin)])
        values = np.linalg.eigvals(whole).astype(complex)
        rho = values[np.abs(values).argmax()]
        if abs(rho.imag) > _REAL * abs(rho):
            return None
        which, times, half = found.which, found.times, len(found.which) // 2
        if rho.real > 0 and half and which[:half] == which[half:]:
            return Pattern(which[:half], tuple((a + b) / 2 for a, b in zip(times, times[half:], strict=False))), -1
        return found, 1 if rho.real > 0 else -1

    def _grown(
        self, closed: Sequence[Sequence[Reals]], pattern: Pattern, grid: tuple[int, Fraction], sign: int
    ) -> float:
        """The modulus of the multiplier of that sign, just above 1; infinity if none is seen."""
        last = 1 + 1e-13
        start = self.determinant(closed, pattern, grid, sign * last)

        def value(size: float) -> float:
            """The determinant there."""
            return self.determinant(closed, pattern, grid, sign * size)

        for step in _ABOVE:
            if start * value(1 + step) < 0:
                return float(optimize.brentq(value, last, 1 + step, rtol=1e-14, xtol=1e-15))
            last = 1 + step
        return math.inf


def late_witness(block: DelayPlant, most: float) -> Iterator[Witness]:
    """Gains that jump between 0 and ``k`` beside dead time with a solution that grows, as floating point has it.

    They are said to be CERTIFIED, which is for a checker to decide.

    ``block``: the block, stable without feedback.  ``most``: the smallest destabilising linear gain; infinity: none.
    """
    omega = np.geomspace(1e-4, 1e4, 8001) / float(max(delay for delay, _ in (*block.terms, *block.feedback)))
    least = float(block.transfer(1j * omega).real.min())
    if not len(block.denominator) > 1 or least >= 0:  # the circle criterion serves for every k
        return
    zero, one = np.zeros(1), np.ones(1)
    search = LateSwitching(one_channel_of(block), zero, one, (True,), (range(1),))
    for found in search.proposals(-_SHARE / least, most):
        k = Fraction(found.factor)
        gains = [k if end else Fraction(0) for (end,) in found.ends]
        period = f"period {float(sum(found.times)):.6g} s"
        yield Witness(
            kind="switched gain",
            k=found.factor,
            evidence=Evidence.CERTIFIED,
            slope_restricted=True,
            odd=True,
            time_varying=True,
            description=f"phi(t, sigma) = k(t) sigma, k(t) switching between 0 and {found.factor:.9g} with {period}: "
            "a solution grows without bound",
            data=MappingProxyType({"lower": "0", "upper": str(k), "gains": [*map(str, gains)], **found.numbers}),
        )


def _root(value: Callable[[float], float], near: float) -> float:
    """Where a function vanishes near a number, by secants, or else changes its sign; infinity if that is not seen."""
    last, new, at = near, near * (1 + _NEAR[0]), value(near)
    for _ in range(_SECANTS):
        before, now = at, value(new)
        if not 0 < abs(now - before) < math.inf:
            break
        last, new, at = new, new - now * (new - last) / (now - before), now
        if abs(new - last) <= _CLOSE * abs(new):
            return new
        if not abs(new - near) <= _NEAR[-1] * near:
            break
    at = value(near)
    sides = {1: (near, at), -1: (near, at)}
    for step, side in ((step, side) for step in _NEAR for side in sides):
        last, before = sides[side]
        other = near * (1 + side * step)
        now = value(other)
        if before * now < 0:
            return float(optimize.brentq(value, *sorted((last, other)), rtol=1e-11))
        sides[side] = other, now
    return math.inf


def _exact(times: Sequence[float], grid: tuple[int, Fraction]) -> list[Fraction]:
    """Times of few digits that add up to the period."""
    period = grid[0] * grid[1]
    found = [Fraction(round(t / float(period) * 2**30), 2**30) * period for t in times[:-1]]
    return [*found, period - sum(found, Fraction(0))]
