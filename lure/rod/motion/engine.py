"""The compiled engine: how its round trips become records."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lure.errors import AssumptionError, InputError
from lure.rod.motion.chebyshev import largest
from lure.rod.motion.engine_skip import at_hand, skipped
from lure.rod.motion.impacts import Impact
from lure.rod.motion.jit import plain
from lure.rod.motion.kernel_data import (
    BLOCK,
    COEF,
    COUNT,
    CROSSINGS,
    ENDINGS,
    ENDS,
    ENERGY,
    ERROR,
    HIGHEST,
    IMPACT,
    IMPACTS,
    LATER,
    LAW,
    MARKS,
    MERGED,
    MOBILITY,
    OLD,
    OLD_DEGREES,
    OPEN,
    ORIGIN,
    OUT_ENDINGS,
    OUT_ENDS,
    OUT_IMPACTS,
    OUT_MARKS,
    OUT_NUMBERS,
    OUT_PIECES,
    PEAK,
    PIECE,
    REST,
    SCALE,
    SEGMENT,
    SEGMENT_SIZE,
    SEGMENTS,
    SINCE,
    STATE,
    STORED,
    TRANSIT,
    TRANSITS,
    TRIP,
    VALUE,
    WAVE,
    WINDOWS,
    WORST,
    Room,
    memory,
)
from lure.rod.motion.kernel_entry import stored
from lure.rod.motion.kernel_window import CHATTER, DONE, FULL, NEAR, run
from lure.rod.motion.ledger import LEAST_ENERGY
from lure.rod.motion.panels import NO_LOAD, Load, Panels, block_count
from lure.rod.motion.pieces import Pieces
from lure.rod.motion.quiet import Search
from lure.rod.motion.record import Record
from lure.rod.motion.stretch import Stretch
from lure.rod.motion.windows import Problem, first_state

_WINDOWS, _PIECES = 4096, 8192
_PANELS = 20_000
_MOST_BLOCKS, _LEAST_BLOCKS = 1024, 8
_MOST_PACE = 1024
_NOISE = 4e-16  # of the initial wave: what its fit leaves of coefficients that are zero


class Engine:
    """One motion by compiled code.

    Attributes
    ----------
    f, q : ndarray
        Its memory, see :mod:`lure.rod.motion.kernel_data`; the sums in it hold for what has been done so far.
    """

    def __init__(self, problem: Problem, *, stretches: bool = True) -> None:
        self._problem = problem
        self._search = Search(problem) if stretches else None
        self._asked, self._load, self._most_blocks = range(0), NO_LOAD, 1
        wave, error = problem.sources.initial_wave()
        room = Room(
            degree=problem.sources.degree,
            segments=len(problem.law.segments),
            pieces=max(64, 2 * len(wave.series)),
            windows=_WINDOWS,
            recorded=_PIECES,
        )
        self._room = room
        self.f, self.q = memory(room)
        self._begin(wave, error)
        self._panels = Panels(sources=problem.sources, transits=problem.transits, scale=largest(wave.series))

    def _begin(self, wave: Pieces, error: float) -> None:
        f, q, problem = self.f, self.q, self._problem
        rod, first = problem.sources.rod, first_state(problem)
        f[TRANSIT : TRANSITS + 1] = (
            rod.travel_time,
            problem.share,
            problem.sources.echo,
            rod.impedance,
            rod.area,
            rod.mobility * problem.share,
            problem.transits,
        )
        law = [(s.low, s.high, s.origin, s.push, s.rate, float(s.touching)) for s in problem.law.segments]
        f[q[LAW] : q[LAW] + SEGMENT_SIZE * len(law)] = np.ravel(law)
        q[SEGMENT], q[COUNT], q[MERGED] = first.segment, len(wave.series), 8
        f[VALUE], f[REST], f[LATER] = first.zeta.value, first.zeta.rest, error
        f[STORED] = plain(stored)(f, q, law[first.segment][ORIGIN] + first.zeta.value)
        seen = np.abs(wave.series) > _NOISE * largest(wave.series)
        degree = np.where(seen.any(axis=1), self._room.degree - seen[:, ::-1].argmax(axis=1), 0)
        sizes = np.abs(wave.series).sum(axis=1)
        pieces = np.column_stack((wave.edges[:-1], wave.edges[1:], sizes, wave.series))
        f[q[OLD] : q[OLD] + pieces.size] = pieces.ravel()
        q[q[OLD_DEGREES] : q[OLD_DEGREES] + len(degree)] = degree

    def records(self) -> Iterator[Record | Stretch]:
        """The round trips, many at a time.

        Raises
        ------
        InputError
            A wave or a load is not finite or too large, or a load needs too many panels.
        AssumptionError
            Contact and flight alternate more than 4000 times in a round trip, or cannot be told apart.
        """
        total = math.ceil(self._problem.transits / 2.0)
        search, pace = self._search, 1
        if search is None or not search.hopeful:
            search, pace = None, total
        while (trip := int(self.q[TRIP])) < total:
            if search is not None and trip > 0:
                wave, state = at_hand(self.f, self.q, self.open_impact)
                found = search.after(trip, wave, state)
                pace = min(2 * pace, _MOST_PACE)
                if found is not None:
                    if len(found.stretch) > search.worth(state, len(wave.series), found.stretch.powers.quiet.degree):
                        pace = 2
                    skipped(self.f, self.q, self._problem, found)
                    yield found.stretch
                    continue
            yield from self._until(min(trip + pace, total))

    def _loads(self, trip: int, stop: int) -> Load:
        """The panels from a round trip on."""
        if self._problem.sources.scenario.free:
            return NO_LOAD
        block = trip // BLOCK
        if block not in self._asked:
            # as many as are needed; at first few, until it is known how many panels each takes
            count = min(max(-(-stop // BLOCK), block + _LEAST_BLOCKS), block_count(self._problem.transits)) - block
            count = min(count, self._most_blocks)
            self._load = self._panels.over(block, count)
            self._asked = range(block, block + count)
            many = max(1, (len(self._load[1]) - count - 2) // count)
            self._most_blocks = max(1, min(_MOST_BLOCKS, _PANELS // many))
        return self._load

    def _until(self, stop: int) -> Iterator[Record]:
        while self.q[TRIP] < stop:
            number = int(self.q[TRIP])
            load = self._loads(number, stop)
            reach = BLOCK * self._asked.stop if len(load[1]) else stop
            self.q[WINDOWS : IMPACTS + 1] = 0
            status = run(self.f, self.q, *load, min(stop, reach))
            if self.q[WINDOWS]:
                yield self._record(number)
            elif status == FULL:
                self._enlarge()
            if status not in (DONE, FULL):
                raise _refusal(status, int(self.q[TRIP]), float(self.f[SCALE]))

    def _record(self, number: int) -> Record:
        f, q = self.f, self.q
        windows, pieces, numbers, impacts = q[WINDOWS : IMPACTS + 1].tolist()

        def table(array: NDArray[Any], start: int, rows: int, width: int) -> NDArray[Any]:
            """A copy of what is filled."""
            return array[q[start] : q[start] + rows * width].reshape(rows, width).copy()

        heads, marks = table(q, OUT_PIECES, pieces, PIECE), table(q, OUT_MARKS, windows, MARKS)
        ends = table(f, OUT_ENDS, pieces, ENDS)
        return Record(
            number=number,
            share=self._problem.share,
            width=self._room.degree + 1,
            first=np.append(marks[:, 4], pieces),
            low=ends[:, 0],
            high=ends[:, 1],
            start=heads[:, 0],
            degree=heads[:, 1:],
            coef=table(f, OUT_NUMBERS, numbers, 1)[:, 0],
            endings=table(f, OUT_ENDINGS, windows, ENDINGS),
            marks=marks[:, :4],
            impacts=table(f, OUT_IMPACTS, impacts, IMPACT),
        )

    def _enlarge(self) -> None:
        """Twice the room, for a round trip of very many pieces."""
        f, q = self.f, self.q
        pieces = 2 * self._room.pieces
        self._room = replace(self._room, pieces=pieces, recorded=max(self._room.recorded, 4 * pieces))
        self.f, self.q = memory(self._room)
        self.f[:WAVE], self.q[:STATE] = f[:WAVE], q[:STATE]
        for old, new, name, length in (
            (f, self.f, LAW, SEGMENT_SIZE * int(q[SEGMENTS])),
            (f, self.f, OLD, int(q[COUNT]) * (self._room.degree + 1 + COEF)),
            (q, self.q, OLD_DEGREES, int(q[COUNT])),
        ):
            new[self.q[name] : self.q[name] + length] = old[q[name] : q[name] + length]

    @property
    def open_impact(self) -> Impact | None:
        """The contact that goes on at the end."""
        f = self.f
        if not self.q[OPEN]:
            return None
        start, end, impulse, peak = f[SINCE : PEAK + 1].tolist()
        peak /= float(f[MOBILITY])
        return Impact(start=start, end=end, impulse=impulse, peak_stress=peak, closed=False)

    @property
    def crossings(self) -> int:
        """Passages between segments of the law."""
        return int(self.q[CROSSINGS])

    @property
    def error(self) -> float:
        """Sum of the estimates of the local errors [m]."""
        return float(self.f[ERROR])

    @property
    def largest_wave(self) -> float:
        """[m/s]."""
        return float(self.f[HIGHEST])

    @property
    def energy_residual(self) -> float:
        """Largest imbalance, relative to the largest energy of a round trip."""
        return float(self.f[WORST] / max(self.f[ENERGY], LEAST_ENERGY))


def _refusal(status: int, trip: int, scale: float) -> Exception:
    if status == CHATTER:
        return AssumptionError(
            f"the end passes from contact to flight 4000 times in round trip {trip}, which is chattering; "
            "follow a shorter time"
        )
    if status == NEAR:
        return AssumptionError(
            "the end of the rod keeps within rounding of the obstacle over a long time, so that contact cannot be "
            "told from free flight; change the gap or the data a little"
        )
    return InputError(f"the wave in round trip {trip} is {scale:.3g} m/s, more than 1e+100; give smaller data or loads")
