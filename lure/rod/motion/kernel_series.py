"""The kernel of the exact motion: its memory, one Chebyshev series in it, the first crossing and the largest value.

The functions of the files ``kernel_*.py`` run as they stand; where a motion is long and numba is installed,
:func:`lure.rod.motion.compilation.compiled_kernel` compiles the same functions.

The memory is one array ``f`` of doubles and one array ``q`` of integers.  Every function takes these two arrays and
places in them; a call with fifty arrays would cost more than a round trip.  A series of degree ``n`` at place ``c`` is
``f[c], ..., f[c + n]``.  The places have their names here; the other files read them as ``M.TRIP``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from lure.rod.motion.pieces import Array, basis, products

F = TypeVar("F", bound=Callable[..., object])
PARTS: list[tuple[Callable[..., object], bool]] = []


def kernel(function: F) -> F:
    """The function itself, entered among those that are compiled together."""
    PARTS.append((function, False))
    return function


def inlined(function: F) -> F:
    """The function itself; when it is compiled, it is compiled into each place where it is called."""
    PARTS.append((function, True))
    return function


Counts = NDArray[np.int64]


ZERO = 0
BLOCK = 16  # round trips to which one panel of the loads may extend
PANELS = 129  # of a block for which the kernel has room

# f: the rod, with d reduced by the share
TRANSIT, SHARE, ECHO, IMPEDANCE, AREA, MOBILITY, TRANSITS = range(0, 7)
# f: z from the origin of the segment and what rounding lost of it; scale of the wave; error of the wave that comes next
VALUE, REST, SCALE, LATER = range(8, 12)
# f: the arc at hand: travelled since its start and on the piece; largest wave ahead; rounding of what tells its end;
# width of the next piece against a power law
TRAVELLED, TRAVEL, LARGEST, TOLERANCE, STEP = range(12, 17)
# f: the impact that goes on [s, s, N s, m/s]
SINCE, UNTIL, IMPULSE, PEAK = range(17, 21)
# f: sums since the start: error, work and its remainder, worst imbalance, largest energy and wave; A P at the start
ERROR, WORK, WORK_REST, WORST, ENERGY, HIGHEST, STORED = range(21, 28)
# f: the round trip at hand: work on the end, energy that passes, error of its series
TERM, PASSED, MISSED = range(28, 31)
# f: series of the piece at hand, series that are only looked at, a tridiagonal system; intervals still to be looked at
WAVE, ZETA, PUSH, EXTRA, NODES, PART, SLOPE, PIVOT, RIGHT, FREE, UNIT, STACK = range(32, 32 + 12 * 48, 48)
FIXED = STACK + 256

# q: where the motion is: round trip, segment, pieces of the wave that comes next, and of it after the last merging
TRIP, SEGMENT, COUNT, MERGED = range(0, 4)
# q: whether the arc has a piece; whether an impact goes on; crossings since the start
BEGUN, OPEN, CROSSINGS = range(4, 7)
# q: what the record holds: round trips, pieces, coefficients, impacts; pieces before this round trip
WINDOWS, PIECES, NUMBERS, IMPACTS, BEFORE = range(7, 12)
# q: the round trip at hand: arcs, pieces that left, those of them against the power law at hand
ARCS, LEFT, POWERED = range(12, 15)
STATE = 15  # f[:WAVE] and q[:STATE] change from round trip to round trip
# q: degree N, number of segments, room for pieces, for round trips, for pieces and coefficients of the record
DEGREE, SEGMENTS, ROOM, MOST_WINDOWS, MOST_PIECES, MOST_NUMBERS = range(15, 21)
# q: places in f of tables, nonlinearity, waves (coming back, with loads, leaving) and record
INNER, FIT, PRODUCTS, AT_EXTREMA, COLLOCATION, FROM_EXTREMA, GROWTH = range(21, 28)
LAW, OLD, NOW, NEW, OUT_ENDS, OUT_NUMBERS, OUT_ENDINGS, OUT_IMPACTS = range(28, 36)
# q: places in q of degrees of the waves and of the record
OLD_DEGREES, NOW_DEGREES, NEW_DEGREES, OUT_PIECES, OUT_MARKS = range(36, 41)
# q: where the motion ends; where to look for round trips without events next, how far that is, and whether in loops
TOTAL, LOOK, PACE, LOOPS = range(41, 45)
SAVED = 45  # the state as it was before this round trip
HEADS = SAVED + STATE
SAVED_F = FIXED  # the same of f
FIXED_F = SAVED_F + WAVE

# a segment: seven numbers; see lure.rod.motion.end_law.Segment
LOW, HIGH, ORIGIN, STRESS, RATE, POWER, TOUCHING = range(0, 7)
SEGMENT_SIZE = 7
# a piece of a wave: ends, sum of absolute values, coefficients
START, STOP, SIZE, COEF = range(0, 4)
# a panel of the loads: ends in its block, largest value, error, coefficients, then bounds (see sources.Panels)
PANEL = 4
# the record: ends of a piece; place of its coefficients and degrees of W, z, d p; see lure.rod.motion.record
ENDS, PIECE, ENDINGS, MARKS, IMPACT = 2, 4, 7, 5, 4


@dataclass(frozen=True, kw_only=True, slots=True)
class Room:
    """How much fits: degree, segments, pieces of a wave, round trips and pieces of the record."""

    degree: int
    segments: int
    pieces: int
    windows: int
    recorded: int


def memory(room: Room) -> tuple[Array, Counts]:
    """``f`` and ``q`` with the tables in them, zeros before them, and what is written before it is read."""
    begin, heads, size, counts = _begin(room)
    f, q = np.empty(size), np.empty(counts, dtype=np.int64)
    f[: len(begin)], q[: len(heads)] = begin, heads
    return f, q


@lru_cache(maxsize=16)
def _begin(room: Room) -> tuple[Array, Counts, int, int]:
    """With what ``f`` and ``q`` begin, and how long they are."""
    size, pieces, windows, recorded = room.degree + 1, room.pieces, room.windows, room.recorded
    wave, numbers = pieces * (size + COEF), 3 * size * recorded
    constants = _constants(room.degree)
    tables = (*(table.size for table in constants), SEGMENT_SIZE * room.segments)
    record = (ENDS * recorded, numbers, ENDINGS * windows, IMPACT * recorded)
    places = np.cumsum((FIXED_F, *tables, wave, wave, wave, *record))
    heads = np.cumsum((HEADS, pieces, pieces, pieces, PIECE * recorded, MARKS * windows))
    q = np.zeros(HEADS, dtype=np.int64)
    q[DEGREE:INNER] = room.degree, room.segments, pieces, windows, recorded, numbers
    q[INNER : OUT_IMPACTS + 1], q[OLD_DEGREES : OUT_MARKS + 1] = places[:-1], heads[:-1]
    f = np.concatenate((np.zeros(FIXED_F), *(table.ravel() for table in constants)))
    return f, q, int(places[-1]), int(heads[-1])


@lru_cache(maxsize=4)
def _constants(degree: int) -> tuple[Array, ...]:
    """Zeros of ``T_{n+1}`` (N+1, N+1), from values there to coefficients, integrals of ``T_i T_j``; for the extrema."""
    size, space = degree + 1, basis(degree)
    inner, fit = np.zeros((size, size)), np.zeros((size, size, size))
    for n in range(size):
        points = -np.cos(np.pi * (np.arange(n + 1) + 0.5) / (n + 1))
        inner[n, : n + 1] = points
        fit[n, : n + 1, : n + 1] = np.linalg.inv(chebyshev.chebvander(points, n))
    return inner, fit, products(size), space.at_ends, space.collocation, space.from_ends, growth(degree)


@lru_cache(maxsize=4)
def growth(degree: int) -> Array:
    """``T_j^(k)(1)/(2^{k-1} k!)`` (N+1, N+1): times ``r^k`` it bounds the k-th coefficient of ``T_j(a + r x)``."""
    j = np.arange(degree + 1, dtype=float)
    rows = [np.ones(degree + 1)]
    for k in range(1, degree + 1):
        factor = (j**2 - (k - 1.0) ** 2) / (2.0 * k - 1.0) / ((2.0 if k > 1 else 1.0) * k)
        rows.append(rows[-1] * factor)
    return np.array(rows)


NOISE = 1e-16  # coefficients of a part below this share of the whole are rounding


@kernel
def value(f: Array, c: int, n: int, x: float) -> float:
    """Value at ``x``, by Clenshaw's recurrence."""
    total, before = 0.0, 0.0
    for k in range(n, 0, -1):
        total, before = 2.0 * x * total - before + f[c + k], total
    return float(x * total - before + f[c])


