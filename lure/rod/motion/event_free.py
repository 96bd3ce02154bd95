"""Intervals without events: many round trips as one state each, evaluated where it is asked for."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from lure.rod.motion import kernel_tables as kernel
from lure.rod.motion.exponential_force import ExponentialForces
from lure.rod.motion.kernel_follow import LEAST
from lure.rod.motion.kernel_interval import PUSH_, RETURNED_, WAVE_, Z_
from lure.rod.motion.kernel_series import COUNT, DEGREE, SEGMENT, TRIP
from lure.rod.motion.pieces import Array, basis, left_ends, restricted, right_ends, upper_bounds
from lure.rod.motion.record import Record, Series, Window
from lure.rod.motion.sources import Problem
from lure.rod.motion.trip_matrix import Doubles
from lure.rod.sampled import Contact

CHUNK = 1024
_MOST_NUMBERS = 1 << 19  # in the states that are kept of an interval
_MOST_PIECES = 64
_NAMES = {"wave": WAVE_, "returned": RETURNED_, "push": PUSH_, "z": Z_}
Functions = tuple[Callable[..., Any], Callable[..., Any], Callable[..., Any]]


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class EventFreeInterval:
    """Round trips ``number .. number + count - 1``, as :class:`lure.rod.motion.record.Record` has them.

    Attributes
    ----------
    number, count : int
        The first round trip, and how many there are.
    share : float
        ``1/(1 + k_L/Z)``.
    mobility : float
        ``d`` with the share of a dashpot: from stresses to waves.
    index : int
        Place of the segment in the nonlinearity.
    impact : Contact or None
        As it was before.
    memory : tuple
        ``s``, ``d``, ``force`` and ``states``, see :mod:`lure.rod.motion.kernel_tables`.
    functions : tuple
        The functions of the kernel, compiled or as they stand.
    before : int
        Round trips in the memory before the first.
    """

    number: int
    count: int
    share: float
    mobility: float
    index: int
    impact: Contact | None
    memory: tuple[Any, Any, Any, Any]
    functions: Functions
    before: int = 0
    _made: dict[object, object] = field(default_factory=dict)

    def __len__(self) -> int:
        """Number of round trips."""
        return self.count

    def _table(self, name: int, *shape: int) -> Array:
        """One of the tables."""
        s, d, *_ = self.memory
        place, size = int(d[name]), int(np.prod(shape))
        return np.asarray(s)[place : place + size].reshape(shape)

    @property
    def span(self) -> Array:
        """(P+1,) ends of the pieces in every round trip."""
        return self._table(kernel.EDGES, int(self.memory[1][kernel.PIECES_]) + 1).copy()

    @property
    def stop(self) -> float:
        """Where the last round trip ends, from its start [transits]."""
        return float(self.span[-1])

    @property
    def impacts(self) -> Array:
        """(0, 4): none ended."""
        return np.empty((0, 4))

    def edges(self, i: int) -> Array:
        """Edges of the pieces of the i-th round trip."""
        return self.span

    def at(self, t: Array, name: Series) -> Array:
        """Values (n,) at instants (n,) [transits]; on an edge those from the right."""
        order = None if np.all(t[1:] >= t[:-1]) else np.argsort(t, kind="stable")
        given = np.ascontiguousarray(t if order is None else t[order])
        found = np.empty(len(t))
        self.functions[1](self.memory, (given, found), self.before + self.count, _NAMES[name])
        if order is not None:
            found[order] = found.copy()
        return found

    def every(self, first: int, stop: int) -> Array:
        """(stop - first + 1, S) the states in consecutive round trips, counted from the first, and the one after."""
        out = np.empty((stop - first + 1) * self._size)
        self.functions[2](self.memory, self.before + first, self.before + stop, out)
        return out.reshape(-1, self._size)

    @property
    def _size(self) -> int:
        """Of a state."""
        d = self.memory[1]
        return kernel.HEAD + int(d[kernel.PIECES_]) * (int(d[kernel.TOP_DEGREE]) + 1)

    def series(self, X: Array) -> tuple[Array, Array]:
        """``W`` (n, P, degree+1) and ``zeta`` (n, P, K) on the pieces, for states (n, S)."""
        d = self.memory[1]
        P, n, depth, width = (int(d[name]) for name in (kernel.PIECES_, kernel.TOP_DEGREE, kernel.DEPTH, kernel.WIDTH))
        wave = X[:, kernel.HEAD :].reshape(len(X), n + 1, P).transpose(0, 2, 1)
        own = self._table(kernel.OWN, P, width, width)[:, :depth, : n + 1]
        hold, level = (self._table(name, P, width)[:, :depth] for name in (kernel.HOLD, kernel.LEVEL))
        ends, hold_ends, level_ends = (
            self._table(name, *shape)
            for name, shape in ((kernel.OF_END, (n + 1, P)), (kernel.HOLD_END, (P,)), (kernel.LEVEL_END, (P,)))
        )
        starts, travelled = np.empty((len(X), P)), X[:, 1].copy()
        for p in range(P):
            starts[:, p] = X[:, 0] + travelled
            travelled += wave[:, p] @ ends[:, p] + level_ends[p] + hold_ends[p] * starts[:, p]
        zeta = np.einsum("pkj,ipj->ipk", own, wave) + hold * starts[:, :, None] + level
        return wave, zeta

    def record(self, first: int, stop: int) -> Record:
        """Some of the round trips, counted from the first, piece by piece."""
        s, d, *_ = self.memory
        count, P, width = stop - first, int(d[kernel.PIECES_]), int(d[kernel.WIDTH])
        origin, T = float(s[kernel.FROM]), float(s[kernel.TIME])
        X, edges, touching = self.every(first, stop), self.span, float(s[kernel.LOADING]) > 0.0
        wave, zeta = self.series(X[:-1])
        push = self._pushes(zeta)
        z = zeta.copy()
        z[:, :, 0] += origin
        coef = np.concatenate((wave, z, push), axis=2)
        degree = np.tile([wave.shape[2] - 1, z.shape[2] - 1, push.shape[2] - 1], (count * P, 1))
        endings = np.zeros((count, 7))
        endings[:, 0], endings[:, 1], endings[:, 2] = s[kernel.MISSED_], X[1:, 0], X[1:, 1]
        if touching:
            since = T * 2.0 * self.number if self.impact is None else self.impact.start
            endings[:, 3], endings[:, 5] = since, X[1:, 2]
            endings[:, 4] = T * 2.0 * (self.number + np.arange(first, stop) + 1.0)
            endings[:, 6] = self._peaks()[first:stop]
        marks = np.zeros((count, 4), dtype=np.int64)
        marks[:, 0], marks[:, 1] = self.index, touching
        return Record(
            number=self.number + first,
            share=self.share,
            width=width,
            first=P * np.arange(count + 1),
            low=np.tile(edges[:-1], count),
            high=np.tile(edges[1:], count),
            start=coef.shape[2] * np.arange(count * P),
            degree=degree,
            coef=coef.ravel(),
            endings=endings,
            marks=marks,
            impacts=self.impacts,
        )

    def pushes(self, first: int, stop: int) -> Array:
        """``d p`` (n, P, K) on the pieces of consecutive round trips, counted from the first."""
        return self._pushes(self.series(self.every(first, stop)[:-1])[1])

    def _pushes(self, zeta: Array) -> Array:
        rate = float(self.memory[0][kernel.STIFFNESS])
        push = rate * zeta if rate else np.zeros((*zeta.shape[:2], 1))
        push[:, :, 0] += self.memory[0][kernel.PUSHED]
        return push

    def _peaks(self) -> Array:
        """Largest stress [Pa] of the impact up to the end of each round trip."""
        if "peaks" not in self._made:
            self._made["peaks"] = running_peaks(self)
        peaks = self._made["peaks"]
        assert isinstance(peaks, np.ndarray)
        return peaks

    def window(self, i: int) -> Window:
        """The i-th round trip on its own."""
        chunk = i // CHUNK
        key = ("record", chunk)
        if key not in self._made:
            for other in [other for other in self._made if isinstance(other, tuple)]:
                del self._made[other]
            self._made[key] = self.record(chunk * CHUNK, min((chunk + 1) * CHUNK, self.count))
        record = self._made[key]
        assert isinstance(record, Record)
        return record.window(i - chunk * CHUNK)

    def last(self, count: int) -> Record | EventFreeInterval:
        """The last round trips."""
        if count >= self.count:
            return self
        if count <= CHUNK:
            return self.record(self.count - count, self.count)
        s, d, force, states = self.memory
        before = self.before + self.count - count
        row = before // int(d[kernel.STRIDE])
        s, d = copy(s), copy(d)
        s[kernel.AT_HAND] = -1.0  # none
        d[kernel.NUMBER] += row * d[kernel.STRIDE]
        states = states[row * self._size :]
        return replace(
            self,
            number=self.number + self.count - count,
            count=count,
            before=before - row * int(d[kernel.STRIDE]),
            impact=self.record(self.count - count - 1, self.count - count).window(0).end.impact,
            memory=(s, d, force, states),
            _made={},
        )


class Finder:
    """Looks for event-free intervals of one motion."""

    def __init__(self, problem: Problem, functions: Functions, *, compiled: bool) -> None:
        self._problem, self.loads, self._functions = problem, ExponentialForces(problem.sources), functions
        self._compiled, self._total = compiled, math.floor(0.5 * problem.transits)

    def after(self, f: Any, q: Any, impact: Contact | None) -> EventFreeInterval | None:  # noqa: ANN401  (two kinds of array)
        """The interval that begins with the next round trip; None if there is none of 16."""
        number, pieces = int(q[TRIP]), int(q[COUNT])
        states, end = self.loads.over(number)
        most = min(self._total, math.floor(0.5 * end) if end < math.inf else self._total) - number
        if states is None or pieces > _MOST_PIECES:
            return None
        most = min(most, states.finite_until - number)
        if most < LEAST:
            return None
        width, columns = int(q[DEGREE]) + 1, states.columns
        d = np.zeros(kernel.PLACES, dtype=np.int64)
        s = np.zeros(kernel.places(d, pieces, width, columns, len(states.powers)))
        size = kernel.HEAD + pieces * width
        d[kernel.STRIDE] = 1 << max(0, math.ceil(math.log2(most * size / _MOST_NUMBERS)))
        rows = -(-most // int(d[kernel.STRIDE]))
        kept, groups = np.empty(rows * size), np.empty(kernel.GROUP_SIZE * -(-most // kernel.GROUP))
        arrays: tuple[Any, Any, Any, Any] = s, d, states.table, kept
        if not self._compiled:
            made = (array("q", d.tobytes()), array("d", states.table.tobytes()), array("d", kept.tobytes()))
            arrays = (Doubles("d", s.tobytes()), *made)
        count = int(self._functions[0]((f, q), arrays, groups, most))
        if not count:
            return None
        used = -(-count // int(d[kernel.STRIDE])) * (kernel.HEAD + pieces * (int(arrays[1][kernel.TOP_DEGREE]) + 1))
        return EventFreeInterval(
            number=number,
            count=count,
            share=self._problem.share,
            mobility=self._problem.sources.rod.mobility * self._problem.share,
            index=int(q[SEGMENT]),
            impact=impact,
            memory=(*arrays[:3], arrays[3][:used]),
            functions=self._functions,
        )


def running_peaks(interval: EventFreeInterval) -> Array:
    """Largest stress (count,) [Pa] of the impact up to the end of each round trip."""
    impact = interval.impact
    best = -np.inf if impact is None else impact.peak_stress * interval.mobility
    found = []
    for low in range(0, len(interval), CHUNK):
        push = interval.pushes(low, min(low + CHUNK, len(interval)))
        flat = push.reshape(-1, push.shape[2])
        least = np.maximum(left_ends(flat), right_ends(flat)).reshape(push.shape[:2]).max(axis=1)
        most = upper_bounds(flat).reshape(push.shape[:2]).max(axis=1)
        before = np.maximum.accumulate(np.append(best, least))[:-1]
        for i in np.flatnonzero(most > np.maximum(before, least)):
            least[i] = max(least[i], largest_value(push[i]))
        found.append(np.maximum.accumulate(np.append(best, least))[1:])
        best = float(found[-1][-1])
    return np.concatenate(found) / interval.mobility


def largest_value(series: Array) -> float:
    """The largest value on any piece, to rounding: pieces that may hold it are halved while a bound exceeds the best.

    >>> largest_value(np.array([[0.0, 0.5, -0.5]]))  # -x^2 + x/2 + 1/2 is largest at x = 1/4
    0.5625
    """
    space = basis(series.shape[1] - 1)
    best = -np.inf
    for _ in range(40):
        sampled = series @ space.at_ends.T
        best = max(best, float(sampled.max(initial=-np.inf)))
        size = float(np.abs(series).sum(axis=1).max(initial=0.0))
        open_ = series[upper_bounds(series) > best + 1e-15 * size]
        if not len(open_):
            break
        low, high = np.full(len(open_), -1.0), np.zeros(len(open_))
        series = np.concatenate((restricted(open_, low, high), restricted(open_, high, -low)))
    return best
