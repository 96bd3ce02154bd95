"""Round trips in which nothing happens, as one state every 64 of them: evaluated where it is asked for."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from lure.rod.motion.event_free_map import Powers
from lure.rod.motion.pieces import Array, basis, left_ends, restricted, right_ends, upper_bounds
from lure.rod.motion.record import Record, Series, Window
from lure.rod.sampled import Contact

BLOCK_POWER, FINE_POWER = 6, 3
BLOCK, FINE = 2**BLOCK_POWER, 2**FINE_POWER
CHUNK = 1024
_FEW = 32  # round trips that are looked at first
_MANY = 4096


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class EventFreeInterval:
    """Round trips ``number .. number + count - 1``, as :class:`lure.rod.motion.record.Record` has them.

    Attributes
    ----------
    powers : Powers
        The map from each to the next.
    number, count : int
        The first round trip, and how many there are.
    share : float
        ``1/(1 + k_L/Z)``.
    width : int
        ``N + 1`` of the records made of it.
    index : int
        Place of the segment in the nonlinearity.
    states : ndarray
        (B, S) the state in round trips ``number + 64 b``.
    rests : ndarray
        (B,) what rounding lost of ``zeta`` there.
    error : float
        Local error of a round trip [m].
    impact : Contact or None
        As it was before.
    """

    powers: Powers
    number: int
    count: int
    share: float
    width: int
    index: int
    states: Array
    rests: Array
    error: float
    impact: Contact | None
    _made: dict[object, object] = field(default_factory=dict)

    def __len__(self) -> int:
        """Number of round trips."""
        return self.count

    @property
    def stop(self) -> float:
        """Where the last round trip ends, from its start [transits]."""
        return float(self.powers.map.edges[-1])

    @property
    def impacts(self) -> Array:
        """(0, 4): none ended."""
        return np.empty((0, 4))

    def edges(self, i: int) -> Array:
        """Edges of the pieces of the i-th round trip."""
        return self.powers.map.edges

    def at(self, t: Array, name: Series) -> Array:
        """Values (n,) at instants (n,) [transits]; on an edge those from the right."""
        parts = [self._at(t[i : i + _MANY], name) for i in range(0, len(t), _MANY)]
        return np.concatenate(parts) if parts else np.empty(0)

    def _at(self, t: Array, name: Series) -> Array:
        trip_map, share = self.powers.map, self.share
        trip = np.clip(np.floor(0.5 * t).astype(np.int64) - self.number, 0, self.count - 1)
        local = t - 2.0 * (trip + self.number)
        piece = np.clip(np.searchsorted(trip_map.edges, local, side="right") - 1, 0, trip_map.pieces - 1)
        low, high = trip_map.edges[piece], trip_map.edges[piece + 1]
        x = np.clip(((local - low) - (high - local)) / (high - low), -1.0, 1.0)
        X, rest = self.states_in(trip)
        n = trip_map.degree + 1
        own = X[:, : trip_map.waves].reshape(len(X), -1, n)[np.arange(len(X)), piece]
        table = np.ones((trip_map.start.shape[1], len(x)))
        table[1] = x
        for k in range(2, len(table)):
            table[k] = 2.0 * x * table[k - 1] - table[k - 2]
        wave = (table[:n].T * own).sum(axis=1)
        if name == "wave":
            return np.asarray(wave)
        zeta = X[:, trip_map.waves] + (rest + self._begun(X, piece))
        series = (
            np.einsum("ski,si->ks", trip_map.own[piece], own) + trip_map.level[piece].T + trip_map.start[piece].T * zeta
        )
        zeta = zeta + (table * series).sum(axis=0)
        if name == "z":
            return np.asarray(trip_map.segment.origin + zeta)
        push = trip_map.segment.push + trip_map.segment.rate * zeta
        return np.asarray(push if name == "push" else (2.0 * share - 1.0) * wave - 2.0 * push)

    def _begun(self, X: Array, piece: NDArray[np.int64]) -> Array:
        """``zeta`` at the start of a piece, less that at the start of the round trip."""
        trip_map = self.powers.map
        return np.asarray((X @ trip_map.begins[:-1].T)[np.arange(len(X)), piece] + trip_map.begin[piece])

    def states_in(self, trip: NDArray[np.int64]) -> tuple[Array, Array]:
        """States (n, S) in round trips counted from the first, and what rounding lost of ``zeta``."""
        fine = "fine" in self._made or 2 * len(trip) > len(self.states) * (BLOCK // FINE)
        level = FINE_POWER if fine else BLOCK_POWER
        X = (self._fine() if fine else self.states)[trip >> level]
        for k in range(level):
            some = np.flatnonzero(trip >> k & 1)
            if some.size:
                here = (trip[some] >> level << level) + (trip[some] & ((1 << k) - 1))
                X[some] = self.powers[k].applied(X[some], self.powers.at((self.number + here).astype(float)))
        return X, self.rests[trip >> BLOCK_POWER]

    def _fine(self) -> Array:
        """(8 B, S) the state in every eighth round trip."""
        if "fine" not in self._made:
            self._made["fine"] = self._spread(self.states, np.arange(len(self.states)) * BLOCK, FINE_POWER)
        found = self._made["fine"]
        assert isinstance(found, np.ndarray)
        return found

    def _spread(self, states: Array, trips: NDArray[np.int64], least: int) -> Array:
        """States in every ``2**least``-th round trip of the blocks that begin in some."""
        table, at = states[:, None, :], trips[:, None]
        for k in range(BLOCK_POWER - 1, least - 1, -1):
            flat = self.powers[k].applied(
                table.reshape(-1, table.shape[2]), self.powers.at((self.number + at.ravel()).astype(float))
            )
            table = np.stack((table, flat.reshape(table.shape)), axis=2).reshape(len(states), -1, table.shape[2])
            at = np.stack((at, at + (1 << k)), axis=2).reshape(len(states), -1)
        return np.asarray(table.reshape(-1, table.shape[2]))

    def every(self, first: int, stop: int) -> Array:
        """(stop - first, S) the states in consecutive round trips, counted from the first."""
        low, high = first // BLOCK, -(-stop // BLOCK)
        blocks = np.arange(low, high)
        table = self._spread(self.states[low:high], blocks * BLOCK, 0)
        table[:, self.powers.map.waves] += np.repeat(self.rests[low:high], BLOCK)
        return table[first - low * BLOCK : stop - low * BLOCK]

    def series(self, X: Array) -> tuple[Array, Array]:
        """``W`` (n, P, degree+1) and ``zeta`` (n, P, K) on the pieces, for states (n, S)."""
        trip_map = self.powers.map
        travel, constant = trip_map.travel, trip_map.steady
        zeta = (X @ travel.reshape(-1, trip_map.size).T).reshape(len(X), *constant.shape) + constant
        zeta[:, :, 0] += X[:, trip_map.waves, None]
        return X[:, : trip_map.waves].reshape(len(X), trip_map.pieces, -1), zeta

    def record(self, first: int, stop: int) -> Record:
        """Some of the round trips, counted from the first, piece by piece."""
        trip_map, count = self.powers.map, stop - first
        segment, P = trip_map.segment, trip_map.pieces
        X = self.every(first, stop + 1) if stop < BLOCK * len(self.states) else self._with_last(first, stop)
        wave, zeta = self.series(X[:-1])
        push = segment.rate * zeta if segment.rate else np.zeros((count, P, 1))
        push[:, :, 0] += segment.push
        push = push[:, :, : self.width]  # higher degrees are below rounding
        z = zeta[:, :, : self.width].copy()
        z[:, :, 0] += segment.origin
        coef = np.concatenate((wave, z, push), axis=2)
        degree = np.tile([wave.shape[2] - 1, z.shape[2] - 1, push.shape[2] - 1], (count * P, 1))
        T = self.powers.numbers.transit
        endings = np.zeros((count, 7))
        endings[:, 0], endings[:, 1] = self.error, X[1:, trip_map.waves]
        if segment.touching:
            since = T * 2.0 * self.number if self.impact is None else self.impact.start
            endings[:, 3], endings[:, 5] = since, X[1:, trip_map.waves + 1]
            endings[:, 4] = T * 2.0 * (self.number + np.arange(first, stop) + 1.0)
            endings[:, 6] = self._peaks()[first:stop]
        marks = np.zeros((count, 4), dtype=np.int64)
        marks[:, 0], marks[:, 1] = self.index, segment.touching
        return Record(
            number=self.number + first,
            share=self.share,
            width=self.width,
            first=P * np.arange(count + 1),
            low=np.tile(trip_map.edges[:-1], count),
            high=np.tile(trip_map.edges[1:], count),
            start=coef.shape[2] * np.arange(count * P),
            degree=degree,
            coef=coef.ravel(),
            endings=endings,
            marks=marks,
            impacts=self.impacts,
        )

    def _with_last(self, first: int, stop: int) -> Array:
        X = self.every(first, stop)
        return np.vstack((X, self.powers[0].applied(X[-1:], self.powers.at(np.array([self.number + stop - 1.0])))))

    def _peaks(self) -> Array:
        """Largest stress [Pa] of the impact up to the end of each round trip."""
        if "peaks" not in self._made:
            self._made["peaks"] = running_peaks(self)
        peaks = self._made["peaks"]
        assert isinstance(peaks, np.ndarray)
        return peaks

    @property
    def mobility(self) -> float:
        """``d`` with the share of a dashpot: from stresses to waves."""
        return self.powers.numbers.mobility

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
        trips = np.arange(self.count - count, self.count, BLOCK)
        states, rests = self.states_in(trips)
        before = self.record(int(trips[0]) - 1, int(trips[0])).window(0).end.impact
        return replace(
            self,
            number=self.number + int(trips[0]),
            count=count,
            states=states,
            rests=rests,
            impact=before,
            _made={},
        )


def running_peaks(interval: EventFreeInterval) -> Array:
    """Largest stress (count,) [Pa] of the impact up to the end of each round trip."""
    segment, impact = interval.powers.map.segment, interval.impact
    best = -np.inf if impact is None else impact.peak_stress * interval.mobility
    found = []
    for low in range(0, len(interval), CHUNK):
        zeta = interval.series(interval.every(low, min(low + CHUNK, len(interval))))[1]
        push = segment.rate * zeta
        push[:, :, 0] += segment.push
        flat = push.reshape(-1, push.shape[2])
        least = np.maximum(left_ends(flat), right_ends(flat)).reshape(push.shape[:2]).max(axis=1)
        most = upper_bounds(flat).reshape(push.shape[:2]).max(axis=1)
        before = np.maximum.accumulate(np.append(best, least))[:-1]
        for i in np.flatnonzero(most > np.maximum(before, least)):
            least[i] = max(least[i], largest_value(push[i]))
        found.append(np.maximum.accumulate(np.append(best, least))[1:])
        best = float(found[-1][-1])
    return np.concatenate(found) / interval.mobility


def peak(interval: EventFreeInterval, tops: Array, best: float) -> float:
    """The largest ``zeta``, given upper bounds (count,) round trip by round trip, and a value that it has."""
    some = np.flatnonzero(tops > best)
    some, size = some[np.argsort(-tops[some])], _FEW
    while some.size:
        X, rest = interval.states_in(some[:size])
        X[:, interval.powers.map.waves] += rest
        zeta = interval.series(X)[1]
        flat = zeta.reshape(-1, zeta.shape[2])
        best = max(best, float(right_ends(flat).max()))
        flat = flat[flat[:, 0] + np.abs(flat[:, 1:]).sum(axis=1) > best]
        if len(flat):
            flat = flat[upper_bounds(flat) > best]
        if len(flat):
            best = max(best, largest_value(flat))
        some, size = some[size:], CHUNK
        some = some[tops[some] > best]
    return best


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
