r"""The map from one round trip to the next while nothing happens: linear, and raised to powers by squaring.

On one straight segment of the nonlinearity and on fixed pieces the state ``X = (W, zeta, impulse)`` of a round trip and
the states ``u`` of the load give those of the next: ``X' = (B + D) X + F u`` with the diagonal ``B = (echo of W, 1,
1)``. Powers keep ``B`` and ``D`` apart, so that rounding of what does not change does not add up: ``D_2m = B_m D_m +
D_m B_m + D_m^2``.

A force that is a sum of ``w t^K e^{lambda t}`` is, in round trip ``n``, a sum of ``v_k(n) = n^k e^{2 lambda T n}``
times fixed functions of the time inside the round trip, and ``v(n + m) = U_m v(n)`` by the binomial theorem.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from lure.expressions.exponentials import Sum, exponentials
from lure.rod.motion.end_law import Segment
from lure.rod.motion.kernel_series import BLOCK
from lure.rod.motion.pieces import Array, basis, products
from lure.rod.motion.sources import SPAN, Load, Sources, panel_table

_MOST_STATES = 12
_MOST_POWER = 4
_ORDER = 14
_WIDEST = 0.7  # exponent over half a piece up to which the power series ends in time
_FASTEST = 100.0  # growth over 64 round trips, as an exponent
_SEEN = 1e-17
Complex = NDArray[np.complex128]
_SMALL = 1e-19
_MORE = 10


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class LoadStates:
    """What a force adds to the wave, between two of its breakpoints: states that a constant matrix moves on.

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
    made: dict[int, Array] = field(default_factory=dict, repr=False)

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
        """``U_m`` (count, count), made once."""
        if m not in self.made:
            self.made[m] = self._step(m)
        return self.made[m]

    def _step(self, m: int) -> Array:
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


class EventFreeLoads:
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

    def panels(self, first: int, count: int, degree: int) -> Load | None:
        """The panels of blocks in which the force keeps its formula, without looking at it; None elsewhere."""
        edges = np.array([0.0, SPAN] if first else [0.0, 1.0, SPAN])  # the force needs a transit to arrive
        states, end = self._from(max(SPAN * first, 1.0))
        series = None if states is None or end < SPAN * (first + count) else states.series(edges)
        if states is None or series is None or series.shape[1] > degree + 1 or (not first and count > 1):
            return None
        block, none = np.arange(first, first + count, dtype=float), np.zeros(count)
        coef = np.zeros((count, degree + 1))
        coef[:, : series.shape[1]] = states.at(BLOCK * block) @ series[-1].T
        done = [(block, none + edges[-2], none + SPAN, coef, np.abs(coef).sum(axis=1), none, none)]
        if not first:
            done.insert(0, (block, none, none + 1.0, 0.0 * coef, none, none, none))
        return panel_table(first, count, done)

    def over(self, number: int) -> tuple[LoadStates | None, float]:
        """The states from a round trip on, and the instant [transits] up to which they hold; None if there are none."""
        return self._from(2.0 * number) if number else (None, 0.0)

    def _from(self, start: float) -> tuple[LoadStates | None, float]:
        if not self.known:
            return None, 0.0
        ends = [float(edge) / self._sources.rod.travel_time + 1.0 for edge in self._edges]
        place = sum(end <= start for end in ends)
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


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Coefficients:
    """The physical numbers of a map: see :class:`lure.rod.motion.sources.Problem`; ``d`` is reduced by the share."""

    transit: float
    share: float
    echo: float
    area: float
    mobility: float
    impedance: float


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class EventFreeMap:
    """Functions of the state of one round trip.

    Attributes
    ----------
    edges : ndarray
        (P+1,) of the pieces.
    degree : int
        Of ``W`` on a piece.
    segment : Segment
        Of the nonlinearity.
    own, start, level : ndarray
        ``z`` on a piece less ``z`` where the piece begins: (P, K, degree+1) per coefficient of ``W`` on it, (P, K) per
        ``zeta`` there, (P, K) constant.
    begins, begin : ndarray
        ``zeta`` where the pieces begin, and at the end, less that at the start of the round trip: (P+1, S) per ``X``,
        (P+1,) constant.
    travel, steady : ndarray
        Series of ``zeta`` less ``zeta`` at the start of the round trip: (P, K, S) per ``X``, (P, K) constant.
    """

    edges: Array
    degree: int
    segment: Segment
    own: Array
    start: Array
    level: Array
    begins: Array
    begin: Array
    travel: Array
    steady: Array

    @property
    def pieces(self) -> int:
        """P."""
        return len(self.edges) - 1

    @property
    def waves(self) -> int:
        """Place of ``zeta`` in ``X``, after those of ``W``."""
        return self.pieces * (self.degree + 1)

    @property
    def size(self) -> int:
        """S."""
        return int(self.begins.shape[1])


