"""Round trip after round trip, as far as nothing is needed from outside: the function of which all is compiled.

It looks for round trips in which nothing happens, makes the panels of a force that is a sum of exponentials, and goes
through the other round trips one by one.  It stops where a formula must be looked at, where a record is full, and where
round trips were passed over.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from types import FunctionType

from lure.rod.motion.kernel_free import FROM, LEAST, MOST, MOST_FREE, NEXT, UP_TO, force_at, likely_to_end
from lure.rod.motion.kernel_piece import settled
from lure.rod.motion.kernel_series import (
    ARCS,
    BEFORE,
    BLOCK,
    COEF,
    COUNT,
    DEGREE,
    EXTRA,
    GROWTH,
    HIGH,
    INNER,
    LAW,
    LEFT,
    LOOK,
    LOOPS,
    LOW,
    MERGED,
    MOST_WINDOWS,
    NEW,
    NEW_DEGREES,
    NODES,
    NOW,
    OLD,
    OLD_DEGREES,
    ORIGIN,
    PACE,
    PANEL,
    PASSED,
    PIECES,
    POWER,
    RATE,
    SAVED,
    SAVED_F,
    SCALE,
    SEGMENT,
    SEGMENT_SIZE,
    STATE,
    STOP,
    TERM,
    TOTAL,
    TRANSITS,
    TRIP,
    VALUE,
    WAVE,
    WINDOWS,
    Counts,
    fitted,
    kernel,
)
from lure.rod.motion.kernel_trip import (
    DONE,
    FULL,
    HUGE,
    LARGEST_WAVE,
    NO_ROOM,
    entered,
    followed,
    incoming,
    largest_wave,
    merged,
)
from lure.rod.motion.kernel_walk import free_trips
from lure.rod.motion.pieces import Array

# what run stops for, beside the reasons of kernel_trip: round trips passed over, arrays that look for such, panels of
# the loads, the force after its breakpoint
FREE, SEARCH, LOADS, FORCE = 10, 11, 12, 13
MOST_PACE = 1024
SPAN = 2.0 * BLOCK
_RESOLVED, _NOISE = 1e-15, 1e-16
Load = tuple[Array, Counts]


def run(f: Array, q: Counts, given: tuple[Load, Load, Array, tuple[Array, Counts]], powers: int | None = None) -> int:
    """Go on to the last round trip or as far as there is room; ``DONE``, or what it stops for.

    In one function, since each that calls others is compiled with all of them in it.

    Parameters
    ----------
    f, q : ndarray
        The memory, see :mod:`lure.rod.motion.kernel_series`.
    given : tuple
        Panels of some blocks, see :class:`lure.rod.motion.sources.Panels`, and room for those of one, empty without
        loads; the force, see :meth:`lure.rod.motion.exponential_force.ExponentialForces.packed`; room for round trips
        in which nothing happens, see :func:`lure.rod.motion.kernel_walk.free_trips`.
    powers : int or None
        None without power laws.
    """
    known, own, force, found = given
    while q[TRIP] < q[TOTAL]:
        if q[WINDOWS] == q[MOST_WINDOWS]:
            return FULL
        if q[TRIP] >= force[NEXT]:
            return FORCE
        for k in range(WAVE):
            f[SAVED_F + k] = f[k]
        for k in range(STATE):
            q[SAVED + k] = q[k]
        if q[TRIP] >= q[LOOK]:
            q[PACE] = min(2 * q[PACE], MOST_PACE)
            q[LOOK], most = q[TRIP] + q[PACE], int(force[MOST]) - q[TRIP]
            if most >= LEAST and q[COUNT] <= MOST_FREE and clear(f, q) and not likely_to_end(f, q):
                count = free_trips(f, q, found, force, most) if q[LOOPS] > 0 else -1
                if count > 0:
                    q[LOOK], q[PACE] = q[TRIP], 2
                    return FREE
                if count < 0:
                    return SEARCH
        block, load = q[TRIP] // BLOCK, known
        if len(own[0]) > 0 and not has_block(q, known, block):
            load = own
            if not has_block(q, own, block) and not force_panels(f, q, own, force, block):
                return LOADS
        f[TERM], f[PASSED], q[ARCS], q[LEFT] = 0.0, 0.0, 0, 0
        pieces, status = incoming(f, q, load, min(2.0, f[TRANSITS] - 2.0 * q[TRIP])), FULL
        if pieces != NO_ROOM:
            if not f[SCALE] < LARGEST_WAVE:
                return HUGE
            largest_wave(f, q, pieces, q[NOW])
            q[BEFORE] = q[PIECES]
            status = followed(f, q, pieces, powers)
        if status != DONE:
            for k in range(WAVE):
                f[k] = f[SAVED_F + k]
            for k in range(STATE):
                q[k] = q[SAVED + k]
            return status
        settled(f, q)
        entered(f, q)
        q[COUNT], q[TRIP] = q[LEFT], q[TRIP] + 1
        q[OLD], q[NEW] = q[NEW], q[OLD]
        q[OLD_DEGREES], q[NEW_DEGREES] = q[NEW_DEGREES], q[OLD_DEGREES]
        if q[COUNT] > 1.25 * q[MERGED]:
            before = 2 * q[COUNT]
            while q[COUNT] < 0.9 * before:
                before = q[COUNT]
                merged(f, q)
    return DONE


def renamed(function: Callable[..., int], name: str, defaults: tuple[object, ...] | None) -> Callable[..., int]:
    """The same code with other defaults, which numba compiles and keeps under another name."""
    found = FunctionType(function.__code__, function.__globals__, name, defaults)
    found.__qualname__, found.__module__ = name, function.__module__
    return found


run_powers = renamed(run, "run_powers", (1,))  # with power laws, which take twice as long to compile


@kernel
def clear(f: Array, q: Counts) -> bool:
    """Whether an interval without events may begin: on a straight segment, with whole round trips, off its ends."""
    law = q[LAW] + SEGMENT_SIZE * q[SEGMENT]
    last = q[OLD] + (q[DEGREE] + 1 + COEF) * (q[COUNT] - 1)
    if f[law + RATE] == math.inf or f[law + POWER] != 1.0 or f[last + STOP] != 2.0:
        return False
    z = f[law + ORIGIN] + f[VALUE]
    return bool(f[law + LOW] < z < f[law + HIGH])


@kernel
def has_block(q: Counts, loads: Load, block: int) -> bool:
    """Whether the panels are there."""
    load, heads = loads
    if len(load) == 0:
        return False
    count = len(heads) - 2 - len(load) // (2 * (q[DEGREE] + 1) + PANEL)
    return bool(heads[0] <= block < heads[0] + count)


@kernel
def force_panels(f: Array, q: Counts, loads: Load, force: Array, block: int) -> bool:
    """Fill the panel of a force that is a sum of exponentials in a whole block, if a series resolves it.

    In block 0 the force needs a transit to arrive, so that a panel without any goes before.
    """
    (load, heads), first, n, width = loads, SPAN * block, q[DEGREE], 2 * (q[DEGREE] + 1) + PANEL
    low, empty = 1.0 if block == 0 else 0.0, 1 if block == 0 else 0
    if force[FROM] > max(first, 1.0) or force[UP_TO] < first + SPAN:
        return False
    for j in range(n + 1):
        x = low + 0.5 * (SPAN - low) * (f[q[INNER] + n * (n + 1) + j] + 1.0) - 1.0
        f[NODES + j] = force_at(force, x, first)
    fitted(f, q, n, EXTRA)
    size, at, degree = 0.0, width * empty, 0
    for k in range(n + 1):
        size += abs(f[EXTRA + k])
    if not max(abs(f[EXTRA + n]), abs(f[EXTRA + n - 1])) <= _RESOLVED * size:
        return False
    for k in range(n + 1):
        if abs(f[EXTRA + k]) > _NOISE * size:
            degree = k
    for k in range(width):
        load[k], load[at + k] = 0.0, 0.0
    load[1] = 1.0
    load[at], load[at + 1], load[at + 2] = low, SPAN, size
    for j in range(degree + 1):
        load[at + PANEL + j] = f[EXTRA + j]
        for k in range(j + 1):
            load[at + PANEL + n + 1 + k] += abs(f[EXTRA + j]) * f[q[GROWTH] + k * (n + 1) + j]
    heads[0], heads[1], heads[2], heads[3], heads[4] = block, 0, 1 + empty, 0, 0
    heads[3 + empty] = degree
    return True
