"""Round trip after round trip, as far as nothing is needed from outside: the function of which all is compiled.

It looks for round trips in which nothing happens, makes the panels of a force that is a sum of exponentials, and goes
through the other round trips one by one.  It stops where a formula must be looked at, where a record is full, and where
round trips were passed over.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from types import FunctionType

from lure.rod.motion import kernel_series as M
from lure.rod.motion.kernel_free import FROM, LEAST, MOST, MOST_FREE, NEXT, UP_TO, force_at, likely_to_end
from lure.rod.motion.kernel_piece import settled
from lure.rod.motion.kernel_series import Counts, fitted, kernel
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
SPAN = 2.0 * M.BLOCK
_NARROWEST = SPAN / (M.PANELS - 1)
_RESOLVED, _NOISE = 1e-15, 1e-16
Load = tuple[Array, Counts]


def run(f: Array, q: Counts, given: tuple[Load, Array, tuple[Array, Counts]], powers: int | None = None) -> int:
    """Go on to the last round trip or as far as there is room; ``DONE``, or what it stops for.

    In one function, since each that calls others is compiled with all of them in it.

    Parameters
    ----------
    f, q : ndarray
        The memory, see :mod:`lure.rod.motion.kernel_series`.
    given : tuple
        Panels of a block, see :class:`lure.rod.motion.sources.Panels`, empty without loads; the force, see
        :meth:`lure.rod.motion.exponential_force.ExponentialForces.packed`; room for round trips in which nothing
        happens, see :func:`lure.rod.motion.kernel_walk.free_trips`.
    powers : int or None
        None without power laws.
    """
    load, force, found = given
    while q[M.TRIP] < q[M.TOTAL]:
        if q[M.WINDOWS] == q[M.MOST_WINDOWS]:
            return FULL
        if q[M.TRIP] >= force[NEXT]:
            return FORCE
        for k in range(M.WAVE):
            f[M.SAVED_F + k] = f[k]
        for k in range(M.STATE):
            q[M.SAVED + k] = q[k]
        if q[M.TRIP] >= q[M.LOOK]:
            q[M.PACE] = min(2 * q[M.PACE], MOST_PACE)
            q[M.LOOK], most = q[M.TRIP] + q[M.PACE], int(force[MOST]) - q[M.TRIP]
            if most >= LEAST and q[M.COUNT] <= MOST_FREE and clear(f, q) and not likely_to_end(f, q):
                count = free_trips(f, q, found, force, most) if q[M.LOOPS] > 0 else -1
                if count > 0:
                    q[M.LOOK], q[M.PACE] = q[M.TRIP], 2
                    return FREE
                if count < 0:
                    return SEARCH
        block = q[M.TRIP] // M.BLOCK
        if len(load[0]) > 0 and load[1][0] != block and not force_panels(f, q, load, force, block):
            return LOADS
        f[M.TERM], f[M.PASSED], q[M.ARCS], q[M.LEFT] = 0.0, 0.0, 0, 0
        pieces, status = incoming(f, q, load, min(2.0, f[M.TRANSITS] - 2.0 * q[M.TRIP])), FULL
        if pieces != NO_ROOM:
            if not f[M.SCALE] < LARGEST_WAVE:
                return HUGE
            largest_wave(f, q, pieces, q[M.NOW])
            q[M.BEFORE] = q[M.PIECES]
            status = followed(f, q, pieces, powers)
        if status != DONE:
            for k in range(M.WAVE):
                f[k] = f[M.SAVED_F + k]
            for k in range(M.STATE):
                q[k] = q[M.SAVED + k]
            return status
        settled(f, q)
        entered(f, q)
        q[M.COUNT], q[M.TRIP] = q[M.LEFT], q[M.TRIP] + 1
        q[M.OLD], q[M.NEW] = q[M.NEW], q[M.OLD]
        q[M.OLD_DEGREES], q[M.NEW_DEGREES] = q[M.NEW_DEGREES], q[M.OLD_DEGREES]
        if q[M.COUNT] > 1.25 * q[M.MERGED]:
            before = 2 * q[M.COUNT]
            while q[M.COUNT] < 0.9 * before:
                before = q[M.COUNT]
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
    law = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT]
    last = q[M.OLD] + (q[M.DEGREE] + 1 + M.COEF) * (q[M.COUNT] - 1)
    if f[law + M.RATE] == math.inf or f[law + M.POWER] != 1.0 or f[last + M.STOP] != 2.0:
        return False
    z = f[law + M.ORIGIN] + f[M.VALUE]
    return bool(f[law + M.LOW] < z < f[law + M.HIGH])


@kernel
def force_panels(f: Array, q: Counts, loads: Load, force: Array, block: int) -> bool:
    """Fill the panels of a force that is a sum of exponentials in a whole block, as wide as series resolve it.

    Their widths are halved, and they end at multiples of them.  In block 0 the force needs a transit to arrive, so that
    a panel without any goes before.
    """
    first, low, width, count = SPAN * block, 0.0, SPAN, 0
    if force[FROM] > max(first, 1.0) or force[UP_TO] < first + SPAN:
        return False
    while low < SPAN:
        late = block == 0 and low == 0.0
        high = 1.0 if late else (math.floor(low / width) + 1.0) * width
        if late or force_panel(f, q, loads, force, (first, low, high, count)):
            if late:
                panel(f, q, loads, (low, high, 0.0, count), 0)
            low, count = high, count + 1
            continue
        width *= 0.5
        if width < _NARROWEST:
            return False
    loads[1][0], loads[1][1] = block, count
    return True


@kernel
def force_panel(f: Array, q: Counts, loads: Load, force: Array, place: tuple[float, float, float, int]) -> bool:
    """Fill one of them; whether a series resolves the force on it."""
    (first, low, high, count), n, size, degree = place, q[M.DEGREE], 0.0, 0
    for j in range(n + 1):
        x = low + 0.5 * (high - low) * (f[q[M.INNER] + n * (n + 1) + j] + 1.0) - 1.0
        f[M.NODES + j] = force_at(force, x, first)
    fitted(f, q, n, M.EXTRA)
    for k in range(n + 1):
        size += abs(f[M.EXTRA + k])
    if not max(abs(f[M.EXTRA + n]), abs(f[M.EXTRA + n - 1])) <= _RESOLVED * size:
        return False
    for k in range(n + 1):
        if abs(f[M.EXTRA + k]) > _NOISE * size:
            degree = k
    panel(f, q, loads, (low, high, size, count), degree)
    return True


@kernel
def panel(f: Array, q: Counts, loads: Load, place: tuple[float, float, float, int], degree: int) -> None:
    """Enter a panel with the series in ``EXTRA``; with none where its size is zero."""
    (low, high, size, count), n = place, q[M.DEGREE]
    width = 2 * (n + 1) + M.PANEL
    load, at = loads[0], width * count
    for k in range(width):
        load[at + k] = 0.0
    load[at], load[at + 1], load[at + 2], loads[1][2 + count] = low, high, size, degree
    if size > 0.0:
        load[at + 3] = max(abs(f[M.EXTRA + n]), abs(f[M.EXTRA + n - 1])) + _NOISE * size
    for j in range(degree + 1 if size > 0.0 else 0):
        load[at + M.PANEL + j] = f[M.EXTRA + j]
        for k in range(j + 1):
            load[at + M.PANEL + n + 1 + k] += abs(f[M.EXTRA + j]) * f[q[M.GROWTH] + k * (n + 1) + j]
