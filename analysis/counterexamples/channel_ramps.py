"""Gains of several channels that move no faster than a rate, over and over, in floating point.

A gain goes up at its rate from one level to another, stays, goes down, stays: bounds on a gain and on its rate leave
little else to the worst of them.  Over one period the state is multiplied by a matrix ``M``; with an eigenvalue outside
the unit disc some solution grows.  Levels and stays are moved downhill from a few of each, then the factor of the
classes is lowered, again and again.  That finds a good pattern, not the worst; a checker decides.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from itertools import product
from typing import NamedTuple

from lure.analysis.counterexamples.channel_gains import GainsAround
from lure.analysis.counterexamples.channel_switching import SwitchedGains, exponentials
from lure.analysis.deadline import checkpoint
from lure.arrays import NDArray, Reals, np, optimize
from lure.classes import Diagonal
from lure.plants.channel_family import ChannelFamily
from lure.record import described, quantity

MOST_STATES, MOST_SAMPLES = 12, 400
_STEPS, _MOST_STEPS, _KEPT, _ROUNDS, _MOST_SETS, _CLOSE = 8, 48, 2, 7, 4, 1e-3
_LEVELS = ((0.0, 1.0), (0.0, 0.5), (0.5, 1.0), (0.65, 1.0), (0.0, 0.35))
_STAYS = (0.02, 0.25, 0.5, 1.0)  # of half a period of the fastest turn between the ends
_RUNGS = (1.5, 6.0)
_SURE, _BEYOND, _BITS = 1e-9, (1e-7, 1e-6, 1e-5, 1e-4, 1e-3), (192, 512)


class Ramps(NamedTuple):
    """For the classes of a factor: lists of gains, how long from one to the next, and what a certificate needs."""

    factor: float
    gains: list[list[Fraction]]
    times: list[Fraction]
    squarings: int
    bits: int


class _Shape(NamedTuple):
    """Shares of the intervals between which the gains move, and how long they stay at the upper and lower end."""

    low: float
    high: float
    above: float
    below: float

    def inside(self) -> _Shape:
        """The nearest shape that there is."""
        low, high = sorted((min(max(self.low, 0.0), 1.0), min(max(self.high, 0.0), 1.0)))
        return _Shape(low, high, max(self.above, 0.0), max(self.below, 0.0))


_Set = tuple[tuple[int, ...], tuple[int, ...]]  # the blocks that move, and the ends at which the others stay


@described(frozen=True)
class RampedGains(GainsAround):
    """The search for one plant, see :class:`GainsAround`, and the classes ``[l_i, alpha u_i]``."""

    lower: Sequence[Fraction] = quantity("Lower bounds at ``alpha = 1``")
    upper: Sequence[Fraction] = quantity("Upper bounds at ``alpha = 1``")
    rates: Sequence[Fraction | None] = quantity("For each block how fast its gain may change, None for one that stays")
    blocks: Sequence[range] = quantity("The channels with one gain each")
    discrete: bool = quantity("Whether in discrete time")

    def _sets(self) -> list[_Set]:
        """Which blocks move, together or one alone, and the end, 0 or 1, at which each of the others stays."""
        free = [j for j, rate in enumerate(self.rates) if rate is not None and self._alone(self.blocks[j])]
        groups = [*dict.fromkeys([tuple(free), *((j,) for j in free)])] if free else []
        found = []
        for group in groups:
            still = len(self.blocks) - len(group)
            ends = [*product((1, 0), repeat=still)][:_MOST_SETS]
            found += [(group, one) for one in ends]
        return found

    def _alone(self, block: range) -> bool:
        """Whether its gain enters the matrix of the loop affinely."""
        return self.discrete or not self.D[list(block)].any()

    def _top(self, i: int, alpha: Fraction) -> Fraction:
        """The upper end of a gain."""
        return alpha * self.upper[i]

    def _gains(
        self, moving: tuple[int, ...], ends: tuple[int, ...], share: Fraction, alpha: Fraction
    ) -> list[Fraction]:
        """One gain a channel: of those that move this share of the interval above the lower end."""
        found, rest = [Fraction(0)] * len(self.lower), iter(ends)
        for j, block in enumerate(self.blocks):
            part = share if j in moving else Fraction(next(rest))
            for i in block:
                found[i] = self.lower[i] + part * (self._top(i, alpha) - self.lower[i])
        return found

    def _rise(self, moving: tuple[int, ...], alpha: Fraction) -> Fraction:
        """How long the slowest of the gains takes from one end to the other."""
        times = list[Fraction]()
        for j in moving:
            i, rate = self.blocks[j][0], self.rates[j]
            assert rate is not None, "it moves"
            times.append((self._top(i, alpha) - self.lower[i]) / rate)
        return max(times)

    def _shares(self, shape: Sequence[Fraction], needed: Fraction) -> tuple[list[Fraction], list[Fraction]]:
        """The shares of the intervals in their order, as near in discrete time as the rate permits, and the times."""
        low, high, above, below = shape
        if self.discrete:
            steps, stays = max(math.ceil(needed), 1), [round(float(v)) for v in (above, below)]
            up = [low + (high - low) * i / steps for i in range(steps)]
            down = [high - (high - low) * i / steps for i in range(steps)]
            found = [*up, *[high] * stays[0], *down, *[low] * stays[1]]
            return found, [Fraction(1)] * len(found)
        both = [(low, needed), (high, above), (high, needed), (low, below)]
        kept = [(share, time) for share, time in both if time > 0]
        return [share for share, _ in kept], [time for _, time in kept]

    def _pattern(self, which: _Set, shape: _Shape, alpha: float) -> tuple[list[list[Fraction]], list[Fraction]]:
        """Lists of gains and the times from one to the next, exact."""
        factor, exact = Fraction(alpha), [_short(v) for v in shape]
        needed = (exact[1] - exact[0]) * self._rise(which[0], factor)
        needed = needed if self.discrete else Fraction(math.ceil(needed * 2**40) + 1, 2**40)
        shares, times = self._shares(exact, needed)
        return [self._gains(*which, share, factor) for share in shares], times

    def _ends(self, which: _Set, alpha: float) -> tuple[list[Reals], Fraction]:
        """The gains where those that move are at either end, and how long the slowest takes from one to the other."""
        if (which, alpha) not in self._seen:
            factor = Fraction(alpha)
            ends = [np.array([float(v) for v in self._gains(*which, Fraction(s), factor)]) for s in (0, 1)]
            self._seen[which, alpha] = ends, self._rise(which[0], factor)
        return self._seen[which, alpha]

    @cached_property
    def _seen(self) -> dict[tuple[_Set, float], tuple[list[Reals], Fraction]]:
        """What :meth:`_ends` has found."""
        return {}

    def _growth(self, which: _Set, shape: _Shape, alpha: float) -> tuple[float, float]:
        """Logarithm of the spectral radius over one period, and the period."""
        ends, rise = self._ends(which, alpha)
        shares, times = self._shares([Fraction(v) for v in shape], Fraction(shape.high - shape.low) * rise)
        if not 0 < len(shares) <= MOST_SAMPLES:
            return -math.inf, 1.0
        levels = np.array([float(share) for share in shares])[:, None]
        closed = self.closed_by((1 - levels) * ends[0] + levels * ends[1])
        steps = closed
        if not self.discrete:
            after = np.roll(closed, -1, axis=0)
            size = float(np.abs(closed).sum(axis=2).max())
            pairs = zip(closed, after, times, strict=True)
            steps = exponentials(np.concatenate([_ramp(first, last, float(time), size) for first, last, time in pairs]))
        whole = _chained(steps)
        radius = float(np.abs(np.linalg.eigvals(whole)).max()) if np.isfinite(whole).all() else 0.0
        return (math.log(radius) if 0 < radius < math.inf else -math.inf), float(sum(times))

    def _best(self, which: _Set, alpha: float, start: _Shape | None = None) -> tuple[float, _Shape]:
        """The fastest growth per unit of time, and its shape; away from ``start`` only if nothing grows near it."""

        def rate(shape: _Shape) -> float:
            """Growth per unit of time."""
            rise, period = self._growth(which, shape.inside(), alpha)
            return rise / period if period > 0 else -math.inf

        unit = self._unit(which, alpha)
        if start is not None:
            found = self._near(rate, start, unit)
            if found[0] > _SURE:
                return found
        drawn = [_Shape(*levels, a * unit, b * unit) for levels in _LEVELS for a in _STAYS for b in _STAYS]
        ranked = sorted(((rate(one), one) for one in drawn), key=lambda pair: -pair[0])
        if self.discrete:
            return ranked[0]
        return max(ranked[0], *(self._near(rate, one, unit) for _, one in ranked[:_KEPT]))

    def _near(self, rate: Callable[[_Shape], float], start: _Shape, unit: float) -> tuple[float, _Shape]:
        """The fastest growth that is found downhill from a shape, and the shape there."""
        checkpoint()
        if self.discrete:
            return rate(start), start
        scale = np.array([1.0, 1.0, *(max(v, unit / 8) for v in start[2:])])
        solved = optimize.minimize(
            lambda v: -rate(_Shape(*(float(u) for u in v * scale))),
            np.array(start) / scale,
            method="Nelder-Mead",
            options={"maxiter": 80, "xatol": 1e-4, "fatol": 1e-8},
        )
        shape = _Shape(*(float(v) for v in solved.x * scale)).inside()
        return rate(shape), shape

    def _unit(self, which: _Set, alpha: float) -> float:
        """Half a period of the fastest turn at the ends, or in the time of the fastest eigenvalue."""
        rows = [[float(v) for v in self._gains(*which, Fraction(s), Fraction(alpha))] for s in (0, 1)]
        values = np.linalg.eigvals(self.closed_by(np.array(rows))).ravel().astype(complex)
        if self.discrete:
            values = np.log(np.where(np.abs(values) < 1e-9, 1e-9, values))
        turning = float(np.abs(values.imag).max())
        return math.pi / max(turning, float(np.abs(values).max()) / 10, 1e-9)

    def _found(self, low: float, most: float, *, lowest: bool) -> tuple[float, _Set, _Shape] | None:
        """A factor, the smallest that was found if that is asked for, the set and the shape; None if nothing grows."""
        rungs = [most] if most < math.inf else [(low or 1.0) * step for step in _RUNGS]
        for top in rungs:
            hits = [(*self._best(which, top), which) for which in self._sets()]
            rate, shape, which = max(hits, key=lambda hit: hit[0])
            if rate <= _SURE:
                continue
            alpha, floor = top, low
            for _ in range(_ROUNDS if lowest else 0):
                if alpha - floor < _CLOSE * alpha:
                    break
                middle = (floor + alpha) / 2
                rate, near = self._best(which, middle, shape)
                alpha, shape, floor = (middle, near, floor) if rate > _SURE else (alpha, shape, middle)
            return alpha, which, shape
        return None

    def proposals(self, low: float, most: float, *, lowest: bool) -> Iterator[Ramps]:
        """What to certify; nothing if no gain has a rate or the plant is too large.

        Parameters
        ----------
        low : float
            Up to it the loop is stable.
        most : float
            The largest factor of interest; infinity: none.
        lowest : bool
            Whether smaller ones than the first found are of interest.
        """
        if not self._sets() or not 0 < len(self.A) <= MOST_STATES or low >= most:
            return
        with np.errstate(all="ignore"):
            found = self._found(low, most, lowest=lowest)
            if found is None:
                return
            alpha, which, shape = found
            for step in (0.0, *_BEYOND):
                factor = min(alpha * (1 + step), most)
                rows, times = self._pattern(which, shape, factor)
                rate, _ = self._growth(which, shape, factor)
                if rate > _SURE:
                    enough = math.log2((math.log(4 * len(self.A)) + 2) / rate)
                    squarings = min(max(math.ceil(enough) + 2, 0), 64)
                    yield from (Ramps(factor, rows, times, squarings, bits) for bits in _BITS)


def _ramp(first: Reals, last: Reals, time: float, size: float) -> NDArray[np.float64]:
    """Matrices whose exponentials, one after the other, solve ``Y' = G Y`` while ``G`` goes to the last (Magnus)."""
    steps = 1 if (first == last).all() else max(_STEPS, min(math.ceil(2 * time * size), _MOST_STEPS))
    h, turn = time / steps, last - first
    middles = first + turn * ((np.arange(steps) + 0.5) / steps)[:, None, None]
    twist = (turn @ first - first @ turn) * (h * h / 12 / steps)
    return np.asarray(middles * h + twist)