def _travel(found: tuple[Array, Array, Array], begins: Array, begin: Array) -> tuple[Array, Array]:
    """``travel`` and ``steady``."""
    own, start, level = found
    P, n = len(own), own.shape[2]
    series = start[:, :, None] * begins[:-1, None, :]
    series[:, :, P * n] += start
    for p in range(P):
        series[p, :, p * n : (p + 1) * n] += own[p]
    series[:, 0] += begins[:-1]
    constant = level + start * begin[:-1, None]
    constant[:, 0] += begin[:-1]
    return series, constant


def event_free_map(segment: Segment, edges: Array, degree: int, numbers: Coefficients) -> EventFreeMap | None:
    """The functions on a segment that is straight; None if ``zeta`` needs a much higher degree than ``W``."""
    half = 0.5 * numbers.transit * np.diff(edges)
    stiff, n = segment.rate * half, degree + 1
    more, term = 1, float(stiff.max())
    while term > _SMALL and more < _MORE:
        more += 1
        term *= float(stiff.max()) / (2.0 * more)
    if term > _SMALL:
        return None
    K = n + (1 if segment.rate == 0.0 else 1 + more)
    integral = _integral(K)
    driven = half[:, None, None] * integral[:, :n]
    pushed = -segment.push * half[:, None] * integral[:, 0]
    held = -stiff[:, None] * integral[:, 0]
    if segment.rate > 0.0:
        system = np.eye(K) + stiff[:, None, None] * integral
        right = np.concatenate((numbers.share * driven, held[:, :, None], pushed[:, :, None]), axis=2)
        found = np.asarray(np.linalg.solve(system, right), dtype=float)
        own, start, level = found[:, :, :n], found[:, :, n], found[:, :, n + 1]
    else:
        own, start, level = numbers.share * driven, held, pushed
    P = len(half)
    size = P * n + (2 if segment.touching else 1)
    begins, begin = np.zeros((P + 1, size)), np.zeros(P + 1)
    held_ends, own_ends, level_ends = start.sum(axis=1), own.sum(axis=1), level.sum(axis=1)
    if segment.rate == 0.0:
        own_ends = 2.0 * numbers.share * half[:, None] * mean_values(n)  # nothing, not rounding, for odd degrees
        for p in range(P):
            begins[p + 1 :, p * n : (p + 1) * n] = own_ends[p]
        begin[1:] = np.cumsum(level_ends)
    else:
        for p in range(P):
            begins[p + 1] = (1.0 + held_ends[p]) * begins[p]
            begins[p + 1, P * n] += held_ends[p]
            begins[p + 1, p * n : (p + 1) * n] += own_ends[p]
            begin[p + 1] = (1.0 + held_ends[p]) * begin[p] + level_ends[p]
    travel, steady = _travel((own, start, level), begins, begin)
    return EventFreeMap(
        edges=edges,
        degree=degree,
        segment=segment,
        own=own,
        start=start,
        level=level,
        begins=begins,
        begin=begin,
        travel=travel,
        steady=steady,
    )


def _integral(size: int) -> Array:
    """(size, size) from coefficients to those of the integral from -1, without its last term."""
    matrix = np.zeros((size, size))
    for j in range(size):
        if j + 1 < size:
            matrix[j + 1, j] = (2.0 if j == 0 else 1.0) / (2.0 * (j + 1))
        if j > 1:
            matrix[j - 1, j] = -1.0 / (2.0 * (j - 1))
        # the value at -1 of the primitive, with its last term, is taken off
        low = (-1.0) ** (j + 1) * (2.0 if j == 0 else 1.0) / (2.0 * (j + 1))
        if j > 1:
            low -= (-1.0) ** (j - 1) / (2.0 * (j - 1))
        matrix[0, j] -= low
    return matrix


