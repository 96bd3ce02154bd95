r"""States of consecutive round trips ``y_{n+1} = y_n + D y_n``: as Newton's series in the number of the round trip.

.. math:: y_n = \sum_j \binom{n}{j} D^j y_0.

Where ``D`` is small (a round trip changes little: soft contact, hardly any damping, slow forces) 32 terms hold for
thousands of round trips.  Elsewhere the states are made by doubling: those of ``2m`` round trips are those of ``m`` and
the same moved by ``m``, with ``D_{2m} = 2 D_m + D_m^2``, in which nothing is lost where ``D`` is small.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lure.rod.motion.pieces import Array, basis
from lure.rod.motion.trip_matrix import TripMatrix

Counts = NDArray[np.int64]
TERMS = 32
PARTS = 64  # of a block
_LENGTHS = np.array([16 * round(2 ** (k / 2)) for k in range(4, 19)])
_LEFT_OUT = 1e-17  # of the wave: what the series leaves out
_CANCELLED = 8.0  # what its terms may exceed the wave by
_WAY_BACK = 4e-16  # of all ways there and back
_FIRST, _MOST = 64, 1024  # round trips made by doubling
_FEW = 16  # coordinates: powers of the matrix cost less than calls
LARGEST = 128  # state for which they are
_MANY = 128  # numbers for which calls cost less than steps along short rows
_NOISE = 4e-16  # of the largest value: coefficients of a curve in the number of the round trip that are rounding
_OVER = np.append(0.0, 1.0 / np.arange(1, TERMS + 1))
_LESS = np.append(-1.0, np.arange(TERMS) * _OVER[1:])


def binomials(n: Array) -> Array:
    """(len(n), TERMS+1) the numbers ``n`` over ``0, ..., TERMS``, for whole ``n``."""
    if len(n) < _MANY:
        return np.asarray(np.multiply.accumulate(np.multiply.outer(n, _OVER) - _LESS, axis=1))
    rows = np.multiply.outer(_OVER, n)
    rows -= _LESS[:, None]
    for before, row in pairwise(rows):
        row *= before
    return np.asarray(rows.T)


@lru_cache(maxsize=1)
def _growth() -> Array:
    """Those of all lengths that a series may have."""
    return binomials(_LENGTHS.astype(float))


@lru_cache(maxsize=64)
def _grid(count: int) -> tuple[Array, Array]:
    """Round trips at even distances from 0 to ``count``, and their binomials."""
    n = np.unique(np.round(np.linspace(0.0, count, PARTS + 1)))
    return n, binomials(n)


@lru_cache(maxsize=64)
def _curve(count: int) -> Array:
    """(TERMS+1, TERMS+1) from the terms of a series to Chebyshev coefficients on ``count`` round trips."""
    return np.asarray(basis(TERMS).from_inner @ binomials(0.5 * count * (basis(TERMS).inner + 1.0)))


class Steps:
    """A round trip as a matrix, and so many at once."""

    def __init__(self, trip: TripMatrix) -> None:
        self.trip, self._powers = trip, [trip.step]
        self._last: tuple[Array | None, Array, Array] = None, trip.step, trip.step
        self._straight = trip.setting.rate == 0.0
        # how large a coordinate of the wave is, and zeta
        self._sizes = np.zeros((len(trip.step), 2))
        self._sizes[: trip.zeta, 0] = np.add.reduce(np.abs(trip.wave[:, :, : trip.zeta]), axis=1).max(axis=0)
        self._sizes[trip.zeta, 1] = 1.0

    def differences(self, state: Array) -> Array:
        """(TERMS+1, N) the terms ``D^j y`` of the series."""
        rows, zeta = np.empty((TERMS + 1, len(state))), self.trip.zeta
        rows[0] = state
        if len(state) <= _FEW:
            power = self.trip.step
            for m in (1, 2, 4, 8, 16):
                np.dot(rows[:m], power.T, out=rows[m : 2 * m])
                power = power @ power
            np.dot(power, state, out=rows[TERMS])
        else:
            line = list(rows)
            for j in range(TERMS):
                np.dot(self.trip.step, line[j], out=line[j + 1])
        if self._straight:
            rows[1:, zeta] = self._ways(rows[1:, zeta], rows[:-1], self.trip.step)
        return rows

    def length(self, rows: Array) -> int:
        """How far the series holds: 0 if it does not for twice as many round trips as it has terms."""
        setting, (wave, level) = self.trip.setting, (np.abs(rows) @ self._sizes).T.tolist()
        size = max(wave[0], abs(setting.push) + setting.rate * level[0], 1e-300)
        swing = max(2.0 * setting.transit * setting.share * size, 5e-324)
        most, reach, left = _CANCELLED * size, _CANCELLED * (level[0] + _FIRST * swing), wave[-1] / size
        found, growth = 0, _growth()
        left = max(left, level[-1] / swing)
        sums = (growth @ np.array([wave, level]).T).tolist()
        for length, (waves, levels), last in zip(_LENGTHS.tolist(), sums, growth[:, -1].tolist(), strict=True):
            if not (waves <= most and levels <= reach and last * left <= _LEFT_OUT):
                break
            found = length
        return found

    def states(self, state: Array, count: int) -> tuple[Array, Array]:
        """(count+1, N) the states of so many round trips, a power of two, and the next; what ``zeta`` has gained."""
        if self._last[0] is state and len(self._last[2]) == count + 1:
            return self._last[1:]
        zeta, rows, gained = self.trip.zeta, np.empty((count + 1, len(state))), np.zeros(count + 1)
        rows[0], m, k = state, 1, 0
        while m <= count:
            few = min(m, count + 1 - m)  # one at last
            power = self._power(k) if few == m else self.trip.step
            known = rows[m - few : m]
            moved = known @ power.T
            if self._straight:
                moved[:, zeta] = self._ways(moved[:, zeta], known, power)
            gained[m : m + few] = gained[m - few : m] + moved[:, zeta]
            rows[m : m + few] = known + moved
            rows[m : m + few, zeta] = state[zeta] + gained[m : m + few]
            m, k = m + few, k + 1
        self._last = state, rows, gained
        return rows, gained

    def _ways(self, ways: Array, rows: Array, step: Array) -> Array:
        """Ways in free flight; those there and back are none."""
        return np.where(np.abs(ways) <= _WAY_BACK * (np.abs(rows) @ np.abs(step[self.trip.zeta])), 0.0, ways)

    def _power(self, k: int) -> Array:
        """``D_m`` for ``m = 2^k``."""
        while len(self._powers) <= k:
            self._powers.append(2.0 * self._powers[-1] + self._powers[-1] @ self._powers[-1])
        return self._powers[k]


@dataclass(kw_only=True, eq=False, slots=True)
class Block:
    """Some round trips of an interval.

    Attributes
    ----------
    start, count : int
        The first, counted from that of the interval, and how many.
    value, rest : float
        ``zeta`` there and what rounding lost of it.
    state : ndarray
        (N,) the state there.
    rows : ndarray or None
        The terms of the series; None where the states are made by doubling.
    length : int
        How many states are made then.
    """

    start: int
    count: int
    value: float
    rest: float
    state: Array
    rows: Array | None
    length: int

    def table(self, steps: Steps, functions: Array | None = None) -> Array:
        """What :meth:`at` reads functions (F, N) of the states from, or the states."""
        rows = steps.states(self.state, self.length)[0] if self.rows is None else self.rows
        return rows if functions is None else rows @ functions.T

    def at(self, n: Array, table: Array) -> Array:
        """Values (len(n), F) in round trips counted from the first of the block."""
        return table[n.astype(np.int64)] if self.rows is None else binomials(n) @ table

    def read(self, n: Array, functions: Array, steps: Steps) -> tuple[Array, Array]:
        """(R, J) and (J, len(n)), the product of which are functions (R, N) of the states in round trips of the block.

        For many round trips a series is taken as one of Chebyshev, of which few terms can be seen.
        """
        if self.rows is None:
            return functions, self.table(steps)[n.astype(np.int64)].T
        if len(n) < _MANY:
            return functions @ self.rows.T, binomials(n).T
        table = functions @ (_curve(self.count) @ self.rows).T
        size = np.maximum.reduce(np.abs(table))
        terms = int((size > _NOISE * size.max()).nonzero()[0].max(initial=0)) + 1
        weights, x = np.empty((max(terms, 2), len(n))), n * (2.0 / self.count)
        x -= 1.0
        weights[0], weights[1] = 1.0, x
        x += x
        for k in range(2, terms):
            np.multiply(x, weights[k - 1], out=weights[k])
            weights[k] -= weights[k - 2]
        return table[:, :terms], weights[:terms]

    def grid(self, table: Array) -> tuple[Array, Array]:
        """Round trips that cover the block, and the values there."""
        if self.rows is None:
            return np.arange(self.count + 1.0), table[: self.count + 1]
        n, shares = _grid(self.count)
        return n, shares @ table

    def sizes(self, table: Array) -> Array:
        """(F,) bounds on the values."""
        size = np.abs(table)
        return np.asarray(size.max(axis=0) if self.rows is None else _grid(self.count)[1][-1] @ size)

    def bends(self, table: Array) -> Array:
        """(F,) bounds on their second differences; 0 where all are looked at."""
        if self.rows is None:
            return np.zeros(table.shape[1])
        return np.asarray(_grid(self.count)[1][-1, :-2] @ np.abs(table[2:]))

    def states(self, n: Array, steps: Steps) -> tuple[Array, Array]:
        """The states (len(n), N) there; ``zeta`` (len(n), 2) and what rounding lost of it."""
        if self.rows is None:
            rows, gained = (found[n.astype(np.int64)] for found in steps.states(self.state, self.length))
        else:
            shares = binomials(n)
            rows, gained = shares @ self.rows, shares[:, 1:] @ self.rows[1:, steps.trip.zeta]
        small = self.rest + gained
        levels = np.empty((len(n), 2))
        levels[:, 0] = total = self.value + small
        back = total - self.value
        levels[:, 1] = (self.value - (total - back)) + (small - back)
        return rows, levels


def block_after(steps: Steps, last: Block | None, state: Array, level: tuple[float, float]) -> Block | None:
    """The block that begins with a state, as long as it may be; None if the state is too large for doubling."""
    start, length, rows = 0 if last is None else last.start + last.count, 0, None
    if last is None or last.rows is not None:
        rows = steps.differences(state)
        length = steps.length(rows)
    if not length:
        if len(state) > LARGEST:
            return None
        rows, length = None, _FIRST if last is None or last.rows is not None else min(2 * last.length, _MOST)
    return Block(start=start, count=length, value=level[0], rest=level[1], state=state, rows=rows, length=length)