def _chained(steps: Reals) -> NDArray[np.float64]:
    """The product of matrices, each after those before it."""
    while len(steps) > 1:
        pairs = steps[1::2] @ steps[: len(steps) - 1 : 2]
        steps = pairs if len(steps) % 2 == 0 else np.concatenate([pairs, steps[-1:]])
    return np.asarray(steps[0])


def _short(value: float) -> Fraction:
    """A double cut to 30 bits after the point."""
    return Fraction(round(value * 2**30), 2**30)


# Parameters of a plant that change with time so that some solution grows, in floating point: jumps, and ramps.
#
# The searches are those for gains, :mod:`lure.analysis.counterexamples.channel_switching` and ``channel_ramps``: each
# parameter stands behind the channels as a gain whose interval does not depend on the factor of the classes.

_LEAST = 1e-9  # a factor that stands for none of the classes but their lower bounds


class Moving(NamedTuple):
    """For the classes of a factor: parameters and gains, step after step, and what a certificate needs."""

    factor: float
    at: list[list[Fraction]]
    gains: list[list[Fraction]]
    times: list[Fraction]
    squarings: int
    bits: int


@dataclass(frozen=True)
class _Loops:
    """The plants in floating point, closed by gains."""

    powers: Reals
    common: Reals
    sides: tuple[Reals, ...]

    @classmethod
    def of(cls, family: ChannelFamily) -> _Loops:
        """Those of a family."""
        terms = family.terms
        sides = tuple(np.array([[[float(v) for v in row] for row in one.sides[k]] for one in terms]) for k in range(4))
        return cls(np.array([one.powers for one in terms]), np.array([float(one.common) for one in terms]), sides)

    def closed(self, gains: Reals, points: Reals) -> Reals:
        """The matrices of the loops ``mu = -g sigma`` at these parameters: (k, n, n)."""
        weights = (points[:, None, :] ** self.powers).prod(axis=2)
        below = (weights @ self.common)[:, None, None]
        A, B, C, D = (np.einsum("kt,tij->kij", weights, side) / below for side in self.sides)
        G = gains[:, :, None] * np.eye(gains.shape[1])
        return np.asarray(A - B @ G @ np.linalg.solve(np.eye(gains.shape[1]) + D @ G, C))


