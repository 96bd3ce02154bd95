r"""The map from one round trip to the next while nothing happens: linear, and raised to powers by squaring.

On one straight segment of the law and on fixed pieces the state ``X = (W, zeta, impulse)`` of a round trip and the
states ``u`` of the load give those of the next: ``X' = (B + D) X + F u`` with the diagonal ``B = (echo of W, 1, 1)``.
Powers keep ``B`` and ``D`` apart, so that rounding of what does not change does not add up:
``D_2m = B_m D_m + D_m B_m + D_m^2``.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from lure.rod.motion.chebyshev import Array
from lure.rod.motion.quiet_load import LoadStates
from lure.rod.motion.quiet_map import Coefficients, Quiet, mean_values


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
    quiet : Quiet
        The round trip.
    numbers : Coefficients
        Its physics.
    states : LoadStates
        Of the load.
    series : ndarray
        (P, degree+1, states) what the load adds to ``W``.
    """

    quiet: Quiet
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
        q, numbers = self.quiet, self.numbers
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


def work(powers: Powers) -> Array:
    """``int d p z' dt Z/share`` over a round trip as a quadratic form (S+r, S+r) of ``(X, u)`` [J]."""
    q, numbers = powers.quiet, powers.numbers
    segment, n, P = q.segment, q.degree + 1, q.pieces
    series, constant = q.travel, q.steady
    K, size = series.shape[1], q.size + powers.states.count + 1
    push, speed = np.zeros((P, K, size)), np.zeros((P, n, size))
    push[:, :, : q.size] = segment.rate * series
    push[:, 0, q.waves] += segment.rate
    push[:, :, -1] = segment.rate * constant
    push[:, 0, -1] += segment.push
    for p in range(P):
        speed[p, :, p * n : (p + 1) * n] = numbers.share * np.eye(n)
    speed = np.pad(speed, ((0, 0), (0, K - n), (0, 0))) - push
    half = 0.5 * numbers.transit * np.diff(q.edges) * (numbers.impedance / numbers.share)
    weighted = half[:, None, None] * (_products(K) @ speed)
    form = push.reshape(-1, size).T @ weighted.reshape(-1, size)
    return np.asarray(0.5 * (form + form.T))


def _products(size: int) -> Array:
    """Integrals of ``T_i T_j`` over ``[-1, 1]``."""
    i, j = np.arange(size, dtype=float)[:, None], np.arange(size, dtype=float)[None, :]
    even = (i + j) % 2 == 0
    return np.where(even, 1.0 / (1.0 - (i + j) ** 2 * even) + 1.0 / (1.0 - (i - j) ** 2 * even), 0.0)


def passed(powers: Powers, X: Array) -> Array:
    """``Z/4 int W^2 dt`` (n,) over round trips [J]."""
    q = powers.quiet
    wave = X[:, : q.waves].reshape(len(X), q.pieces, -1)
    half = 0.125 * powers.numbers.impedance * powers.numbers.transit * np.diff(q.edges)
    return np.asarray((((wave @ _products(q.degree + 1)) * wave).sum(axis=2)) @ half)