@inlined
def right_end(f: Array, c: int, n: int) -> float:
    """Value at 1."""
    total = 0.0
    for k in range(n + 1):
        total += f[c + k]
    return total


@kernel
def left_end(f: Array, c: int, n: int) -> float:
    """Value at -1."""
    total, sign = 0.0, 1.0
    for k in range(n + 1):
        total += sign * f[c + k]
        sign = -sign
    return total


@inlined
def variation(f: Array, c: int, n: int) -> float:
    """Sum of ``|c_k|``, ``k >= 1``."""
    total = 0.0
    for k in range(1, n + 1):
        total += abs(f[c + k])
    return total


@inlined
def trimmed(f: Array, c: int, n: int, tiny: float) -> int:
    """Degree without the last coefficients up to ``tiny``."""
    while n > 0 and abs(f[c + n]) <= tiny:
        n -= 1
    return n


@kernel
def fitted(f: Array, q: Counts, n: int, out: int) -> float:
    """The series of degree ``n`` with the values ``f[NODES], ...`` at the zeros of ``T_{n+1}``; the largest value."""
    width, largest = q[DEGREE] + 1, 0.0
    row = q[FIT] + n * width * width
    for k in range(n + 1):
        total = 0.0
        for j in range(n + 1):
            total += f[row + j] * f[NODES + j]
        f[out + k] = total
        largest = max(largest, abs(f[NODES + k]))
        row += width
    return largest


