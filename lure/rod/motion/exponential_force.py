"""A force as a sum of exponentials, sines and powers of time between two of its breakpoints."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from lure.expressions.exponentials import exponentials
from lure.expressions.expression import Expression
from lure.record import described, quantity
from lure.rod.motion.kernel_free import FROM, HEAD, MOST, TINY
from lure.rod.motion.pieces import Array, basis
from lure.rod.motion.sources import Sources

MOST_COLUMNS = 24
_MOST_POWER = 4
_LARGEST = 250.0  # exponents of the force, per round trip and transit
Complex = NDArray[np.complex128]


@described(frozen=True, kw_only=True, eq=False)
class ExponentialForce:
    """What a force adds to the wave between two of its breakpoints, a sum of ``w t^K e^{rate t}``."""

    rate: Complex = quantity("(r,) exponents per transit, one of each conjugate pair")
    weights: tuple[Complex, ...] = quantity(
        "(r,) weights for the powers ``K = 0, ...`` of ``t`` with each, time in transits since the force left ``x "
        "= 0``, in units of the wave [m/s], twice those of the sum for a pair"
    )

    def columns(self, number: int, edges: Array, degree: int, least: float) -> Array | None:
        """(C, P, n+1) the functions of the time in round trips from one on, as series on pieces.

        In the m-th of them they are taken ``m^k e^{2 rate m}`` times: real part and, for a pair, imaginary part.  None
        if the degree is not enough.

        ``number``: the first round trip; ``edges``: (P+1,) ends of the pieces [transits]; ``degree``: the highest that
        a series may have; ``least``: what may be left out of a coefficient.
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
        """Exponents with their powers, weights, start and turn, after a head of :meth:`ExponentialForces.packed`."""
        rates = [
            x for rate, w in zip(self.rate.tolist(), self.weights, strict=True) for x in (rate.real, rate.imag, len(w))
        ]
        weights = [x for w in self.weights for weight in w.tolist() for x in (weight.real, weight.imag)]
        places = HEAD + len(rates), HEAD + len(rates) + len(weights), HEAD + len(rates) + len(weights) + self.count
        head = [len(self.weights), self.count, *places, *[0.0] * (HEAD - FROM)]
        return np.array([*head, *rates, *weights, *self.start, *self.turn.ravel()], dtype=np.float64)

    @property
    def count(self) -> int:
        """Number of real functions of the time in a round trip that it takes."""
        return sum(len(w) * (2 if rate.imag else 1) for rate, w in zip(self.rate, self.weights, strict=True))


def _shares(t: Array, weights: Sequence[complex] | Complex) -> Complex | complex:
    """Values of a polynomial, one number for a constant."""
    total: Complex | complex = weights[-1]
    for weight in weights[-2::-1]:
        total = np.asarray(total * t + weight)
    return total


class ExponentialForces:
    """The force of a motion from breakpoint to breakpoint."""

    def __init__(self, sources: Sources, transits: float, *, known: bool = True) -> None:
        """``transits``: length of the motion; ``known``: whether its formula is to be looked at."""
        scenario, self._sources, self._total = sources.scenario, sources, math.floor(0.5 * transits)
        self.known = known and scenario.body_force.is_zero
        self._edges: Sequence[Fraction] = ()
        if self.known and not scenario.force.is_zero:
            found = scenario.force.breakpoints("t", 0.0, math.inf)
            self.known = found is not None
            self._edges = found or ()
        self._ends = [float(edge) / sources.rod.travel_time + 1.0 for edge in self._edges]

    def over(self, number: int) -> tuple[ExponentialForce | None, float, float]:
        """The force from a round trip on, None if it is no such sum; the instants [transits] between which it holds."""
        start, sources = max(2.0 * number, 1.0), self._sources  # it needs a transit to arrive
        if not self.known:
            return None, 0.0, math.inf
        place = sum(end <= start for end in self._ends)
        since = self._ends[place - 1] if place else 0.0
        until = self._ends[place] if place < len(self._ends) else math.inf
        inside: Fraction | None = None
        if not sources.scenario.force.is_zero and sources.force_gain:
            low = self._edges[place - 1] if place else Fraction(0)
            inside = (low + (self._edges[place] if place < len(self._edges) else low + 1)) / 2
        force = _force(sources.scenario.force, inside, sources.rod.travel_time, sources.force_gain)
        return force, since, until

    def packed(self, number: int) -> Array:
        """What :mod:`lure.rod.motion.kernel_free` reads of the force from a round trip on."""
        force, since, until = self.over(number)
        following = math.inf if until == math.inf else max(math.ceil(0.5 * until), 1)
        if force is None:
            return np.array([0.0, 0.0, HEAD, HEAD, HEAD, math.inf, 0.0, following, -1.0])
        packed, fastest = force.packed.copy(), float(force.rate.real.max(initial=0.0))
        until = min(until, 2.0 * _LARGEST / fastest if fastest > 0.0 else until)  # no exponential beyond the doubles
        packed[FROM : MOST + 1] = since, until, following, min(0.5 * until, self._total) // 1
        return packed


@lru_cache(maxsize=64)
def _force(force: Expression, inside: Fraction | None, transit: float, gain: float) -> ExponentialForce | None:
    """What a formula is around an instant; without one, no force.  One formula has many motions."""
    terms = {} if inside is None else exponentials(force.tree, "t", inside)
    if terms is None or max((power for _, power in terms), default=0) > _MOST_POWER:
        return None
    rates = sorted({rate for rate, _ in terms if rate.imag >= 0.0}, key=lambda rate: (rate.imag, rate.real))
    powers = tuple(max(power for other, power in terms if other == rate) for rate in rates)
    weights = tuple(
        np.array(
            [gain * transit**k * (2.0 if rate.imag else 1.0) * terms.get((rate, k), 0j) for k in range(power + 1)],
            dtype=complex,
        )
        for rate, power in zip(rates, powers, strict=True)
    )
    found = ExponentialForce(rate=np.array([transit * rate for rate in rates], dtype=complex), weights=weights)
    return found if found.count <= MOST_COLUMNS else None