def mean_values(size: int) -> Array:
    """Means of ``T_k`` over ``[-1, 1]``."""
    k = np.arange(size)
    return np.where(k % 2 == 0, 1.0 / (1.0 - np.where(k % 2 == 0, k, 0.0) ** 2), 0.0)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Power:
    """The map over ``m`` round trips: ``X -> beta X + D X + F u``, where only the rows ``D[place]`` are not zero."""

    m: int
    beta: Array
    place: slice
    rows: Array
    load: Array

    def applied(self, X: Array, u: Array) -> Array:
        """Of (n, S) and (n, states)."""
        found = X * self.beta
        found[:, self.place] += X @ self.rows.T
        if self.load.shape[1]:
            found += u @ self.load.T
        return np.asarray(found)

    def dense(self) -> Array:
        """``B + D`` (S, S)."""
        matrix = np.diag(self.beta)
        matrix[self.place] += self.rows
        return matrix


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Powers:
    """The map and its powers of two, made when they are needed; ``u`` are the load's states and 1.

    Attributes
    ----------
    map : EventFreeMap
        The round trip.
    numbers : Coefficients
        Its physics.
    states : LoadStates
        Of the load.
    series : ndarray
        (P, degree+1, states) what the load adds to ``W``.
    """

    map: EventFreeMap
    numbers: Coefficients
    states: LoadStates
    series: Array
    made: list[Power] = field(default_factory=list)
    steps: dict[int, Array] = field(default_factory=dict)

    def __getitem__(self, k: int) -> Power:
        """The map over ``2**k`` round trips."""
        while len(self.made) <= k:
            self.made.append(self._doubled(self.made[-1]) if self.made else self._first())
        return self.made[k]

    def at(self, number: Array) -> Array:
        """``u`` (n, states) in round trips."""
        found = np.ones((len(number), self.states.count + 1))
        found[:, :-1] = self.states.at(number)
        return found

    @staticmethod
    def number_of(first: int, blocks: int) -> Array:
        """Numbers of the round trips with which blocks of 64 begin."""
        return first + 64.0 * np.arange(blocks, dtype=float)

    def step(self, m: int) -> Array:
        """The map of ``u`` over ``m`` round trips."""
        if m not in self.steps:
            count = self.states.count
            matrix = np.zeros((count + 1, count + 1))
            matrix[:count, :count], matrix[count, count] = self.states.step(m), 1.0
            self.steps[m] = matrix
        return self.steps[m]

    def _first(self) -> Power:
        q, numbers = self.map, self.numbers
        segment, n, w = q.segment, q.degree + 1, q.waves
        flat = segment.rate == 0.0
        beta = np.ones(q.size)
        beta[:w] = numbers.echo * (2.0 * numbers.share - 1.0)
        rows, load = np.zeros((q.size, q.size)), np.zeros((q.size, self.states.count + 1))
        load[:w, :-1] = self.series.reshape(w, -1) @ self.step(1)[:-1, :-1]
        rows[w], load[w, -1] = q.begins[-1], q.begin[-1]
        back = -2.0 * numbers.echo
        load[:w:n, -1] += back * segment.push
        if not flat:
            series, constant = q.travel, q.steady
            rows[:w] = back * segment.rate * series[:, :n].reshape(w, -1)
            rows[:w:n, w] += back * segment.rate
            load[:w, -1] += back * segment.rate * constant[:, :n].ravel()
        if segment.touching:
            widths = numbers.transit * numbers.area / numbers.mobility * np.diff(q.edges)
            load[w + 1, -1] = segment.push * widths.sum()
            if not flat:
                mean = mean_values(series.shape[1])
                rows[w + 1] = segment.rate * (widths @ np.tensordot(series, mean, axes=(1, 0)))
                rows[w + 1, w] += segment.rate * widths.sum()
                load[w + 1, -1] += segment.rate * (widths @ (constant @ mean))
        place = slice(w, w + 1) if flat else slice(0, q.size)
        return Power(m=1, beta=beta, place=place, rows=rows[place], load=load)

    def _doubled(self, p: Power) -> Power:
        rows = p.beta[p.place, None] * p.rows + p.rows * p.beta + p.rows[:, p.place] @ p.rows
        load = p.beta[:, None] * p.load + p.load @ self.step(p.m)
        load[p.place] += p.rows @ p.load
        beta = self.made[0].beta ** (2 * p.m)
        return Power(m=2 * p.m, beta=beta, place=p.place, rows=rows, load=load)


def imbalance(powers: Powers, X: Array) -> float:
    """A bound [m] on ``|int (z' - W + d p) dt|`` over any of some round trips, with states (n, S).

    The sum of the coefficients of the residual of the equation of ``z`` in the series that solve it.
    """
    q, numbers = powers.map, powers.numbers
    half = 0.5 * numbers.transit * np.diff(q.edges)
    P, K, S = q.travel.shape
    n, slope, stiff = q.degree + 1, basis(K - 1).derivative, q.segment.rate * half
    residual = slope @ q.travel + stiff[:, None, None] * q.travel
    residual[:, 0, q.waves] += stiff
    level = q.steady @ slope.T + stiff[:, None] * q.steady
    level[:, 0] += q.segment.push * half
    for p in range(P):
        residual[p, :n, p * n : (p + 1) * n] -= numbers.share * half[p] * np.eye(n)
    return float(np.abs(X @ residual.reshape(P * K, S).T + level.ravel()).sum(axis=1).max())


def passed(powers: Powers, X: Array) -> Array:
    """``Z/4 int W^2 dt`` (n,) over round trips [J]."""
    q = powers.map
    wave = X[:, : q.waves].reshape(len(X), q.pieces, -1)
    half = 0.125 * powers.numbers.impedance * powers.numbers.transit * np.diff(q.edges)
    return np.asarray((((wave @ products(q.degree + 1)) * wave).sum(axis=2)) @ half)