@kernel
def part(f: Array, q: Counts, series: tuple[int, int], span: tuple[float, float], out: int) -> float:
    """The series on ``[low, high]`` as one on ``[-1, 1]``, with its whole degree; its largest value at the nodes."""
    (c, n), (low, high) = series, span
    half, inner = 0.5 * (high - low), q[INNER] + n * (q[DEGREE] + 1)
    for j in range(n + 1):
        f[NODES + j] = value(f, c, n, low + half * (f[inner + j] + 1.0))
    return fitted(f, q, n, out)


@kernel
def short_part(f: Array, q: Counts, series: tuple[int, int], span: tuple[float, float], out: int) -> int:
    """The part of a series without coefficients that are rounding, and its degree; ``out`` may be the series itself."""
    return trimmed(f, out, series[1], NOISE * part(f, q, series, span, out))


@kernel
def direction(f: Array, c: int, n: int) -> int:
    """1 or -1 where the function certainly rises or falls on all of ``[-1, 1]``, else 0."""
    above, here, rest = 0.0, 0.0, 0.0
    for k in range(n, 0, -1):
        above, here = here, above + 2.0 * k * f[c + k]
        if k > 1:
            rest += abs(here)
    first = 0.5 * here
    if abs(first) < rest or first == 0.0:
        return 0
    return 1 if first > 0.0 else -1


@kernel
def differentiated(f: Array, c: int, n: int, out: int) -> int:
    """The derivative, and its degree."""
    above, here = 0.0, 0.0
    for k in range(n, 0, -1):
        above, here = here, above + 2.0 * k * f[c + k]
        f[out + k - 1] = here
    if n == 0:
        f[out] = 0.0
        return 0
    f[out] *= 0.5
    return n - 1


@kernel
def mean(f: Array, c: int, n: int) -> float:
    """Mean over ``[-1, 1]``."""
    total = 0.0
    for k in range(0, n + 1, 2):
        total += f[c + k] / (1.0 - float(k) * float(k))
    return total


@inlined
def product(f: Array, q: Counts, first: tuple[int, int], second: tuple[int, int]) -> float:
    """Integral of the product of two series over ``[-1, 1]``."""
    (c, n), (d, m), total = first, second, 0.0
    row, width = q[PRODUCTS], q[DEGREE] + 1
    for i in range(n + 1):
        sum_ = 0.0
        for j in range(i & 1, m + 1, 2):
            sum_ += f[row + j] * f[d + j]
        total += f[c + i] * sum_
        row += width
    return total


NEVER, UNDECIDED = 2.0, 3.0
_MOST_INTERVALS = 20_000
_THINNEST = 1e-14
_FLAT = 0.25  # of the tolerance: what varies less is not halved, for its sign of slope may be rounding
_MOST_HALVES = 400
_LEVEL = 4e-15


