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
from lure.rod.motion import kernel_series as M
from lure.rod.motion.compilation import LOAD, compilation_pays, compiled_kernel, kernel_of
from lure.rod.motion.event_free import EventFreeInterval
from lure.rod.motion.event_search import passed_over, searched
from lure.rod.motion.exponential_force import MOST_COLUMNS, ExponentialForces
from lure.rod.motion.kernel_free import MOST, MOST_FREE, layout
from lure.rod.motion.kernel_piece import MOST_POWERED
from lure.rod.motion.kernel_run import FORCE, FREE, LOADS, SEARCH, run, run_powers
from lure.rod.motion.kernel_series import Room, memory
from lure.rod.motion.kernel_trip import CHATTER, DONE, FULL, HUGE, LARGEST_WAVE, MANY, NEAR, STIFF, stored
from lure.rod.motion.pieces import NOISE, Pieces, largest
from lure.rod.motion.record import Level, Record, State
from lure.rod.motion.sources import NO_LOAD, Panels, Problem, load_of_a_block

_WINDOWS, _PIECES = 4096, 8192  # room in the record of compiled code,
_FEW_WINDOWS, _FEW_PIECES = 64, 512  # and of code as it stands, which is asked for windows one by one
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
        wave, error = problem.sources.initial_wave()
        room = Room(
            degree=problem.sources.degree,
            segments=len(problem.nonlinearity.segments),
            pieces=max(64, 2 * len(wave.series)),
            windows=_WINDOWS if compiled else _FEW_WINDOWS,
            recorded=_PIECES if compiled else _FEW_PIECES,
        )
        self._remember(room)
        self._panels = Panels(sources=problem.sources, transits=problem.transits, scale=largest(wave.series))
        self._begin(wave, error)
        self._forces = ExponentialForces(problem.sources, problem.transits, known=stretches)
        self.q[M.TOTAL], self.q[M.PACE] = math.ceil(0.5 * problem.transits), 1
        self.q[M.LOOK] = 1 if self._forces.known else self.q[M.TOTAL]
        self._load = NO_LOAD if problem.sources.scenario.free else load_of_a_block(room.degree)
        self._force, self._found = self._forces.packed(0), NO_LOAD
        self._given()

    def _remember(self, room: Room) -> None:
        """Make the memory; what stands in ``array`` is read and written faster by the kernel as it stands."""
        self._room = room
        self.f, self.q = memory(room)
        self._memory: tuple[Any, Any] = self.f, self.q
        if not self.compiled:
            self._memory = array("d", self.f.tobytes()), array("q", self.q.tobytes())
            self.f, self.q = np.frombuffer(self._memory[0]), np.frombuffer(self._memory[1], dtype=np.int64)

    def _given(self) -> None:
        """What the kernel is given beside its memory, after a change: as arrays, or as it stands in lists."""
        if self.compiled and self._forces.known and not self.q[M.LOOPS]:
            places = layout(MOST_FREE, MOST_COLUMNS, self._room.degree + 1)
            self._found, self.q[M.LOOPS] = (np.empty(places[-1]), places), 1
        self._others: Any = self._load, self._force, self._found
        if not self.compiled:
            self._others = tuple(part.tolist() for part in self._load), self._force.tolist(), self._found

    def _kernel(self) -> int:
        """Go on as far as nothing is needed: see :func:`lure.rod.motion.kernel_run.run`."""
        if self.compiled:
            return int(compiled_kernel(kernel_of(self._problem))(self.f, self.q, self._others))
        with np.errstate(all="ignore"):  # as in compiled code
            return run_powers(*self._memory, self._others)

    def _begin(self, wave: Pieces, error: float) -> None:
        f, q, problem = self.f, self.q, self._problem
        rod, first = problem.sources.rod, first_state(problem)
        f[M.TRANSIT : M.TRANSITS + 1] = (
            rod.travel_time,
            problem.share,
            problem.sources.echo,
            rod.impedance,
            rod.area,
            rod.mobility * problem.share,
            problem.transits,
        )
        nonlinearity = [
            x
            for s in problem.nonlinearity.segments
            for x in (s.low, s.high, s.origin, s.push, s.rate, s.power, s.touching)
        ]
        f[q[M.LAW] : q[M.LAW] + len(nonlinearity)] = nonlinearity
        q[M.SEGMENT], q[M.COUNT], q[M.MERGED] = first.segment, len(wave.series), 8
        f[M.VALUE], f[M.REST], f[M.LATER] = first.zeta.value, first.zeta.rest, error
        f[M.STORED] = stored(f, q, problem.nonlinearity.segments[first.segment].origin + first.zeta.value)
        size = np.abs(wave.series)
        seen, width = size > NOISE * self._panels.scale, self._room.degree + 1 + M.COEF
        pieces = f[q[M.OLD] : q[M.OLD] + width * len(size)].reshape(-1, width)
        pieces[:, M.START], pieces[:, M.STOP], pieces[:, M.COEF :] = wave.edges[:-1], wave.edges[1:], wave.series
        pieces[:, M.SIZE] = size.sum(axis=1)
        degree = np.where(seen.any(axis=1), self._room.degree - seen[:, ::-1].argmax(axis=1), 0)
        q[q[M.OLD_DEGREES] : q[M.OLD_DEGREES] + len(size)] = degree

    def records(self) -> Iterator[Record | EventFreeInterval]:
        """The round trips, many at a time.

        Raises
        ------
        InputError
            A wave or a load is not finite or too large, or a load needs too many panels.
        AssumptionError
            Contact and flight alternate more than 4000 times in a round trip, or cannot be told apart.
        """
        while self.q[M.TRIP] < self.q[M.TOTAL]:
            number, self.q[M.WINDOWS : M.IMPACTS + 1] = int(self.q[M.TRIP]), 0
            status = self._kernel()
            if not self.compiled and self._wish is None:
                self._reconsider()
            if self.q[M.WINDOWS]:
                yield self._record(number)
            if status == FREE:
                yield passed_over(self.f, self.q, self._found)
            elif status == SEARCH:
                yield from self._searched()
            elif status == LOADS:
                self._load = self._panels.of(int(self.q[M.TRIP]) // M.BLOCK)
                self._given()
            elif status == FORCE:
                self._force = self._forces.packed(int(self.q[M.TRIP]))
                self._given()
            elif status == FULL and not self.q[M.WINDOWS]:
                self._enlarge()
            elif status not in (DONE, FULL):
                raise self._refusal(status)

    def _searched(self) -> Iterator[EventFreeInterval]:
        """The interval that arrays find, if there is one."""
        trip = int(self.q[M.TRIP])
        force = self._forces.over(trip)[0]
        assert force is not None, "else none is looked for"
        found = searched(self.f, self.q, force, int(self._force[MOST]) - trip)
        if found is not None:
            self.q[M.LOOK], self.q[M.PACE] = self.q[M.TRIP], 2
            yield found

    def _reconsider(self) -> None:
        """Compile from here on if that is likely to take less time than it saves."""
        self._spent += int(self.q[M.PIECES]) * (_PIECE if kernel_of(self._problem) is run else _POWERED)
        trip = int(self.q[M.TRIP])
        if self._spent > LOAD and trip:
            left = self._spent * (0.5 * self._problem.transits / trip - 1.0)
            self.compiled = compilation_pays(self._problem, None, left)
            self._given()

    def _record(self, number: int) -> Record:
        f, q = self.f, self.q
        windows, pieces, numbers, impacts = q[M.WINDOWS : M.IMPACTS + 1].tolist()

        def table(source: NDArray[Any], start: int, rows: int, width: int) -> NDArray[Any]:
            """A copy of what is filled."""
            return source[q[start] : q[start] + rows * width].reshape(rows, width).copy()

        heads, marks = table(q, M.OUT_PIECES, pieces, M.PIECE), table(q, M.OUT_MARKS, windows, M.MARKS)
        ends, first = table(f, M.OUT_ENDS, pieces, M.ENDS), np.empty(windows + 1, dtype=np.int64)
        first[:-1], first[-1] = marks[:, 4], pieces
        return Record(
            number=number,
            share=self._problem.share,
            width=self._room.degree + 1,
            first=first,
            low=ends[:, 0],
            high=ends[:, 1],
            start=heads[:, 0],
            degree=heads[:, 1:],
            coef=table(f, M.OUT_NUMBERS, numbers, 1)[:, 0],
            endings=table(f, M.OUT_ENDINGS, windows, M.ENDINGS),
            marks=marks[:, :4],
            impacts=table(f, M.OUT_IMPACTS, impacts, M.IMPACT),
        )

    def _enlarge(self) -> None:
        """Twice the room, for a round trip of very many pieces."""
        f, q = self.f, self.q
        pieces = 2 * self._room.pieces
        self._remember(replace(self._room, pieces=pieces, recorded=max(self._room.recorded, 4 * pieces)))
        self.f[: M.WAVE], self.q[: M.STATE], self.q[M.TOTAL : M.LOOPS + 1] = (
            f[: M.WAVE],
            q[: M.STATE],
            q[M.TOTAL : M.LOOPS + 1],
        )
        for old, new, name, length in (
            (f, self.f, M.LAW, M.SEGMENT_SIZE * int(q[M.SEGMENTS])),
            (f, self.f, M.OLD, int(q[M.COUNT]) * (self._room.degree + 1 + M.COEF)),
            (q, self.q, M.OLD_DEGREES, int(q[M.COUNT])),
        ):
            new[self.q[name] : self.q[name] + length] = old[q[name] : q[name] + length]

    def _refusal(self, status: int) -> Exception:
        trip, wave = int(self.q[M.TRIP]), self._problem.share * float(self.f[M.LARGEST])
        power = self._problem.nonlinearity.segments[int(self.q[M.SEGMENT])].power
        if status == HUGE:
            return InputError(
                f"the wave in round trip {trip} is {self.f[M.SCALE]:.3g} m/s, more than 1e+100; give smaller "
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
    def crossings(self) -> int:
        """Passages between segments of the nonlinearity."""
        return int(self.q[M.CROSSINGS])

    @property
    def error(self) -> float:
        """Sum of the estimates of the local errors [m]."""
        return float(self.f[M.ERROR])

    @property
    def largest_wave(self) -> float:
        """[m/s]."""
        return float(self.f[M.HIGHEST])

    @property
    def energy_residual(self) -> float:
        """Largest imbalance, relative to the largest energy of a round trip."""
        return float(self.f[M.WORST] / max(self.f[M.ENERGY], LEAST_ENERGY))


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