@dataclass(frozen=True, kw_only=True)
class SwitchedParameters(SwitchedGains):
    """Parameters that jump between their ends, beside gains."""

    loops: _Loops
    scaled: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))

    def closed(self, ends: NDArray[np.int_], alpha: float) -> Reals:
        """The matrices of the loop: (k, n, n)."""
        values, m = np.where(ends == 1, np.where(self.scaled, alpha, 1.0) * self.upper, self.lower), self.scaled.sum()
        return self.loops.closed(values[:, :m], values[:, m:])


@dataclass(frozen=True, kw_only=True)
class RampedParameters(RampedGains):
    """Parameters that move no faster than their rates, beside gains that stay."""

    loops: _Loops
    channels: int
    affine: tuple[bool, ...]

    def _alone(self, block: range) -> bool:
        return self.affine[block[0]]

    def _top(self, i: int, alpha: Fraction) -> Fraction:
        return alpha * self.upper[i] if i < self.channels else self.upper[i]

    def closed_by(self, gains: Reals) -> Reals:
        """The matrices of the loop, the parameters behind the gains: (k, n, n)."""
        return self.loops.closed(gains[:, : self.channels], gains[:, self.channels :])


@described(frozen=True)
class MovingParameters:
    """The search: parameters and gains that jump, and parameters that go at their rates beside gains that stay."""

    family: ChannelFamily = quantity("The plants")
    classes: Diagonal = quantity("The classes at the factor 1, with gains")

    @property
    def _paces(self) -> tuple[Fraction | float, ...]:
        return self.family.rates or (Fraction(0),) * len(self.family.box)

    @property
    def discrete(self) -> bool:
        """Whether in discrete time."""
        return self.family.dt is not None or self.family.any_period

    def _ends(self) -> tuple[list[Fraction], list[Fraction], list[range]]:
        """The lower and upper ends of gains and parameters, and which are one."""
        classes, box, m = self.classes, self.family.box, len(self.classes.classes)
        blocks = [*classes.blocks, *(range(m + j, m + j + 1) for j in range(len(box)))]
        return [*classes.lower, *(low for low, _ in box)], [*classes.upper, *(high for _, high in box)], blocks

    def _rungs(self, low: float, most: float) -> tuple[float, ...]:
        return (_LEAST, most) if low <= 0 else (most,)

    def jumps(self, low: float, most: float) -> Iterator[Moving]:
        """What to certify of jumps; nothing where nothing may jump.

        Parameters
        ----------
        low : float
            A factor up to which nothing grows; 0 where nothing is known: then the lower bounds alone are tried too.
        most : float
            The largest factor of interest; infinity: none.
        """
        (lower, upper, blocks), m = self._ends(), len(self.classes.classes)
        free = [one.time_varying and not one.linear for one in self.classes.classes]
        search = SwitchedParameters(
            *self.family.central.doubles(),
            lower=np.array([float(v) for v in lower]),
            upper=np.array([float(v) for v in upper]),
            varying=(*free, *(rate == math.inf for rate in self._paces)),
            blocks=tuple(blocks),
            discrete=self.discrete,
            loops=_Loops.of(self.family),
            scaled=np.arange(len(lower)) < m,
        )
        for top in self._rungs(low, most):
            for one in search.proposals(low, top):
                least = top == _LEAST
                ends = lower, [*(lower[:m] if least else self.classes.scaled(Fraction(one.factor)).upper), *upper[m:]]
                rows = [[ends[end][i] for i, end in enumerate(row)] for row in one.ends]
                at, own = [row[m:] for row in rows], [row[:m] for row in rows]
                yield Moving(0.0 if least else one.factor, at, own, one.times, one.squarings, one.bits)

    def ramps(self, low: float, most: float) -> Iterator[Moving]:
        """The same of parameters of bounded rates.

        ``low``, ``most``: as for jumps.
        """
        (lower, upper, blocks), m = self._ends(), len(self.classes.classes)
        rates = [Fraction(rate) if 0 < rate < math.inf else None for rate in self._paces]
        going = [j for j, rate in enumerate(rates) if rate is not None]
        if self.discrete or not going:
            return
        search = RampedParameters(
            *self.family.central.doubles(),
            lower=lower,
            upper=upper,
            rates=[*[None] * len(self.classes.blocks), *rates],
            blocks=blocks,
            discrete=False,
            loops=_Loops.of(self.family),
            channels=m,
            affine=(*[False] * m, *(_affine(self.family, j, going) for j in range(len(rates)))),
        )
        for top in self._rungs(low, most):
            for one in search.proposals(low, top, lowest=top != _LEAST):
                least, at = top == _LEAST, [row[m:] for row in one.gains]
                own = [lower[:m] if least else row[:m] for row in one.gains]
                yield Moving(0.0 if least else one.factor, at, own, one.times, one.squarings, one.bits)


def _affine(family: ChannelFamily, j: int, going: list[int]) -> bool:
    """Whether a parameter stands in ``A`` alone, to the first power, and beside no other that goes."""
    terms = [one for one in family.terms if one.powers[j]]
    alone = (not one.common and not any(any(map(any, side)) for side in one.sides[1:]) for one in terms)
    return all(alone) and all(sum(one.powers[k] for k in going) == 1 for one in terms)
