"""The memory of the compiled engine: one array ``f`` of doubles and one array ``q`` of integers.

Places are ``numpy`` integers, for which numba makes one version of a function; for a Python integer it makes another.
Every function of the engine takes these two and places in them; a call with fifty arrays would cost more than a round
trip.  A series of degree ``n`` at place ``c`` is ``f[c], ..., f[c + n]``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import cast

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from lure.rod.motion.chebyshev import Array

Counts = NDArray[np.int64]


def _places(start: int, stop: int, step: int = 1) -> list[int]:
    """Numpy integers, which behave as those of Python."""
    return cast(list[int], list(np.arange(start, stop, step)))


(ZERO,) = _places(0, 1)
BLOCK = 16  # round trips to which one panel of the loads may extend

# f: the rod, with d reduced by the share
TRANSIT, SHARE, ECHO, IMPEDANCE, AREA, MOBILITY, TRANSITS = _places(0, 7)
# f: z from the origin of the segment and what rounding lost of it; scale of the wave; error of the wave that comes next
VALUE, REST, SCALE, LATER = _places(8, 12)
# f: the arc at hand: travelled since its start and on the piece; largest wave ahead; rounding of what tells its end
TRAVELLED, TRAVEL, LARGEST, TOLERANCE = _places(12, 16)
# f: the impact that goes on [s, s, N s, m/s]
SINCE, UNTIL, IMPULSE, PEAK = _places(16, 20)
# f: sums since the start: error, work and its remainder, worst imbalance, largest energy and wave; A P at the start
ERROR, WORK, WORK_REST, WORST, ENERGY, HIGHEST, STORED = _places(20, 27)
# f: the round trip at hand: work on the end, energy that passes, error of its series
TERM, PASSED, MISSED = _places(27, 30)
# f: series of the piece at hand, series that are only looked at, a tridiagonal system; intervals still to be looked at
WAVE, ZETA, PUSH, EXTRA, NODES, PART, SLOPE, PIVOT, RIGHT, FREE, UNIT, STACK = _places(32, 32 + 12 * 48, 48)
FIXED = STACK + 256

# q: where the motion is: round trip, segment, pieces of the wave that comes next, and of it after the last merging
TRIP, SEGMENT, COUNT, MERGED = _places(0, 4)
# q: whether the arc has a piece; whether an impact goes on; crossings since the start
BEGUN, OPEN, CROSSINGS = _places(4, 7)
# q: what the record holds: round trips, pieces, coefficients, impacts; pieces before this round trip
WINDOWS, PIECES, NUMBERS, IMPACTS, BEFORE = _places(7, 12)
# q: the round trip at hand: arcs, pieces that left
ARCS, LEFT = _places(12, 14)
(STATE,) = _places(14, 15)  # f[:WAVE] and q[:STATE] change from round trip to round trip
# q: degree N, number of segments, room for pieces, for round trips, for pieces and coefficients of the record
DEGREE, SEGMENTS, ROOM, MOST_WINDOWS, MOST_PIECES, MOST_NUMBERS = _places(14, 20)
# q: places in f of tables, law, waves (coming back, with loads, leaving) and record
INNER, FIT, PRODUCTS, LAW, OLD, NOW, NEW, OUT_ENDS, OUT_NUMBERS, OUT_ENDINGS, OUT_IMPACTS = _places(20, 31)
# q: places in q of degrees of the waves and of the record
OLD_DEGREES, NOW_DEGREES, NEW_DEGREES, OUT_PIECES, OUT_MARKS = _places(31, 36)
(SAVED,) = _places(36, 37)  # the state as it was before this round trip
HEADS = SAVED + STATE
SAVED_F = FIXED  # the same of f
FIXED_F = SAVED_F + WAVE

# a segment: six numbers; see lure.rod.motion.end_law.Segment
LOW, HIGH, ORIGIN, STRESS, RATE, TOUCHING = _places(0, 6)
(SEGMENT_SIZE,) = _places(6, 7)
# a piece of a wave: ends, sum of absolute values, coefficients
START, STOP, SIZE, COEF = _places(0, 4)
# a panel of the loads: ends in its block, largest value, error, coefficients, then bounds (see panels.py)
(PANEL,) = _places(4, 5)
# the record: ends of a piece; place of its coefficients and degrees of W, z, d p; see lure.rod.motion.record
(ENDS,), (PIECE,), (ENDINGS,), (MARKS,), (IMPACT,) = (_places(n, n + 1) for n in (2, 4, 7, 5, 4))


@dataclass(frozen=True, kw_only=True, slots=True)
class Room:
    """How much fits: degree, segments, pieces of a wave, round trips and pieces of the record."""

    degree: int
    segments: int
    pieces: int
    windows: int
    recorded: int


def memory(room: Room) -> tuple[Array, Counts]:
    """``f`` and ``q`` with the tables in them, and zeros."""
    size, pieces, windows, recorded = room.degree + 1, room.pieces, room.windows, room.recorded
    wave, numbers = pieces * (size + COEF), 3 * size * recorded
    tables = (size**2, size**3, size**2, SEGMENT_SIZE * room.segments)
    record = (ENDS * recorded, numbers, ENDINGS * windows, IMPACT * recorded)
    places = np.cumsum((FIXED_F, *tables, wave, wave, wave, *record))
    counts = (pieces, pieces, pieces, PIECE * recorded, MARKS * windows)
    heads = np.cumsum((HEADS, *counts))
    f, q = np.zeros(places[-1]), np.zeros(heads[-1], dtype=np.int64)
    q[DEGREE:INNER] = room.degree, room.segments, pieces, windows, recorded, numbers
    q[INNER : OUT_IMPACTS + 1], q[OLD_DEGREES : OUT_MARKS + 1] = places[:-1], heads[:-1]
    for place, table in zip(places, _constants(room.degree), strict=False):
        f[place : place + table.size] = table.ravel()
    return f, q


@lru_cache(maxsize=4)
def _constants(degree: int) -> tuple[Array, Array, Array]:
    """Zeros of ``T_{n+1}`` (N+1, N+1), from values there to coefficients, integrals of ``T_i T_j`` over ``[-1, 1]``."""
    size = degree + 1
    inner, fit = np.zeros((size, size)), np.zeros((size, size, size))
    for n in range(size):
        points = -np.cos(np.pi * (np.arange(n + 1) + 0.5) / (n + 1))
        inner[n, : n + 1] = points
        fit[n, : n + 1, : n + 1] = np.linalg.inv(chebyshev.chebvander(points, n))
    i, j = np.arange(size, dtype=float)[:, None], np.arange(size, dtype=float)[None, :]
    even = (i + j) % 2 == 0
    products = np.where(even, 1.0 / (1.0 - (i + j) ** 2 * even) + 1.0 / (1.0 - (i - j) ** 2 * even), 0.0)
    return inner, fit, products
