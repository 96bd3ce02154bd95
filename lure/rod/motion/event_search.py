"""Intervals without events: bounds on ``zeta`` say how far nothing happens; and what the sums of the motion gain."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lure.record import described, quantity
from lure.rod.datasets import Contact
from lure.rod.motion import kernel_series as M
from lure.rod.motion.blocks import PARTS, Block, SeriesBlock, Steps, block_after, series_blocks
from lure.rod.motion.event_free import EventFreeInterval
from lure.rod.motion.exponential_force import ExponentialForce
from lure.rod.motion.kernel_free import LEAST, LOST, MARGIN, MISSED, TOP
from lure.rod.motion.kernel_series import Counts
from lure.rod.motion.kernel_walk import balanced, carried
from lure.rod.motion.pieces import Array, basis, products, supremum
from lure.rod.motion.trip_matrix import Setting, trip_matrix

_SHARES = np.arange(PARTS + 1.0) / PARTS


def searched(f: Array, q: Counts, force: ExponentialForce, most: int) -> EventFreeInterval | None:
    """The interval that begins with the next round trip, by arrays; None if there is none of 16.

    ``f``, ``q``: the motion, which goes on after the interval; as it was if there is none.  ``most``: how many round
    trips there may be.
    """
    number, impact, back, (setting, ends) = (
        int(q[M.TRIP]),
        open_impact(f, q, float(f[M.MOBILITY])),
        _coming_back(f, q),
        _setting(f, q),
    )
    with np.errstate(over="ignore", invalid="ignore"):  # a wave that grows beyond the doubles has no bounds
        found = trip_matrix(setting, back, force, number)
        if found is None:
            return None
        walk = Walk(Steps(found[0]), ends, most)
        walk.go(found[1], (float(f[M.VALUE]), float(f[M.REST])), float(f[M.IMPULSE]) if q[M.OPEN] else 0.0)
    if walk.count < LEAST:
        return None
    _carried(f, q, walk)
    return _interval(f, q, (number, impact), walk.missed, walk.blocks)


def passed_over(f: Array, q: Counts, found: tuple[Array, Counts]) -> EventFreeInterval:
    """The interval that :func:`lure.rod.motion.kernel_walk.free_trips` has just entered."""
    before = int(q[M.SAVED + M.TRIP]), open_impact(f[M.SAVED_F :], q[M.SAVED :], float(f[M.MOBILITY]))
    return _interval(f, q, before, float(found[0][MISSED]), series_blocks(*found, int(q[M.COUNT])))


def _interval(
    f: Array,
    q: Counts,
    before: tuple[int, Contact | None],
    missed: float,
    blocks: Sequence[Block | SeriesBlock],
) -> EventFreeInterval:
    """That which ends where the motion is: from where it began and the impact there, its error and its blocks."""
    return EventFreeInterval(
        number=before[0],
        count=int(q[M.TRIP]) - before[0],
        index=int(q[M.SEGMENT]),
        impact=before[1],
        mobility=float(f[M.MOBILITY]),
        error=missed,
        setting=_setting(f, q)[0],
        blocks=blocks,
    )


def open_impact(f: Array, q: Counts, mobility: float) -> Contact | None:
    """The contact that goes on, of the state that begins there."""
    if not q[M.OPEN]:
        return None
    start, end, impulse, peak = f[M.SINCE : M.PEAK + 1].tolist()
    return Contact(start=start, end=end, impulse=impulse, peak_stress=peak / mobility, closed=False)


def _coming_back(f: Array, q: Counts) -> Array:
    """The coefficients (P, degree+1) of the wave that comes back."""
    width, at = int(q[M.DEGREE]) + 1 + M.COEF, int(q[M.OLD])
    pieces = f[at : at + width * int(q[M.COUNT])].reshape(-1, width)[:, M.COEF :]
    degrees = q[q[M.OLD_DEGREES] : q[M.OLD_DEGREES] + q[M.COUNT]]
    return np.where(_places(width - M.COEF) <= degrees[:, None], pieces, 0.0)


@lru_cache(maxsize=4)
def _places(size: int) -> Counts:
    return np.arange(size)


def _setting(f: Array, q: Counts) -> tuple[Setting, tuple[float, float]]:
    """What does not change from here on; bounds on ``zeta``."""
    width, at = int(q[M.DEGREE]) + 1 + M.COEF, int(q[M.OLD])
    pieces = f[at : at + width * int(q[M.COUNT])].reshape(-1, width)
    edges = np.empty(len(pieces) + 1)
    edges[:-1], edges[-1] = pieces[:, M.START], pieces[-1, M.STOP]
    place = int(q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT])
    segment = f[place : place + M.SEGMENT_SIZE].tolist()
    transit, share, echo, _, area, mobility = f[M.TRANSIT : M.MOBILITY + 1].tolist()
    setting = Setting(
        edges=edges,
        halves=0.5 * transit * (edges[1:] - edges[:-1]),
        origin=segment[M.ORIGIN],
        push=segment[M.STRESS],
        rate=segment[M.RATE],
        transit=transit,
        share=share,
        echo=echo,
        loading=area / mobility if segment[M.TOUCHING] > 0.0 else 0.0,
        degree=width - M.COEF - 1,
    )
    return setting, (segment[M.LOW] - segment[M.ORIGIN], segment[M.HIGH] - segment[M.ORIGIN])


@described(frozen=True, kw_only=True, eq=False, slots=True)
class Span:
    """Bounds over parts of a block: round trips ``first[i], ..., last[i]``."""

    block: Block = quantity("The block")
    table: Array = quantity("What is watched in it")
    others: Array = quantity("(P,) bounds on the coefficients of ``W`` beyond the first")
    first: Array = quantity("(m,) first round trips, counted from that of the block")
    last: Array = quantity("(m,) last round trips")
    reach: Array = quantity("(m, 2) bounds on ``-zeta`` and ``zeta``")
    tops: Array = quantity("(m,) the largest ``zeta`` at an edge in round trip ``first[i]``")


class Walk:
    """Block after block, as far as nothing happens.

    Attributes
    ----------
    count : int
        Round trips so far.
    blocks : list of Block
        Their states.
    missed : float
        Local error of a round trip [m].
    largest, size : float
        Bounds on ``W`` [m/s] and on ``zeta`` [m].
    last, end : ndarray, tuple
        The state in the last round trip; that after it, and ``zeta`` there.
    """

    def __init__(self, steps: Steps, ends: tuple[float, float], most: int) -> None:
        self.steps, self._most = steps, most
        self.blocks: list[Block] = []
        self.count, self.missed, self.largest, self.size = 0, 0.0, 0.0, 0.0
        self.last: Array = np.empty(0)
        self.end: tuple[Array, tuple[float, float]] = self.last, (0.0, 0.0)
        self._spans: list[Span] = []
        trip, setting = steps.trip, steps.trip.setting
        P = len(trip.wave)
        watched = np.empty((2 * P + 1, len(trip.step)))
        watched[: P + 1] = trip.begins
        watched[P + 1 :] = setting.share * trip.wave[:, 0] - setting.rate * trip.begins[:-1]
        watched[P + 1 :, -1] -= setting.push
        self._watched, self._widths, self._limits = watched.T, 2.0 * setting.halves, np.array([-ends[0], ends[1]])
        size = np.abs(trip.wave)
        # of the wave: all coefficients on each piece, those beyond the first, and the last, which a segment with a
        # slope makes of those before
        beyond = np.add.reduce(size[:, 1:], axis=1)
        self._sums = np.concatenate((size[:, 0] + beyond, setting.share * beyond, size[:, -1]))
        if setting.rate == 0.0:
            self._sums[2 * P :] = 0.0

    def go(self, state: Array, level: tuple[float, float], impulse: float) -> None:
        """Enter the blocks from a state on, whose ``zeta`` and impulse are these."""
        zeta = self.steps.trip.zeta
        state[zeta + 1], closed = impulse, False
        while self.count < self._most and not closed:
            state[zeta] = level[0] + level[1]
            block = block_after(self.steps, self.blocks[-1] if self.blocks else None, state, level)
            if block is None:
                break
            block.count = min(block.count, self._most - self.count)
            closed = self._shortened(block)
            if not block.count:
                break
            self.blocks.append(block)
            self.count += block.count
            states, levels = block.states(np.array([block.count - 1.0, block.count]))
            self.last, state, level = states[0], states[1], (float(levels[1, 0]), float(levels[1, 1]))
            self.end = state, level

    def _shortened(self, block: Block) -> bool:
        """Shorten the block to round trips that are certainly free of events; whether one that is not may follow."""
        setting = self.steps.trip.setting
        states, P = block.table(), len(setting.halves)
        while True:
            sums = self._sums @ block.sizes(states)
            wave, top = float(np.maximum.reduce(sums[:P])), float(np.maximum.reduce(sums[2 * P :]))
            if top <= TOP * wave:
                break
            if block.rows is None or block.count < LEAST:
                block.count = 0
                return True
            block.count //= 2
        table = states @ self._watched
        bounds = sums[P : 2 * P], block.bends(table)
        clear, (n, values), finest = block.count, block.grid(table), math.inf
        while True:
            span = self._bounds(block, table, (n, values), bounds)
            tight = self._tight(span.reach)
            fine = None if finest == math.inf else span.last - span.first <= finest
            if fine is not None:
                tight &= fine
            if not tight.any():
                self._enter(span, fine)
                break
            self._enter(span, ~tight if fine is None else ~tight & fine)
            first, last = span.first[tight][:PARTS], span.last[tight][:PARTS]
            if tight.sum() > PARTS:
                clear = min(clear, int(last[-1]))
            shut = first[last - first <= 1.0]
            if len(shut):
                clear = min(clear, int(shut[0]))
            wide = (last - first > 1.0) & (first < clear)
            if not wide.any():
                break
            finest = math.ceil(float((last - first)[wide].max()) / PARTS)
            n = np.unique(np.round(first[wide] + np.multiply.outer(_SHARES, (last - first)[wide])))
            values = block.at(n, table)
        self.missed = max(self.missed, 2.0 * setting.transit * (LOST * wave + top))
        self.largest = max(self.largest, wave)
        closed = clear < block.count
        block.count = clear
        return closed

    def _tight(self, reach: Array) -> NDArray[np.bool_]:
        """Where ``zeta`` is not certainly off its ends; what is no number is not."""
        room = np.minimum.reduce(self._limits - reach, axis=1)
        size = np.maximum.reduce(reach, axis=1)
        return np.asarray(~(room > MARGIN * (size + np.add.reduce(reach, axis=1))))

    def _enter(self, span: Span, open_: NDArray[np.bool_] | None) -> None:
        """Parts in which nothing happens; None for all."""
        if open_ is not None:
            if not open_.any():
                return
            span = replace(span, **{name: getattr(span, name)[open_] for name in ("first", "last", "reach", "tops")})
        self.size = max(self.size, float(span.reach.max()))
        if self.steps.trip.setting.loading:
            self._spans.append(span)

    def _bounds(self, block: Block, table: Array, values: tuple[Array, Array], bounds: tuple[Array, Array]) -> Span:
        """Where the slope keeps its sign on a piece its ends are the bounds; straight lines between, and what bends."""
        (n, value), (others, bends), P = values, bounds, len(bounds[0])
        both = np.empty((len(n), 2, value.shape[1]))  # of -zeta and zeta
        np.negative(value, out=both[:, 0])
        both[:, 1] = value
        step = n[1:] - n[:-1]
        most = np.maximum(both[:-1], both[1:])
        if block.rows is not None:  # at whole numbers, so that nothing bends between neighbours
            most += np.multiply.outer(0.5 * np.floor(0.25 * step * step), bends)[:, None, :]
        swing = self._swing(most[:, 0, P + 1 :], most[:, 1, P + 1 :], others)
        reach = np.maximum(most[:, :, :P], most[:, :, 1 : P + 1])
        reach += swing[:, None, :]
        return Span(
            block=block,
            table=table,
            others=others,
            first=n[:-1],
            last=n[1:],
            reach=np.maximum.reduce(reach, axis=2),
            tops=np.maximum.reduce(value[:-1, : P + 1], axis=1),
        )

    def _swing(self, fall: Array, rise: Array, others: Array) -> Array:
        """How far ``zeta`` may leave its ends on a piece, from bounds on its slope: not where that keeps its sign."""
        swing = np.maximum(fall, rise)
        swing += others
        swing *= self._widths
        swing *= np.minimum(fall, rise) + (self.steps.trip.setting.rate * swing + others) > 0.0
        return swing

    def passing(self) -> tuple[float, float]:
        """Largest ``int W^2 dt`` [m^2/s] and ``|int (z' - W + d p) dt|`` [m] of round trips with which blocks begin."""
        trip, setting = self.steps.trip, self.steps.trip.setting
        states = np.array([block.state for block in self.blocks]).T
        wave, off = trip.wave @ states, trip.series @ states  # (P, k, blocks)
        square = setting.halves @ ((products(wave.shape[1]) @ wave) * wave).sum(axis=1)
        slope = basis(off.shape[1] - 1).derivative @ off
        off *= setting.rate
        off[:, : wave.shape[1]] -= setting.share * wave
        off[:, 0] += setting.push
        off *= setting.halves[:, None, None]
        off += slope
        return float(square.max()), 2.0 * float(np.abs(off).sum(axis=(0, 1)).max())

    def peak(self) -> float:
        """The largest ``zeta``."""
        best = max(float(span.tops[span.first < span.block.count].max(initial=-math.inf)) for span in self._spans)
        if self.steps.trip.setting.rate == 0.0:
            return best
        for span in self._spans:
            some = (span.reach[:, 1] > best).nonzero()[0]
            if not len(some):
                continue
            n = np.concatenate([np.arange(span.first[i], span.last[i]) for i in some])
            n = n[n < span.block.count]
            values, P = span.block.at(n, span.table), len(span.others)
            best = max(best, float(values[:, : P + 1].max(initial=-math.inf)))
            slopes = values[:, P + 1 :]
            most = np.maximum(values[:, :P], values[:, 1 : P + 1]) + self._swing(-slopes, slopes, span.others)
            near = n[most.max(axis=1) > best]
            if len(near):
                states = span.block.at(near, span.block.table())
                series = np.einsum("pkn,in->ipk", self.steps.trip.series, states)
                best = max(best, supremum(series.reshape(-1, series.shape[2]))[0])
        return best


def _carried(f: Array, q: Counts, walk: Walk) -> None:
    """Put the motion after the interval in the place of that before it, and enter what it adds to the sums."""
    trip, count, setting = walk.steps.trip, walk.count, walk.steps.trip.setting
    (state, level), (square, residual) = walk.end, walk.passing()
    balanced(f, q, level, (square, count * residual * (abs(setting.push) + setting.rate * walk.size)))
    back, width, at = trip.returned(walk.last), int(q[M.DEGREE]) + 1 + M.COEF, int(q[M.OLD])
    pieces, sizes = f[at : at + width * len(back)].reshape(-1, width), np.abs(back).sum(axis=1)
    pieces[:, M.SIZE], pieces[:, M.COEF : M.COEF + back.shape[1]] = sizes, back
    q[q[M.OLD_DEGREES] : q[M.OLD_DEGREES] + len(back)] = back.shape[1] - 1
    top = walk.peak() if setting.loading > 0.0 else 0.0
    carried(f, q, count, level, (float(sizes.max()), walk.largest, walk.missed, float(state[trip.zeta + 1]), top))
