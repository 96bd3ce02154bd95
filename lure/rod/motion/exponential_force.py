"""A force as a sum of exponentials, sines and powers of time between two of its breakpoints."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from lure.expressions.exponentials import Sum, exponentials
from lure.expressions.expression import Expression
from lure.rod.motion.kernel_free import HEAD, TINY
from lure.rod.motion.pieces import Array, basis, tails
from lure.rod.motion.sources import SPAN, Load, Sources, panel_rows

_MOST_COLUMNS = 24
_MOST_POWER = 4
_LARGEST = 250.0  # exponents of the force, per round trip and transit
_RESOLVED, _NOISE = 1e-15, 1e-16
Complex = NDArray[np.complex128]


@dataclass(frozen=True, kw_only=True, eq=False)
class ExponentialForce:
    """What a force adds to the wave between two of its breakpoints, a sum of ``w t^K e^{rate t}``.

    Attributes
    ----------
    rate : ndarray
        (r,) exponents per transit, one of each conjugate pair.
    weights : tuple of ndarray
        (r,) weights for the powers ``K = 0, ...`` of ``t`` with each, time in transits since the force left ``x = 0``,
        in units of the wave [m/s], twice those of the sum for a pair.
    """

    rate: Complex
    weights: tuple[Complex, ...]

    def __call__(self, t: Array) -> Array:
        """Values at instants [transits] of the wave, which has taken a transit."""
        total, late = np.zeros(t.shape), t - 1.0
        for rate, weights in zip(self.rate.tolist(), self.weights, strict=True):
            total += (_shares(late, weights) * np.exp(rate * late)).real
        return total

    def columns(self, number: int, edges: Array, degree: int, least: float) -> Array | None:
        """(C, P, n+1) the functions of the time in round trips from one on, as series on pieces.

        In the m-th of them they are taken ``m^k e^{2 rate m}`` times: real part and, for a pair, imaginary part.  None
        if the degree is not enough.

        Parameters
        ----------
        number : int
            The first round trip.
        edges : ndarray
            (P+1,) ends of the pieces [transits].
        degree : int
            The highest that a series may have.
        least : float
            What may be left out of a coefficient.
        """
        low, high, space = edges[:-1, None], edges[1:, None], basis(degree)
        x = low + 0.5 * (high - low) * (space.inner + 1.0) - 1.0
        if not self.count:
            return np.zeros((0, len(x), 1))
        table, i = np.empty((self.count, *x.shape)), 0
        for rate, weights in zip(self.rate.tolist(), self.weights, strict=True):
            grown = np.exp(rate * x + 2.0 * number * rate.real) * cmath.rect(1.0, 2.0 * number * rate.imag)
            for k in range(len(weights)):
                shares = [2.0**k * math.comb(K, k) * weights[K] for K in range(k, len(weights))]
                values = grown * _shares(x + 2.0 * number, shares)
                table[i], i = values.real, i + 1
                if rate.imag:
                    table[i], i = -values.imag, i + 1
        series = table @ space.from_inner.T
        size = TINY * (1.0 + max(map(abs, self.rate.tolist())))
        tiny = np.maximum(least, size * np.abs(table).max(axis=(1, 2)))
        over = (np.maximum.reduce(np.abs(series), axis=1) > tiny[:, None]).any(axis=0).tolist()
        n = max(k for k in range(degree + 1) if over[k] or not k)
        return None if n == degree else series[:, :, : n + 1]

    @cached_property
    def start(self) -> Array:
        """(C,) by what the functions are taken in the first round trip."""
        firsts = [(1.0, 0.0) if rate.imag else (1.0,) for rate in self.rate.tolist()]
        sizes = [len(w) for w in self.weights]
        return np.array(
            [x for first, n in zip(firsts, sizes, strict=True) for x in (*first, *([0.0] * len(first) * (n - 1)))]
        )

    @cached_property
    def turn(self) -> Array:
        """(C, C) the change of that from each round trip to the next."""
        found = np.zeros((self.count, self.count))
        at = 0
        for rate, weights in zip(self.rate.tolist(), self.weights, strict=True):
            more, m = np.expm1(complex(2.0 * rate)), 2 if rate.imag else 1
            for k in range(len(weights)):
                for i in range(k + 1):
                    share = more if i == k else math.comb(k, i) * (1.0 + more)
                    block = np.array([[share.real, -share.imag], [share.imag, share.real]])[:m, :m]
                    found[at + m * k : at + m * (k + 1), at + m * i : at + m * (i + 1)] = block
            at += m * len(weights)
        return found

    @cached_property
    def packed(self) -> Array:
        """What :mod:`lure.rod.motion.kernel_free` reads: places, exponents with their powers, weights, start, turn."""
        rates = [
            x for rate, w in zip(self.rate.tolist(), self.weights, strict=True) for x in (rate.real, rate.imag, len(w))
        ]
        weights = [x for w in self.weights for weight in w.tolist() for x in (weight.real, weight.imag)]
        places = HEAD + len(rates), HEAD + len(rates) + len(weights), HEAD + len(rates) + len(weights) + self.count
        numbers = [len(self.weights), self.count, *places, *rates, *weights, *self.start, *self.turn.ravel()]
        return np.array(numbers, dtype=np.float64)  # without a force, too: integers would be compiled for once more

    @property
    def count(self) -> int:
        """Number of real functions of the time in a round trip that it takes."""
        return sum(len(w) * (2 if rate.imag else 1) for rate, w in zip(self.rate, self.weights, strict=True))

    @property
    def finite_until(self) -> int:
        """Round trip up to which no exponential is beyond the doubles."""
        fastest = float(self.rate.real.max(initial=0.0))
        return int(_LARGEST / fastest) if fastest > 0.0 else 1 << 62


def _shares(t: Array, weights: Sequence[complex] | Complex) -> Complex | complex:
    """Values of a polynomial, one number for a constant."""
    total: Complex | complex = weights[-1]
    for weight in weights[-2::-1]:
        total = np.asarray(total * t + weight)
    return total


@lru_cache(maxsize=64)
def _terms(force: Expression, inside: Fraction) -> Sum | None:
    """What a formula is around an instant: one formula has many motions."""
    return exponentials(force.tree, "t", inside)


class ExponentialForces:
    """The force of a motion from breakpoint to breakpoint."""

    def __init__(self, sources: Sources) -> None:
        scenario, self._sources = sources.scenario, sources
        self.known = scenario.body_force.is_zero
        self._edges: Sequence[Fraction] = ()
        if self.known and not scenario.force.is_zero:
            found = scenario.force.breakpoints("t", 0.0, math.inf)
            self.known = found is not None
            self._edges = found or ()
        self._made: dict[int, ExponentialForce | None] = {}

    def panels(self, first: int, count: int, degree: int) -> Load | None:
        """The panels of blocks in which the force keeps its formula, without looking at it; None elsewhere."""
        force, end = self._from(max(SPAN * first, 1.0))
        if force is None or end < SPAN * (first + count) or (not first and count > 1):
            return None
        low, space = (0.0 if first else 1.0), basis(degree)  # the force needs a transit to arrive
        block = np.arange(first, first + count, dtype=float)
        with np.errstate(over="ignore", invalid="ignore"):  # a force that grows beyond the doubles is no panel
            values = force(SPAN * block[:, None] + (low + 0.5 * (SPAN - low) * (space.inner + 1.0)))
            coef = np.einsum("ij,kj->ik", values, space.from_inner)  # rounds each row alike, however many there are
        size = np.abs(coef).sum(axis=1)
        if not (tails(coef) <= _RESOLVED * size).all():
            return None
        none = 0.0 * block
        if first:
            return panel_rows(first, np.arange(count + 1), (none, none + SPAN, coef, size, none, _NOISE * size))
        before = np.zeros((1, degree + 1))
        rows = [np.array([0.0, low]), np.array([low, SPAN]), np.concatenate((before, coef)), np.append(0.0, size)]
        return panel_rows(0, np.array([0, 2]), (*rows, np.zeros(2), _NOISE * rows[3]))

    def over(self, number: int) -> tuple[ExponentialForce | None, float]:
        """The force from a round trip on, None if it is no such sum; the instant [transits] up to which it holds."""
        return self._from(2.0 * number) if number else (None, 0.0)

    def _from(self, start: float) -> tuple[ExponentialForce | None, float]:
        if not self.known:
            return None, 0.0
        ends = [float(edge) / self._sources.rod.travel_time + 1.0 for edge in self._edges]
        place = sum(end <= start for end in ends)
        if place not in self._made:
            self._made[place] = self._force(place)
        return self._made[place], ends[place] if place < len(ends) else math.inf

    def _force(self, place: int) -> ExponentialForce | None:
        sources = self._sources
        terms: Sum | None = {}
        if not sources.scenario.force.is_zero and sources.force_gain:
            low = self._edges[place - 1] if place else Fraction(0)
            high = self._edges[place] if place < len(self._edges) else low + 1
            terms = _terms(sources.scenario.force, (low + high) / 2)
        if terms is None or max((power for _, power in terms), default=0) > _MOST_POWER:
            return None
        T, gain = sources.rod.travel_time, sources.force_gain
        rates = sorted({rate for rate, _ in terms if rate.imag >= 0.0}, key=lambda rate: (rate.imag, rate.real))
        powers = tuple(max(power for other, power in terms if other == rate) for rate in rates)
        weights = tuple(
            np.array(
                [gain * T**k * (2.0 if rate.imag else 1.0) * terms.get((rate, k), 0j) for k in range(power + 1)],
                dtype=complex,
            )
            for rate, power in zip(rates, powers, strict=True)
        )
        rate = np.array([T * rate for rate in rates], dtype=complex)
        found = ExponentialForce(rate=rate, weights=weights)
        return found if found.count <= _MOST_COLUMNS else None
