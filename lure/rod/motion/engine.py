"""The engine: how the round trips of the kernel become records, compiled or as they stand."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lure.errors import AssumptionError, InputError
from lure.rod.motion.compilation import LOAD, compilation_pays, compiled_kernel, kernel_of, ready
from lure.rod.motion.event_free import EventFreeInterval
from lure.rod.motion.event_search import Finder
from lure.rod.motion.kernel_piece import MOST_POWERED
from lure.rod.motion.kernel_series import (
    BLOCK,
    COEF,
    COUNT,
    CROSSINGS,
    DEGREE,
    ENDINGS,
    ENDS,
    ENERGY,
    ERROR,
    HIGH,
    HIGHEST,
    IMPACT,
    IMPACTS,
    LARGEST,
    LATER,
    LAW,
    LOW,
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
    PIECES,
    POWER,
    RATE,
    REST,
    SCALE,
    SEGMENT,
    SEGMENT_SIZE,
    SEGMENTS,
    SINCE,
    STATE,
    STOP,
    STORED,
    TRANSIT,
    TRANSITS,
    TRIP,
    VALUE,
    WAVE,
    WINDOWS,
    WORST,
    Counts,
    Room,
    memory,
)
from lure.rod.motion.kernel_trip import (
    CHATTER,
    DONE,
    FULL,
    HUGE,
    LARGEST_WAVE,
    MANY,
    NEAR,
    STIFF,
    run,
    run_powers,
    stored,
)
from lure.rod.motion.kernel_walk import free_trips
from lure.rod.motion.pieces import NOISE, Array, Pieces, largest
from lure.rod.motion.record import Level, Record, State
from lure.rod.motion.sources import NO_LOAD, Load, Panels, Problem, block_count
from lure.rod.sampled import Contact

_WINDOWS, _PIECES = 4096, 8192  # room in the record of compiled code,
_FEW_WINDOWS, _FEW_PIECES = 64, 512  # and of code as it stands, which is asked for windows one by one
_PANELS = 20_000
_MOST_BLOCKS, _LEAST_BLOCKS = 1024, 8
_MOST_PACE = 1024
_PIECE, _POWERED = 1e-4, 1e-3  # [s] without compilation, with a power law
LEAST_ENERGY = 1e-290  # [J]: below, doubles lose digits


class Engine:
    """One motion.

    Attributes
    ----------
    compiled : bool
        Whether the kernel is compiled by now.
    f, q : ndarray
        Its memory, see :mod:`lure.rod.motion.kernel_series`; the sums in it hold for what has been done so far.
    """

    def __init__(self, problem: Problem, *, wish: bool | None, stretches: bool = True) -> None:
        self._problem, self._wish, self._spent = problem, wish, 0.0
        self.compiled = compiled = compilation_pays(problem, wish)
        self._finder = Finder(problem, ready(free_trips, wish) if compiled else None) if stretches else None
        self._asked, self._load, self._most_blocks = range(0), NO_LOAD, 1
        self._given: tuple[Load | None, Any] = None, None
        wave, error = problem.sources.initial_wave()
        room = Room(
            degree=problem.sources.degree,
            segments=len(problem.nonlinearity.segments),
            pieces=max(64, 2 * len(wave.series)),
            windows=_WINDOWS if compiled else _FEW_WINDOWS,
            recorded=_PIECES if compiled else _FEW_PIECES,
        )
        self._remember(room)
        self._begin(wave, error)
        self._panels = Panels(sources=problem.sources, transits=problem.transits, scale=largest(wave.series))

    def _remember(self, room: Room) -> None:
        """Make the memory; what stands in ``array`` is read and written faster by the kernel as it stands."""
        self._room = room
        self.f, self.q = memory(room)
        self._memory: tuple[Any, Any] = self.f, self.q
        if not self.compiled:
            self._memory = array("d", self.f.tobytes()), array("q", self.q.tobytes())
            self.f, self.q = np.frombuffer(self._memory[0]), np.frombuffer(self._memory[1], dtype=np.int64)

    def _kernel(self, load: Load, stop: int) -> int:
        """Go on to a round trip: see :func:`lure.rod.motion.kernel_trip.run`."""
        if self.compiled:
            return int(compiled_kernel(kernel_of(self._problem))(self.f, self.q, load, stop))
        if load is not self._given[0]:
            self._given = load, (load[0].tolist(), load[1].tolist())
        with np.errstate(all="ignore"):  # as in compiled code
            return run_powers(*self._memory, self._given[1], stop)

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
        nonlinearity = [
            (s.low, s.high, s.origin, s.push, s.rate, s.power, float(s.touching)) for s in problem.nonlinearity.segments
        ]
        f[q[LAW] : q[LAW] + SEGMENT_SIZE * len(nonlinearity)] = np.ravel(nonlinearity)
        q[SEGMENT], q[COUNT], q[MERGED] = first.segment, len(wave.series), 8
        f[VALUE], f[REST], f[LATER] = first.zeta.value, first.zeta.rest, error
        f[STORED] = stored(f, q, nonlinearity[first.segment][ORIGIN] + first.zeta.value)
        seen = np.abs(wave.series) > NOISE * largest(wave.series)
        degree = np.where(seen.any(axis=1), self._room.degree - seen[:, ::-1].argmax(axis=1), 0)
        sizes = np.abs(wave.series).sum(axis=1)
        pieces = np.column_stack((wave.edges[:-1], wave.edges[1:], sizes, wave.series))
        f[q[OLD] : q[OLD] + pieces.size] = pieces.ravel()
        q[q[OLD_DEGREES] : q[OLD_DEGREES] + len(degree)] = degree

    def records(self) -> Iterator[Record | EventFreeInterval]:
        """The round trips, many at a time.

        Raises
        ------
        InputError
            A wave or a load is not finite or too large, or a load needs too many panels.
        AssumptionError
            Contact and flight alternate more than 4000 times in a round trip, or cannot be told apart.
        """
        total = math.ceil(self._problem.transits / 2.0)
        finder, pace = self._finder, 1
        if finder is None or not finder.loads.known:
            finder, pace = None, total
        while (trip := int(self.q[TRIP])) < total:
            if finder is not None and trip > 0:
                pace, found = min(2 * pace, _MOST_PACE), None
                if clear(self.f, self.q):
                    found = finder.after(self.f, self.q, self.open_impact)
                if found is not None:
                    pace = 2
                    yield found
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
            known = self._finder and self._finder.loads.panels(block, count, self._room.degree)
            self._load = known or self._panels.over(block, count)
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
            status = self._kernel(load, min(stop, reach))
            if not self.compiled and self._wish is None:
                self._reconsider()
            if self.q[WINDOWS]:
                yield self._record(number)
            elif status == FULL:
                self._enlarge()
            if status not in (DONE, FULL):
                raise self._refusal(status)

    def _reconsider(self) -> None:
        """Compile from here on if that is likely to take less time than it saves."""
        self._spent += int(self.q[PIECES]) * (_PIECE if kernel_of(self._problem) is run else _POWERED)
        trip = int(self.q[TRIP])
        if self._spent > LOAD and trip:
            left = self._spent * (0.5 * self._problem.transits / trip - 1.0)
            self.compiled = compilation_pays(self._problem, None, left)

    def _record(self, number: int) -> Record:
        f, q = self.f, self.q
        windows, pieces, numbers, impacts = q[WINDOWS : IMPACTS + 1].tolist()

        def table(source: NDArray[Any], start: int, rows: int, width: int) -> NDArray[Any]:
            """A copy of what is filled."""
            return source[q[start] : q[start] + rows * width].reshape(rows, width).copy()

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
        self._remember(replace(self._room, pieces=pieces, recorded=max(self._room.recorded, 4 * pieces)))
        self.f[:WAVE], self.q[:STATE] = f[:WAVE], q[:STATE]
        for old, new, name, length in (
            (f, self.f, LAW, SEGMENT_SIZE * int(q[SEGMENTS])),
            (f, self.f, OLD, int(q[COUNT]) * (self._room.degree + 1 + COEF)),
            (q, self.q, OLD_DEGREES, int(q[COUNT])),
        ):
            new[self.q[name] : self.q[name] + length] = old[q[name] : q[name] + length]

    def _refusal(self, status: int) -> Exception:
        trip, wave = int(self.q[TRIP]), self._problem.share * float(self.f[LARGEST])
        power = self._problem.nonlinearity.segments[int(self.q[SEGMENT])].power
        if status == HUGE:
            return InputError(
                f"the wave in round trip {trip} is {self.f[SCALE]:.3g} m/s, more than 1e+100; give smaller "
                "data or loads"
            )
        return AssumptionError(
            {
                CHATTER: f"the end passes from contact to flight 4000 times in round trip {trip}, which is chattering; "
                "follow a shorter time",
                NEAR: "the end of the rod keeps within rounding of the obstacle over a long time, so that contact "
                "cannot be told from free flight; change the gap or the data a little",
                STIFF: f"a wave of {wave:.3g} m/s is stopped by the power law m = {power:g} within too short a way for "
                "double precision; give a larger compliance, or a rigid obstacle",
                MANY: f"contact with the power law m = {power:g} needs more than {MOST_POWERED} pieces in a round "
                "trip; give another compliance, stiffer or softer, or m = 1",
            }[status]
        )

    @property
    def open_impact(self) -> Contact | None:
        """The contact that goes on at the end."""
        f = self.f
        if not self.q[OPEN]:
            return None
        start, end, impulse, peak = f[SINCE : PEAK + 1].tolist()
        peak /= float(f[MOBILITY])
        return Contact(start=start, end=end, impulse=impulse, peak_stress=peak, closed=False)

    @property
    def crossings(self) -> int:
        """Passages between segments of the nonlinearity."""
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


def clear(f: Array, q: Counts) -> bool:
    """Whether an interval without events may begin: on a straight segment, with whole round trips, off its ends."""
    nonlinearity = q[LAW] + SEGMENT_SIZE * q[SEGMENT]
    last = q[OLD] + (q[DEGREE] + 1 + COEF) * (q[COUNT] - 1)
    if math.isinf(f[nonlinearity + RATE]) or f[nonlinearity + POWER] != 1.0 or f[last + STOP] != 2.0:
        return False
    z = f[nonlinearity + ORIGIN] + f[VALUE]
    return bool(f[nonlinearity + LOW] < z < f[nonlinearity + HIGH])


def first_state(problem: Problem) -> State:
    """Segment and place of the end at the start.

    Raises
    ------
    InputError
        It begins inside a rigid obstacle.
    """
    rod, segments = problem.sources.rod, problem.nonlinearity.segments
    z = problem.sources.scenario.contact_coordinate(rod)
    if not z < LARGEST_WAVE:
        raise InputError(
            f"initial.u0 and rod.gap put the end at z = {z:.3g} m, beyond {LARGEST_WAVE:g}; give smaller data"
        )
    j = max(next(i for i, segment in enumerate(segments) if z <= segment.high), 0)
    if math.isinf(segments[j].rate):
        raise InputError(
            f"initial.u0 and rod.gap put the end {z:.4g} m inside the obstacle, which is rigid; give a larger gap"
        )
    return State(segment=j, zeta=Level(value=z - segments[j].origin))
