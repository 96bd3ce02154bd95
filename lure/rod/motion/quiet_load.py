r"""A force as states that go from round trip to round trip by a constant matrix.

A sum of ``w t^K e^{lambda t}`` is, in round trip ``n``, a sum of ``v_k(n) = n^k e^{2 lambda T n}`` times fixed
functions of the time inside the round trip, and ``v(n + m) = U_m v(n)`` by the binomial theorem.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from lure.rod.motion.chebyshev import Array
from lure.rod.motion.sources import Sources
from lure.rod.structured.flight import Sum, exponentials

_MOST_STATES = 12
_MOST_POWER = 4
_ORDER = 14
_WIDEST = 0.7  # exponent over half a piece up to which the power series ends in time
_FASTEST = 100.0  # growth over 64 round trips, as an exponent
_SEEN = 1e-17

Complex = NDArray[np.complex128]


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class LoadStates:
    """What a force adds to the wave, between two of its breakpoints.

    Attributes
    ----------
    rate : ndarray
        (r,) exponents per transit, one of each conjugate pair.
    powers : tuple of int
        (r,) highest power of ``t`` with each.
    weights : tuple of ndarray
        (r,) weights of ``t^K e^{rate t}``, ``K = 0, ...``, time in transits, in units of the wave [m/s].
    """

    rate: Complex
    powers: tuple[int, ...]
    weights: tuple[Complex, ...]

    @property
    def count(self) -> int:
        """Number of real states, of which the second half are imaginary parts."""
        return 2 * sum(power + 1 for power in self.powers)

    def at(self, n: Array) -> Array:
        """The states (len(n), count) in round trips."""
        size = self.count // 2
        table = np.empty((len(n), 2 * size))
        column = 0
        for rate, power in zip(self.rate.tolist(), self.powers, strict=True):
            size_now, angle = np.exp((2.0 * rate.real) * n) if rate.real else 1.0, (2.0 * rate.imag) * n
            real, imaginary = size_now * np.cos(angle), size_now * np.sin(angle)
            for _ in range(power + 1):
                table[:, column], table[:, size + column] = real, imaginary
                real, imaginary, column = real * n, imaginary * n, column + 1
        return table

    def step(self, m: int) -> Array:
        """``U_m`` (count, count)."""
        size, row = self.count // 2, 0
        matrix = np.zeros((2 * size, 2 * size))
        for rate, power in zip(self.rate.tolist(), self.powers, strict=True):
            factor = complex(np.exp(2.0 * m * rate))
            for k in range(power + 1):
                for low in range(k + 1):
                    entry = factor * math.comb(k, low) * float(m) ** (k - low)
                    i, j = row + k, row + low
                    matrix[i, j] = matrix[size + i, size + j] = entry.real
                    matrix[i, size + j], matrix[size + i, j] = -entry.imag, entry.imag
            row += power + 1
        return matrix

    def series(self, edges: Array) -> Array | None:
        """(m, N+1, count) coefficients on pieces of a round trip per state; None if they do not fall off."""
        middle, half = 0.5 * (edges[:-1] + edges[1:]) - 1.0, 0.5 * np.diff(edges)
        if not self.count:
            return np.zeros((len(half), 1, 0))
        if float(np.abs(self.rate).max()) * float(half.max()) > _WIDEST:
            return None
        if 128.0 * float(self.rate.real.max()) > _FASTEST:
            return None
        columns = []
        for rate, power, weights in zip(self.rate, self.powers, self.weights, strict=True):
            terms = np.ones((len(half), _ORDER), dtype=complex)
            terms[:, 1:] = np.cumprod((rate * half)[:, None] / np.arange(1, _ORDER), axis=1)
            raised = [terms * np.exp(rate * middle)[:, None]]
            for _ in range(power):
                last = raised[-1]
                more = middle[:, None] * last
                more[:, 1:] += half[:, None] * last[:, :-1]
                raised.append(more)
            for k in range(power + 1):
                total = sum(
                    weights[K] * math.comb(K, k) * 2.0**k * raised[K - k] for K in range(k, power + 1) if weights[K]
                )
                columns.append((total if not isinstance(total, int) else 0.0 * raised[0]) @ _monomials().T)
        table = np.stack(columns, axis=2)
        table = np.concatenate((table.real, -table.imag), axis=2)
        size = np.abs(table).max(axis=(0, 2))
        seen = np.flatnonzero(size > _SEEN * size.max(initial=0.0))
        return np.asarray(table[:, : int(seen[-1]) + 1 if seen.size else 1])


@lru_cache(maxsize=1)
def _monomials() -> Array:
    """From coefficients of powers to those of Chebyshev polynomials."""
    columns = [np.pad(chebyshev.poly2cheb(row[: k + 1]), (0, _ORDER - 1 - k)) for k, row in enumerate(np.eye(_ORDER))]
    return np.array(columns, dtype=float).T


class QuietLoads:
    """The force of a motion, piece by piece as states."""

    def __init__(self, sources: Sources) -> None:
        scenario, self._sources = sources.scenario, sources
        self.known = scenario.body_force.is_zero
        self._edges: Sequence[Fraction] = ()
        if self.known and not scenario.force.is_zero:
            found = scenario.force.breakpoints("t", 0.0, math.inf)
            self.known = found is not None
            self._edges = found or ()
        self._made: dict[int, LoadStates | None] = {}

    def over(self, number: int) -> tuple[LoadStates | None, float]:
        """The states from a round trip on, and the instant [transits] up to which they hold; None if there are none."""
        if not self.known or number < 1:
            return None, 0.0
        T = self._sources.rod.travel_time
        ends = [float(edge) / T + 1.0 for edge in self._edges]
        place = sum(end <= 2.0 * number for end in ends)
        if place not in self._made:
            self._made[place] = self._states(place)
        return self._made[place], ends[place] if place < len(ends) else math.inf

    def _states(self, place: int) -> LoadStates | None:
        sources = self._sources
        terms: Sum | None = {}
        if not sources.scenario.force.is_zero and sources.force_gain:
            low = self._edges[place - 1] if place else Fraction(0)
            high = self._edges[place] if place < len(self._edges) else low + 1
            terms = exponentials(sources.scenario.force.tree, "t", (low + high) / 2)
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
        states = LoadStates(rate=np.array([T * rate for rate in rates], dtype=complex), powers=powers, weights=weights)
        return states if states.count <= 2 * _MOST_STATES else None
