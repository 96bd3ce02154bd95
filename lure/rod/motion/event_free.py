"""How far nothing happens: states block after block, bounds over whole round trips, and what the sums gain by it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lure.rod.motion.event_free_interval import BLOCK, BLOCK_POWER, EventFreeInterval, peak
from lure.rod.motion.event_free_map import Coefficients, EventFreeLoads, Powers, event_free_map, imbalance, passed
from lure.rod.motion.pieces import Array, Pieces
from lure.rod.motion.record import Level, State
from lure.rod.motion.sources import Problem
from lure.rod.sampled import Contact

TOP = 1e-16  # of the wave: what its last coefficients may be
_CHUNK, _LARGE = 64, 100
_MARGIN = 1e-12
_CANCELLED = 4e-16
LEAST = 16
_MOST_STATES = 400
_NOISE = 1e-17


class Walk:
    """States block after block, up to the first round trip that is not certainly free of events."""

    def __init__(self, powers: Powers, number: int) -> None:
        self.powers, self.number = powers, number
        self.states: list[Array] = []
        self.rests: list[Array] = []
        self.tops: list[Array] = []
        self.starts: list[Array] = []
        self._tables()

    def _tables(self) -> None:
        """``zeta`` in each round trip of a block, less that in the first; bounds on what ``zeta`` does in any."""
        powers, q = self.powers, self.powers.map
        w, size = q.waves, powers.states.count + 1
        inside, forced = np.zeros((1, q.size)), np.zeros((1, size))
        series, constant = q.travel, q.steady
        swing, more = np.abs(series).sum(axis=1), np.zeros((q.pieces, size))
        more[:, -1] = np.abs(constant).sum(axis=1)
        for k in range(BLOCK_POWER):
            p = powers[k]
            step = powers.step(p.m)
            # row w of B + D, the identity taken off, then what is inside carried over
            row = np.zeros(q.size)
            row += p.rows[0] if q.segment.rate == 0.0 else p.rows[w]
            later = inside * p.beta + inside[:, p.place] @ p.rows + row
            load = inside @ p.load + forced @ step + p.load[w]
            inside, forced = np.vstack((inside, later)), np.vstack((forced, load))
            more = swing @ np.abs(p.load) + more @ np.maximum(np.abs(step), np.eye(size))
            swing = swing * np.maximum(1.0, np.abs(p.beta)) + swing[:, p.place] @ np.abs(p.rows)
        self._inside, self._forced, self._swing, self._more = inside, forced, swing, more

    def along(self, X: Array, rest: float, most: int) -> int:
        """Number of round trips without events, at most ``most``."""
        q, done = self.powers.map, 0
        w, segment = q.waves, q.segment
        low, high = segment.low - segment.origin, segment.high - segment.origin
        self.ahead, self.ahead_rest = X, rest
        blocks = _CHUNK if q.size < _LARGE else 1
        while done < most:
            n = self.number + done
            blocks = min(blocks * 8, _CHUNK, -(-(most - done) // BLOCK))
            u = self.powers.at(self.powers.number_of(n, blocks))
            states, rests = self._chunk(u)
            swing = (np.abs(states) @ self._swing.T + np.abs(u) @ self._more.T).max(axis=1)
            zeta = states @ self._inside.T + u @ self._forced.T + (states[:, w] + rests)[:, None]
            margin = _MARGIN * (np.abs(zeta).max(axis=1) + swing)
            tops = zeta + (swing + margin)[:, None]
            free = tops < high
            if low > -math.inf:
                free &= zeta - (swing + margin)[:, None] > low
            sizes = np.abs(states[:, :w]).reshape(blocks, q.pieces, -1)
            fine = sizes[:, :, -1].max(axis=1) <= TOP * sizes.sum(axis=2).max(axis=1) if q.degree else True
            if segment.rate > 0.0:
                free &= np.reshape(fine, (-1, 1))
            self.states.append(states)
            self.rests.append(rests)
            self.tops.append(tops.ravel())
            self.starts.append(zeta.ravel())
            loud = np.flatnonzero(~free.ravel())
            if loud.size:
                return min(most, done + int(loud[0]))
            done += BLOCK * blocks
        return most

    def _chunk(self, u: Array) -> tuple[Array, Array]:
        """States (blocks, S) given those of the load; ``ahead`` is the one after them."""
        powers, q, blocks = self.powers, self.powers.map, len(u)
        states, k, filled = np.empty((blocks + 1, q.size)), BLOCK_POWER, 1
        states[0] = self.ahead
        while filled < blocks + 1:
            count = min(filled, blocks + 1 - filled)
            states[filled : filled + count] = powers[k].applied(states[:count], u[:count])
            filled, k = filled + count, k + 1
        rests = np.zeros(blocks + 1)
        if q.segment.rate == 0.0:
            travelled = travel(powers, BLOCK_POWER, states[:-1], u)
            sums = self.ahead_rest + np.concatenate(([0.0], np.cumsum(travelled)))
            start = states[0, q.waves]
            value = start + sums
            back = value - start
            rests = (start - (value - back)) + (sums - back)
            states[:, q.waves] = value
        self.ahead, self.ahead_rest = states[-1], float(rests[-1])
        return states[:-1], rests[:-1]


def travel(powers: Powers, k: int, X: Array, u: Array) -> Array:
    """What ``zeta`` travels in flight over ``2**k`` round trips; ways there and back that differ by rounding cancel."""
    gone, q = powers[k], powers.map
    parts = X[:, : q.waves] * gone.rows[0, : q.waves]
    way = parts.sum(axis=1)
    way[np.abs(way) <= _CANCELLED * np.abs(parts).sum(axis=1)] = 0.0
    return np.asarray(way + u @ gone.load[q.waves])


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class EventFree:
    """An interval without events, and the motion after it.

    Attributes
    ----------
    interval : EventFreeInterval
        The round trips.
    wave : Pieces
        What comes back in the next, without its load.
    state : State
        The end of the rod.
    imbalance : float
        Bound on what the work on the end and what the obstacle stores may differ by [J].
    passed, largest : float
        Largest energy of a round trip [J], largest wave [m/s].
    """

    interval: EventFreeInterval
    wave: Pieces
    state: State
    imbalance: float
    passed: float
    largest: float


class Search:
    """Looks for event-free intervals of one motion; a piece of a round trip costs the kernel ``piece`` [s]."""

    def __init__(self, problem: Problem, piece: float) -> None:
        self._problem, self.loads, self._piece = problem, EventFreeLoads(problem.sources), piece
        rod = problem.sources.rod
        self._numbers = Coefficients(
            transit=rod.travel_time,
            share=problem.share,
            echo=problem.sources.echo,
            area=rod.area,
            mobility=rod.mobility * problem.share,
            impedance=rod.impedance,
        )
        self._total = math.floor(0.5 * problem.transits)

    @property
    def hopeful(self) -> bool:
        """Whether there may be any."""
        return self.loads.known

    def worth(self, state: State, pieces: int, degree: int) -> int:
        """Round trips of the kernel that cost as much as a search."""
        size = pieces * (degree + 2) + 1
        contact = self._problem.nonlinearity.segments[state.segment].rate > 0.0
        return int((6e-4 + (6e-10 * size**3 + 6e-4 if contact else 0.0)) / (self._piece * (pieces + 1)))

    def after(self, number: int, wave: Pieces, state: State) -> EventFree | None:
        """The interval that begins with a round trip, given what comes back in it; None if there is none of 16."""
        segment = self._problem.nonlinearity.segments[state.segment]
        sizes = np.abs(wave.series).sum(axis=1)
        states, end = self.loads.over(number)
        most = min(self._total, math.floor(0.5 * end) if end < math.inf else self._total) - number
        if states is None or most < LEAST:
            return None
        series = states.series(wave.edges)
        if series is None:
            return None
        degree, flat = max(_seen(wave.series, sizes), series.shape[1] - 1), segment.rate == 0.0
        if not flat:
            now = np.abs(series @ states.at(np.array([float(number)]))[0])
            degree = max(_seen(wave.series, sizes, TOP), _seen(now, sizes, TOP)) + 1
        if degree >= wave.series.shape[1] or (not flat and len(sizes) * (degree + 1) > _MOST_STATES):
            return None
        found = event_free_map(segment, wave.edges, degree, self._numbers)
        if found is None:
            return None
        padded = np.pad(series[:, : degree + 1], ((0, 0), (0, max(degree + 1 - series.shape[1], 0)), (0, 0)))
        powers = Powers(map=found, numbers=self._numbers, states=states, series=padded)
        with np.errstate(over="ignore", invalid="ignore"):  # a load that grows beyond all numbers ends the interval
            return self._followed(powers, number, most, wave, state)

    def _followed(self, powers: Powers, number: int, most: int, wave: Pieces, state: State) -> EventFree | None:
        q = powers.map
        X = np.zeros(q.size)
        X[: q.waves] = (
            wave.series[:, : q.degree + 1].ravel()
            + powers.series.reshape(q.waves, -1) @ (powers.at(np.array([float(number)]))[0, :-1])
        )
        X[q.waves] = state.zeta.value
        if q.segment.touching:
            X[q.waves + 1] = state.impact.impulse if state.impact is not None else 0.0
        walk = Walk(powers=powers, number=number)
        count = walk.along(X, state.zeta.rest, most)
        if count < LEAST:
            return None
        return self._summed(walk, count, wave, state)

    def _summed(self, walk: Walk, count: int, wave: Pieces, state: State) -> EventFree:
        powers, number, T = walk.powers, walk.number, self._numbers.transit
        q = powers.map
        blocks = -(-count // BLOCK)
        states, rests = np.concatenate(walk.states)[:blocks], np.concatenate(walk.rests)[:blocks]
        sizes = np.abs(states[:, : q.waves]).reshape(blocks, q.pieces, -1)
        top = float(sizes[:, :, -1].max()) if q.segment.rate > 0.0 else 0.0
        loads = float(np.abs(powers.series).sum(axis=1).max(initial=0.0))
        error = 2.0 * T * (top + _NOISE * loads)
        interval = EventFreeInterval(
            powers=powers,
            number=number,
            count=count,
            share=self._problem.share,
            width=wave.series.shape[1],
            index=state.segment,
            states=states,
            rests=rests,
            error=error,
            impact=state.impact,
        )
        last, rest = self._ended(walk, count)
        end = Pieces(wave.edges, np.zeros_like(wave.series))
        load = powers.series.reshape(q.waves, -1) @ powers.at(np.array([float(number + count)]))[0, :-1]
        end.series[:, : q.degree + 1] = (last[: q.waves] - load).reshape(q.pieces, -1)
        impact = None
        if q.segment.touching:
            before = state.impact
            tops, starts = (np.concatenate(parts)[:count] for parts in (walk.tops, walk.starts))
            highest = peak(interval, tops, float(starts.max())) if q.segment.rate > 0.0 else 0.0
            highest = (q.segment.push + q.segment.rate * highest) / self._numbers.mobility
            impact = Contact(
                start=2.0 * T * number if before is None else before.start,
                end=T * 2.0 * (number + count),
                impulse=float(last[q.waves + 1]),
                peak_stress=highest if before is None else max(before.peak_stress, highest),
                closed=False,
            )
        largest, segment = float(sizes.sum(axis=2).max()), q.segment
        reach = float(np.abs(states[:, q.waves]).max()) + 2.0 * T * self._numbers.share * largest
        push = abs(segment.push) + segment.rate * reach
        off = push and push * count * self._numbers.area / self._numbers.mobility * imbalance(powers, states)
        return EventFree(
            interval=interval,
            wave=end,
            state=State(segment=state.segment, zeta=Level(value=float(last[q.waves]), rest=rest), impact=impact),
            imbalance=off,
            passed=float(passed(powers, states).max()),
            largest=largest,
        )

    def _ended(self, walk: Walk, count: int) -> tuple[Array, float]:
        """The state after the interval, and what rounding lost of ``zeta``."""
        powers, blocks = walk.powers, count // BLOCK
        q = powers.map
        states, rests = np.concatenate(walk.states), np.concatenate(walk.rests)
        if count == BLOCK * len(states):
            return walk.ahead, walk.ahead_rest
        X, rest, n = states[blocks], float(rests[blocks]), walk.number + BLOCK * blocks
        start = X[q.waves]
        for k in range(BLOCK_POWER - 1, -1, -1):
            if count >> k & 1:
                u = powers.at(np.array([float(n)]))
                travelled = float(travel(powers, k, X[None], u)[0]) if q.segment.rate == 0.0 else 0.0
                X = powers[k].applied(X[None], u)[0]
                if q.segment.rate == 0.0:
                    X[q.waves], rest = _plus(start, travelled + rest)
                    start = X[q.waves]
                n += 1 << k
        return X, rest


def _seen(series: Array, sizes: Array, share: float = _NOISE) -> int:
    """The highest degree of which a coefficient is not below a share of the largest wave."""
    seen = np.flatnonzero(np.abs(series).max(axis=0) > share * float(sizes.max()))
    return int(seen[-1]) if seen.size else 0


def _plus(value: float, travel: float) -> tuple[float, float]:
    """The sum, and what rounding lost of it."""
    level = Level(value=value).plus(travel)
    return level.value, level.rest
