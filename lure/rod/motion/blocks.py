r"""States of consecutive round trips ``y_{n+1} = y_n + D y_n``: as Newton's series in the number of the round trip.

.. math:: y_n = \sum_j \binom{n}{j} D^j y_0.

Where ``D`` is small (a round trip changes little: soft contact, hardly any damping, slow forces) 32 terms hold for
thousands of round trips.  Elsewhere the states are made by doubling: those of ``2m`` round trips are those of ``m`` and
the same moved by ``m``, with ``D_{2m} = 2 D_m + D_m^2``, in which nothing is lost where ``D`` is small.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lure.record import described, quantity
from lure.rod.motion import kernel_free as F
from lure.rod.motion.pieces import Array, basis
from lure.rod.motion.record import Series
from lure.rod.motion.trip_matrix import TripMatrix

Counts = NDArray[np.int64]
PARTS = 64  # of a block
_MOST = 1024  # round trips made by doubling
_FEW = 16  # coordinates: powers of the matrix cost less than calls
LARGEST = 128  # state for which they are
MANY = 128  # numbers for which calls cost less than steps along short rows
_NOISE = 4e-16  # of the largest value: coefficients of a curve in the number of the round trip that are rounding
_OVER = np.append(0.0, 1.0 / np.arange(1, F.TERMS + 1))
_LESS = np.append(-1.0, np.arange(F.TERMS) * _OVER[1:])


def binomials(n: Array) -> Array:
    """(len(n), TERMS+1) the numbers ``n`` over ``0, ..., TERMS``, for whole ``n``."""
    if len(n) < MANY:
        return np.asarray(np.multiply.accumulate(np.multiply.outer(n, _OVER) - _LESS, axis=1))
    rows = np.multiply.outer(_OVER, n)
    rows -= _LESS[:, None]
    for before, row in pairwise(rows):
        row *= before
    return np.asarray(rows.T)


@lru_cache(maxsize=1)
def _growth() -> Array:
    """Those of all lengths that a series may have."""
    return binomials(np.array(F.LENGTHS, dtype=float))


@lru_cache(maxsize=64)
def _grid(count: int) -> tuple[Array, Array]:
    """Round trips at even distances from 0 to ``count``, and their binomials."""
    n = np.unique(np.round(np.linspace(0.0, count, PARTS + 1)))
    return n, binomials(n)


@lru_cache(maxsize=64)
def _curve(count: int) -> Array:
    """(TERMS+1, TERMS+1) from the terms of a series to Chebyshev coefficients on ``count`` round trips."""
    return np.asarray(basis(F.TERMS).from_inner @ binomials(0.5 * count * (basis(F.TERMS).inner + 1.0)))


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
        rows, zeta = np.empty((F.TERMS + 1, len(state))), self.trip.zeta
        rows[0] = state
        if len(state) <= _FEW:
            power = self.trip.step
            for m in (1, 2, 4, 8, 16):
                np.dot(rows[:m], power.T, out=rows[m : 2 * m])
                power = power @ power
            np.dot(power, state, out=rows[F.TERMS])
        else:
            line = list(rows)
            for j in range(F.TERMS):
                np.dot(self.trip.step, line[j], out=line[j + 1])
        if self._straight:
            rows[1:, zeta] = self._ways(rows[1:, zeta], rows[:-1], self.trip.step)
        return rows

    def length(self, rows: Array) -> int:
        """How far the series holds: 0 if it does not for twice as many round trips as it has terms."""
        setting, (wave, level) = self.trip.setting, (np.abs(rows) @ self._sizes).T.tolist()
        size = max(wave[0], abs(setting.push) + setting.rate * level[0], 1e-300)
        swing = max(2.0 * setting.transit * setting.share * size, 5e-324)
        most, reach, left = F.CANCELLED * size, F.CANCELLED * (level[0] + F.FIRST * swing), wave[-1] / size
        found, growth = 0, _growth()
        left = max(left, level[-1] / swing)
        sums = (growth @ np.array([wave, level]).T).tolist()
        for length, (waves, levels), last in zip(F.LENGTHS, sums, growth[:, -1].tolist(), strict=True):
            if not (waves <= most and levels <= reach and last * left <= F.LEFT_OUT):
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
        return np.where(np.abs(ways) <= F.WAY_BACK * (np.abs(rows) @ np.abs(step[self.trip.zeta])), 0.0, ways)

    def _power(self, k: int) -> Array:
        """``D_m`` for ``m = 2^k``."""
        while len(self._powers) <= k:
            self._powers.append(2.0 * self._powers[-1] + self._powers[-1] @ self._powers[-1])
        return self._powers[k]


@described(kw_only=True, eq=False, slots=True)
class Block:
    """Some round trips of an interval."""

    steps: Steps = quantity("What a round trip does")
    start: int = quantity("The first, counted from that of the interval")
    count: int = quantity("How many")
    value: float = quantity("``zeta`` there")
    rest: float = quantity("What rounding lost of it")
    state: Array = quantity("(N,) the state there")
    rows: Array | None = quantity("The terms of the series; None where the states are made by doubling")
    length: int = quantity("How many states are made then")

    def table(self) -> Array:
        """What :meth:`at` reads the states from."""
        return self.steps.states(self.state, self.length)[0] if self.rows is None else self.rows

    def at(self, n: Array, table: Array) -> Array:
        """Values (len(n), F) in round trips counted from the first of the block."""
        return table[n.astype(np.int64)] if self.rows is None else binomials(n) @ table

    def _functions(self, name: Series) -> Array:
        """(P, k, N) ``W`` or ``zeta`` on the pieces, of the states."""
        return self.steps.trip.wave if name == "wave" else self.steps.trip.series

    def read(self, n: Array, name: Series, pieces: Counts) -> tuple[Array, Array]:
        """(J, m, k) and (J, len(n)): ``W`` or ``zeta`` on pieces, in round trips of the block, is the sum of products.

        For many round trips a series is taken as one of Chebyshev, of which few terms can be seen.
        """
        functions = self._functions(name)[pieces]
        if self.rows is None:
            return functions.transpose(2, 0, 1), self.table()[n.astype(np.int64)].T
        return _shares(self.rows, functions.reshape(-1, functions.shape[2]).T, n, self.count, functions.shape[:2])

    def on_pieces(self, n: Array, name: Series) -> Array:
        """(len(n), P, k) the same on all pieces."""
        return np.asarray(np.einsum("pkn,in->ipk", self._functions(name), self.states(n)[0]))

    def ends(self, n: Array) -> tuple[Array, Array]:
        """``zeta`` (len(n), 2) with which round trips begin, and what rounding lost of it; the impulse so far."""
        states, levels = self.states(n)
        return levels, states[:, self.steps.trip.zeta + 1]

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

    def states(self, n: Array) -> tuple[Array, Array]:
        """The states (len(n), N) there; ``zeta`` (len(n), 2) and what rounding lost of it."""
        if self.rows is None:
            rows, gained = (found[n.astype(np.int64)] for found in self.steps.states(self.state, self.length))
        else:
            shares = binomials(n)
            rows, gained = shares @ self.rows, shares[:, 1:] @ self.rows[1:, self.steps.trip.zeta]
        return rows, _levels(self.value, self.rest, gained)


@described(frozen=True, kw_only=True, eq=False, slots=True)
class SeriesBlock:
    """The same from :mod:`lure.rod.motion.kernel_free`, in terms of what is read."""

    start: int = quantity("The first, counted from that of the interval")
    count: int = quantity("How many")
    value: float = quantity("``zeta`` there")
    rest: float = quantity("What rounding lost of it")
    wave: Array = quantity("(TERMS+1, P, k) the terms of the series of ``W`` on the pieces")
    zeta: Array = quantity("(TERMS+1, P, k) those of ``zeta``")
    begins: Array = quantity("(TERMS+1, 2) those of ``zeta`` and of the impulse with which round trips begin")

    def _terms(self, name: Series) -> Array:
        return self.wave if name == "wave" else self.zeta

    def read(self, n: Array, name: Series, pieces: Counts) -> tuple[Array, Array]:
        """See :meth:`Block.read`."""
        terms = self._terms(name)[:, pieces]
        return _shares(terms.reshape(F.TERMS + 1, -1), None, n, self.count, terms.shape[1:])

    def curve(self, name: Series) -> Array:
        """(J, P, k) the same on all pieces as Chebyshev series in the number of the round trip, on ``[0, count]``."""
        terms = self._terms(name)
        table = _curve(self.count) @ terms.reshape(F.TERMS + 1, -1)
        return table[: _seen(table)].reshape(-1, *terms.shape[1:])

    def on_pieces(self, n: Array, name: Series) -> Array:
        """See :meth:`Block.on_pieces`."""
        return np.asarray(np.tensordot(binomials(n), self._terms(name), 1))

    def ends(self, n: Array) -> tuple[Array, Array]:
        """See :meth:`Block.ends`."""
        shares = binomials(n)
        return _levels(self.value, self.rest, shares[:, 1:] @ self.begins[1:, 0]), shares @ self.begins[:, 1]


def series_blocks(g: Array, o: Counts, pieces: int) -> list[SeriesBlock]:
    """Those that :func:`lure.rod.motion.kernel_walk.free_trips` has entered."""
    _, blocks, *degrees = map(int, g[: F.ZETA_DEGREE + 1].tolist())
    starts = o[[F.WAVES, F.ZETAS, F.BEGINS]]
    shapes = [(blocks, F.TERMS + 1, pieces, n + 1) for n in degrees] + [(blocks, F.TERMS + 1, 2)]
    series = [
        g[at : at + math.prod(shape)].reshape(shape).copy() for at, shape in zip(starts.tolist(), shapes, strict=True)
    ]
    counts = g[o[F.COUNTS] : o[F.COUNTS] + blocks].tolist()
    levels = g[o[F.LEVELS] : o[F.LEVELS] + 2 * blocks].tolist()
    found, start = [], 0
    for b, count in enumerate(map(int, counts)):
        value, rest = levels[2 * b : 2 * b + 2]
        wave, zeta, begins = (part[b] for part in series)
        found.append(SeriesBlock(start=start, count=count, value=value, rest=rest, wave=wave, zeta=zeta, begins=begins))
        start += count
    return found


def _shares(rows: Array, functions: Array | None, n: Array, count: int, shape: tuple[int, ...]) -> tuple[Array, Array]:
    """See :meth:`Block.read`: of functions (N, m k) of the states, or of the terms themselves."""
    terms = rows if len(n) < MANY else _curve(count) @ rows
    if functions is not None:
        terms = terms @ functions
    if len(n) < MANY:
        return terms.reshape(-1, *shape), binomials(n).T
    seen = _seen(terms)
    weights, x = np.empty((max(seen, 2), len(n))), n * (2.0 / count)
    x -= 1.0
    weights[0], weights[1] = 1.0, x
    x += x
    for k in range(2, seen):
        np.multiply(x, weights[k - 1], out=weights[k])
        weights[k] -= weights[k - 2]
    return terms[:seen].reshape(-1, *shape), weights[:seen]


def _seen(table: Array) -> int:
    """How many terms (J, m) of Chebyshev series are more than rounding."""
    size = np.maximum.reduce(np.abs(table), axis=1)
    seen = (size > _NOISE * size.max()).nonzero()[0]
    return int(seen[-1]) + 1 if len(seen) else 1


def _levels(value: float, rest: float, gained: Array) -> Array:
    """(n, 2) ``zeta`` and what rounding lost of it, after it has gained so much."""
    small = rest + gained
    total = value + small
    back = total - value
    return np.column_stack((total, (value - (total - back)) + (small - back)))


def block_after(steps: Steps, last: Block | None, state: Array, level: tuple[float, float]) -> Block | None:
    """The block that begins with a state, as long as it may be; None if the state is too large for doubling."""
    start, length, rows = 0 if last is None else last.start + last.count, 0, None
    if last is None or last.rows is not None:
        rows = steps.differences(state)
        length = steps.length(rows)
    if not length:
        if len(state) > LARGEST:
            return None
        rows, length = None, F.FIRST if last is None or last.rows is not None else min(2 * last.length, _MOST)
    return Block(
        steps=steps, start=start, count=length, value=level[0], rest=level[1], state=state, rows=rows, length=length
    )