@kernel
def first_rise(f: Array, q: Counts, c: int, n: int, tolerance: float) -> float:
    """The zero before the first excursion above ``tolerance``; ``NEVER``, or ``UNDECIDED`` after 20000 intervals.

    By bounds on whole intervals, not by samples: an interval is halved until every part is below, or rises through
    zero.  An excursion above zero that stays below the tolerance, the rounding of ``f``, counts as none (grazing).
    """
    if f[c] + variation(f, c, n) <= tolerance:
        return NEVER
    depth, seen, below = 1, 0, -1.0
    f[STACK], f[STACK + 1] = -1.0, 1.0
    while depth > 0:
        depth -= 1
        low, high = f[STACK + 2 * depth], f[STACK + 2 * depth + 1]
        seen += 1
        if seen > _MOST_INTERVALS:
            return UNDECIDED
        d = c
        if seen > 1:
            d = PART
            part(f, q, (c, n), (low, high), d)
        start = left_end(f, d, n)
        if start <= 0.0:
            below = low
        if seen > 1 and f[d] + variation(f, d, n) <= tolerance:
            continue
        stop, way = right_end(f, d, n), direction(f, d, n)
        if way != 0 and max(start, stop) <= tolerance:
            continue
        if start > tolerance or (way > 0 and start >= 0.0):
            return zero(f, c, n, (below, low)) if low > below else float(low)
        if way > 0 or high - low < _THINNEST or variation(f, d, n) <= _FLAT * tolerance:
            if stop > tolerance:
                return zero(f, c, n, (below, high))
            continue
        _halved(f, depth, low, high)
        depth += 2
    return NEVER


@kernel
def _halved(f: Array, depth: int, low: float, high: float) -> None:
    """Both halves on the stack, the first on top."""
    at, middle = STACK + 2 * depth, 0.5 * (low + high)
    f[at], f[at + 1], f[at + 2], f[at + 3] = middle, high, low, middle


@kernel
def zero(f: Array, c: int, n: int, span: tuple[float, float]) -> float:
    """The zero in between, where ``f(low) <= 0 < f(high)``: regula falsi (Illinois), kept inside by bisection."""
    low, high = span
    below, above, last = value(f, c, n, low), value(f, c, n, high), 0
    for step in range(200):
        if high - low <= 2.3e-16 * max(1.0, abs(low)) or below == 0.0:
            return low
        x = 0.5 * (low + high)
        if step % 8 < 6 and above - below > 0.0:
            x = (low * above - high * below) / (above - below)
        if not low < x < high:
            x = 0.5 * (low + high)
            if not low < x < high:
                return low
        y = value(f, c, n, x)
        if y > 0.0:
            if last > 0:
                below *= 0.5
            high, above, last = x, y, 1
        else:
            if last < 0:
                above *= 0.5
            low, below, last = x, y, -1
            if y == 0.0:
                return x
    return low


@kernel
def peak(f: Array, q: Counts, c: int, n: int, best: float) -> float:
    """The larger of ``best`` and the largest value of the series, to rounding."""
    size = abs(f[c]) + variation(f, c, n)
    if f[c] + variation(f, c, n) <= best + 1e-15 * size:
        return best
    depth, seen = 1, 0
    f[STACK], f[STACK + 1] = -1.0, 1.0
    while depth > 0:
        depth -= 1
        low, high = f[STACK + 2 * depth], f[STACK + 2 * depth + 1]
        d, seen = c, seen + 1
        if seen > 1:
            d = PART
            part(f, q, (c, n), (low, high), d)
            if f[d] + variation(f, d, n) <= best + 1e-15 * size:
                continue
        best = max(best, left_end(f, d, n), right_end(f, d, n))
        if direction(f, d, n) != 0 or variation(f, d, n) <= _LEVEL * size or seen > _MOST_HALVES:
            continue
        m = differentiated(f, d, n, SLOPE)
        bend = direction(f, SLOPE, m)
        if bend < 0 and left_end(f, SLOPE, m) > 0.0 > right_end(f, SLOPE, m):
            for k in range(m + 1):
                f[SLOPE + k] = -f[SLOPE + k]
            best = max(best, value(f, d, n, zero(f, SLOPE, m, (-1.0, 1.0))))
        if bend == 0:
            _halved(f, depth, low, high)
            depth += 2
    return best
