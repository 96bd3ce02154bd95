r"""Round trips in which nothing happens, passed over at once: :mod:`lure.rod.motion.event_search` for compiled code.

A block of round trips is cut into parts, over each of which Newton's series bounds ``zeta``; a part that does not keep
certainly off the ends of the segment is halved, down to single round trips.
"""

from __future__ import annotations

import math

import numpy as np

from lure.rod.motion import kernel_free as F
from lure.rod.motion import kernel_series as M
from lure.rod.motion.kernel_free import (
    at_trip,
    eliminated,
    force_columns,
    series_length,
    terms_made,
    trip_degrees,
)
from lure.rod.motion.kernel_piece import local
from lure.rod.motion.kernel_series import Counts, kernel, peak, value
from lure.rod.motion.kernel_trip import stored
from lure.rod.motion.pieces import Array

_PARTS = 16  # of a block, at first


@kernel
def within(g: Array, terms: int, width: int, count: int, i: int) -> float:
    """A bound on the i-th number of a series up to round trip ``count``."""
    total, weight = 0.0, 1.0
    for j in range(F.TERMS + 1):
        if j > 0:
            weight *= (count - (j - 1.0)) / j
        total += weight * abs(g[terms + width * j + i])
    return total


@kernel
def bends_within(g: Array, o: Counts, place: tuple[int, int, int]) -> None:
    """Fill the bounds on second differences of what is watched, whose terms begin two later."""
    (b, width, count), terms, weight = place, o[F.WATCHED] + place[1] * (F.TERMS + 1) * place[0], 1.0
    for i in range(width):
        g[o[F.BENDS] + width * b + i] = 0.0
    for j in range(2, F.TERMS + 1):
        if j > 2:
            weight *= (count - (j - 3.0)) / (j - 2.0)
        for i in range(width):
            g[o[F.BENDS] + width * b + i] += weight * abs(g[terms + width * j + i])


@kernel
def sizes_within(f: Array, q: Counts, g: Array, o: Counts, place: tuple[int, int]) -> tuple[float, float]:
    """Bounds on ``W`` and its last coefficients over so many round trips of a block; fills those beyond the first."""
    (b, count), P, size = place, q[M.COUNT], int(g[F.WAVE_DEGREE]) + 1
    largest, tail, terms = 0.0, 0.0, o[F.WAVES] + size * P * (F.TERMS + 1) * b
    for p in range(P):
        total, c = 0.0, 0.0
        for k in range(1, size):
            c = within(g, terms, size * P, count, size * p + k)
            total += c
        largest = max(largest, total + within(g, terms, size * P, count, size * p))
        if f[q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT] + M.RATE] != 0.0:
            tail = max(tail, c)
        g[o[F.OTHERS] + P * b + p] = f[M.SHARE] * total
    return largest, tail


@kernel
def reached(
    g: Array, o: Counts, ends: tuple[int, int], place: tuple[int, int, float], step: float
) -> tuple[float, float]:
    """Bounds on ``-zeta`` and ``zeta`` over a part, from what is watched in its first round trip and after its last.

    Straight lines between, and what bends; where the slope keeps its sign on a piece its ends are the bounds.
    """
    (first, last), (b, P, rate) = ends, place
    bends, below, above, bend = o[F.BENDS] + (2 * P + 1) * b, -math.inf, -math.inf, 0.5 * math.floor(0.25 * step * step)
    for p in range(P):
        i, others = P + 1 + p, g[o[F.OTHERS] + P * b + p]
        more = bend * g[bends + i]
        fall, rise = max(-g[first + i], -g[last + i]) + more, max(g[first + i], g[last + i]) + more
        swing = 2.0 * g[o[F.HALVES] + p] * (max(fall, rise) + others)
        if min(fall, rise) + (rate * swing + others) <= 0.0:
            swing = 0.0
        for e in range(p, p + 2):
            more = bend * g[bends + e] + swing
            below = max(below, max(-g[first + e], -g[last + e]) + more)
            above = max(above, max(g[first + e], g[last + e]) + more)
    return below, above


@kernel
def watched_from(g: Array, o: Counts, b: int, P: int, count: int) -> int:
    """Fill the stack with the ends of the parts of a block, the first on top, and what is watched here; how many."""
    terms, width, depth, step = o[F.WATCHED] + (2 * P + 1) * (F.TERMS + 1) * b, 2 * P + 1, 0, -(-count // _PARTS)
    at_trip(g, terms, width, 0.0, o[F.HERE])
    for i in range(_PARTS, 0, -1):
        if step * (i - 1) < count:
            g[o[F.PLACES] + depth] = min(step * i, count)
            at_trip(g, terms, width, g[o[F.PLACES] + depth], o[F.ROWS] + width * depth)
            depth += 1
    return depth


@kernel
def halved(g: Array, o: Counts, place: tuple[int, int, int], first: float) -> None:
    """Put the middle of a part on the stack."""
    b, width, depth = place
    g[o[F.PLACES] + depth] = math.floor(0.5 * (first + g[o[F.PLACES] + depth - 1]))
    terms = o[F.WATCHED] + width * (F.TERMS + 1) * b
    at_trip(g, terms, width, g[o[F.PLACES] + depth], o[F.ROWS] + width * depth)


@kernel
def clear_until(f: Array, q: Counts, g: Array, o: Counts, place: tuple[int, int]) -> tuple[int, float]:
    """Round trips of a block before one in which something may happen; a bound on ``zeta``.  Fills its top."""
    (b, count), law, P, width = place, q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT], q[M.COUNT], 2 * q[M.COUNT] + 1
    low, high = f[law + M.LOW] - f[law + M.ORIGIN], f[law + M.HIGH] - f[law + M.ORIGIN]
    first, size, top, depth = 0.0, 0.0, -math.inf, watched_from(g, o, b, P, count)
    while depth > 0:
        stop, row = g[o[F.PLACES] + depth - 1], o[F.ROWS] + width * (depth - 1)
        below, above = reached(g, o, (o[F.HERE], row), (b, P, f[law + M.RATE]), stop - first)
        room = min(-below - low, high - above)
        if room > F.MARGIN * (max(below, above) + (below + above)):
            size = max(size, below, above)
            for e in range(P + 1):
                top = max(top, g[o[F.HERE] + e])
            for i in range(width):
                g[o[F.HERE] + i] = g[row + i]
            depth, first = depth - 1, stop
        elif stop - first <= 1.0:
            break
        else:
            halved(g, o, (b, width, depth), first)
            depth += 1
    g[o[F.TOPS] + b] = top
    return int(first), size


@kernel
def highest(f: Array, q: Counts, g: Array, o: Counts, block: tuple[int, float]) -> float:
    """The larger of a number and the largest ``zeta`` of the round trips of a block."""
    (b, best), rate, P = block, f[q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT] + M.RATE], q[M.COUNT]
    width, last, first = 2 * P + 1, int(g[F.ZETA_DEGREE]), 0.0
    size = last + 1
    depth = watched_from(g, o, b, P, int(g[o[F.COUNTS] + b]))
    while depth > 0:
        stop, row, here = g[o[F.PLACES] + depth - 1], o[F.ROWS] + width * (depth - 1), o[F.HERE]
        for e in range(P + 1):
            best = max(best, g[here + e])
        step = stop - first
        above = reached(g, o, (here, row if step > 1.0 else here), (b, P, rate), step if step > 1.0 else 0.0)[1]
        if above > best and step > 1.0:
            halved(g, o, (b, width, depth), first)
            depth += 1
            continue
        if above > best:
            at_trip(g, o[F.ZETAS] + size * P * (F.TERMS + 1) * b, size * P, first, o[F.BACK])
            for p in range(P):
                for k in range(last + 1):
                    f[M.EXTRA + k] = g[o[F.BACK] + size * p + k]
                best = peak(f, q, M.EXTRA, last, best)
        for i in range(width):
            g[here + i] = g[row + i]
        depth, first = depth - 1, stop
    return best


@kernel
def passing(f: Array, q: Counts, g: Array, o: Counts, row: int) -> tuple[float, float]:
    """``int W^2 dt`` [m^2/s] and a bound on ``|int (z' - W + d p) dt|`` [m] of the first round trip of a block."""
    law, square, off, P, size = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT], 0.0, 0.0, q[M.COUNT], q[M.DEGREE] + 1
    n, last = int(g[F.WAVE_DEGREE]), int(g[F.ZETA_DEGREE])
    for p in range(P):
        wave, zeta, half = (
            o[F.WAVES] + (n + 1) * (P * row + p),
            o[F.ZETAS] + (last + 1) * (P * row + p),
            g[o[F.HALVES] + p],
        )
        for i in range(n + 1):
            for j in range(i & 1, n + 1, 2):
                square += half * g[wave + i] * g[wave + j] * f[q[M.PRODUCTS] + size * i + j]
        above, here = 0.0, 0.0
        for k in range(last, -1, -1):  # here is the k-th coefficient of the derivative, at 0 twice that
            term = (0.5 if k == 0 else 1.0) * here + half * f[law + M.RATE] * g[zeta + k]
            if k <= n:
                term -= half * f[M.SHARE] * g[wave + k]
            if k == 0:
                term += half * f[law + M.STRESS]
            off += abs(term)
            above, here = here, above + 2.0 * k * g[zeta + k]
    return square, 2.0 * off


@kernel
def balanced(f: Array, q: Counts, level: tuple[float, float], passed: tuple[float, float]) -> None:
    """The energy balance: the work follows from where the end begins and stops, up to the residual of its equation."""
    law, (value, rest), (square, imbalance) = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT], level, passed
    before = stored(f, q, f[law + M.ORIGIN] + (f[M.VALUE] + f[M.REST]))
    term = f[law + M.STRESS] + 0.5 * f[law + M.RATE] * (f[M.VALUE] + f[M.REST] + (value + rest))
    term *= f[M.AREA] / f[M.MOBILITY] * (value - f[M.VALUE] + (rest - f[M.REST]))
    off, total = f[M.WORK] + f[M.WORK_REST] - (before - f[M.STORED]), f[M.WORK] + term
    f[M.WORST] = max(f[M.WORST], abs(off) + f[M.AREA] / f[M.MOBILITY] * imbalance)
    f[M.WORK_REST] += (f[M.WORK] - total) + term if abs(f[M.WORK]) >= abs(term) else (term - total) + f[M.WORK]
    f[M.WORK] = total
    f[M.ENERGY] = max(f[M.ENERGY], 0.25 * f[M.IMPEDANCE] * square, abs(before), abs(before + term), abs(f[M.STORED]))


@kernel
def returned(f: Array, q: Counts, g: Array, o: Counts) -> float:
    """Put the wave that comes back after the last round trip in the place of that before the first; its size."""
    law, P, size, scale = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT], q[M.COUNT], q[M.DEGREE] + 1, 0.0
    n, last = int(g[F.WAVE_DEGREE]), int(g[F.ZETA_DEGREE])
    for p in range(P):
        at, total = q[M.OLD] + (size + M.COEF) * p, 0.0
        q[q[M.OLD_DEGREES] + p] = n
        for k in range(n + 1):
            c = (2.0 * f[M.SHARE] - 1.0) * g[o[F.LAST_WAVE] + (n + 1) * p + k]
            c -= 2.0 * f[law + M.RATE] * g[o[F.LAST_ZETA] + (last + 1) * p + k]
            if k == 0:
                c -= 2.0 * f[law + M.STRESS]
            f[at + M.COEF + k] = f[M.ECHO] * c
            total += abs(f[at + M.COEF + k])
        f[at + M.SIZE], scale = total, max(scale, total)
    return scale


@kernel
def waves_begun(q: Counts, g: Array, o: Counts, C: int) -> None:
    """Fill the first state of the waves under the force."""
    P, size, n = q[M.COUNT], q[M.DEGREE] + 1, int(g[F.WAVE_DEGREE])
    for p in range(P):
        for k in range(n + 1):
            c = g[o[F.BACK] + size * p + k]
            for i in range(C):
                c += g[o[F.LOADS] + size * (P * i + p) + k] * g[o[F.LOADED] + i]
            g[o[F.WAVES] + (n + 1) * p + k] = c


@kernel
def levels_after(
    g: Array, begins: int, clear: float, level: tuple[float, float], impulse: float
) -> tuple[float, float, float]:
    """The value, what is left of it, and the impulse after so many round trips of a block that begins there."""
    value, rest = level
    small, weight = 0.0, 1.0
    for j in range(1, F.TERMS + 1):
        weight *= (clear - (j - 1.0)) / j
        small += weight * g[begins + 2 * j]
        impulse += weight * g[begins + 2 * j + 1]
    small += rest
    whole = value + small
    return whole, (value - (whole - (whole - value))) + (small - (whole - value)), impulse


@kernel
def block_begun(g: Array, o: Counts, C: int, place: tuple[int, int, int]) -> None:
    """Fill the first state of the next block: of the waves and the force."""
    waves, many, clear = place
    at_trip(g, waves, many, float(clear), waves + many * (F.TERMS + 1))
    at_trip(g, o[F.LOADED], C, float(clear), o[F.MOVED])
    for c in range(C):
        g[o[F.LOADED] + c] = g[o[F.MOVED] + c]


@kernel
def top_of(f: Array, q: Counts, g: Array, o: Counts, b: int) -> float:
    """The largest ``zeta`` of so many blocks."""
    top = -math.inf
    for i in range(b):
        top = max(top, g[o[F.TOPS] + i])
    for i in range(b):
        if f[q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT] + M.RATE] != 0.0:
            top = highest(f, q, g, o, (i, top))
    return top


@kernel
def carried(
    f: Array, q: Counts, total: int, level: tuple[float, float], found: tuple[float, float, float, float, float]
) -> None:
    """Go on after so many round trips from the wave that is there, with ``zeta``: what they add to the sums.

    ``found``: size of the wave that comes back, largest wave, local error of a round trip, impulse, largest ``zeta``.
    """
    (scale, largest, missed, impulse, top), law, transit = found, q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT], f[M.TRANSIT]
    if f[law + M.TOUCHING] > 0.0:
        if q[M.OPEN] == 0:
            q[M.OPEN], f[M.SINCE], f[M.PEAK] = 1, transit * 2.0 * q[M.TRIP], -math.inf
        f[M.UNTIL], f[M.IMPULSE] = transit * 2.0 * (q[M.TRIP] + total), impulse
        f[M.PEAK] = max(f[M.PEAK], f[law + M.STRESS] + f[law + M.RATE] * top)
    q[M.TRIP] += total
    f[M.VALUE], f[M.REST] = level
    f[M.SCALE], f[M.HIGHEST] = max(abs(f[M.ECHO]) ** total * f[M.SCALE], scale), max(f[M.HIGHEST], largest)
    f[M.ERROR] += missed * total + f[M.LATER] * transit
    f[M.LATER] = 0.0


@kernel
def free_trips(f: Array, q: Counts, found: tuple[Array, Counts], force: Array, most: int) -> int:
    """Pass over round trips in which nothing happens, from the next one on.

    Parameters
    ----------
    f, q : ndarray
        The motion, which goes on after them; as it was if there are none.
    found : tuple of ndarray
        ``g``, where they are entered, and ``o``, the :func:`layout` of it.
    force : ndarray
        See :meth:`lure.rod.motion.exponential_force.ExponentialForces.packed`.
    most : int
        How many may be passed over.

    Returns
    -------
    int
        How many there are; 0 if there are no 16, -1 if their states are no short series.
    """
    (g, o), P, C, size = found, q[M.COUNT], int(force[F.FUNCTIONS]), q[M.DEGREE] + 1
    law, rows = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT], F.TERMS + 1
    rate, transit = f[law + M.RATE], f[M.TRANSIT]
    for p in range(P):
        at = q[M.OLD] + (size + M.COEF) * p
        g[o[F.HALVES] + p] = 0.5 * transit * (f[at + M.STOP] - f[at + M.START])
        for k in range(size):
            g[o[F.BACK] + size * p + k] = f[at + M.COEF + k] if k <= q[q[M.OLD_DEGREES] + p] else 0.0
    degree = force_columns(f, q, g, o, force)
    if degree < 0:
        return 0
    n, last = trip_degrees(f, q, g, o, degree)
    if n < 0:
        return 0
    g[F.WAVE_DEGREE], g[F.ZETA_DEGREE] = n, last
    for c in range(C):
        g[o[F.LOADED] + c] = force[int(force[F.AT_FIRST]) + c]
    if rate != 0.0:
        eliminated(g, o, P, size, rate)
    waves_begun(q, g, o, C)
    value, rest, impulse = f[M.VALUE], f[M.REST], f[M.IMPULSE] if q[M.OPEN] else 0.0
    total, b, missed, largest, reach, square, residual, closed = 0, 0, 0.0, 0.0, 0.0, 0.0, 0.0, False
    while total < most and not closed and b < F.BLOCKS:
        begins = o[F.BEGINS] + 2 * rows * b
        g[o[F.LEVELS] + 2 * b], g[o[F.LEVELS] + 2 * b + 1] = value, rest
        g[begins], g[begins + 1] = value + rest, impulse
        terms_made(f, q, g, o, (b, C, force))
        count = min(series_length(f, q, g, o), most - total)
        if count == 0:
            if b == 0:
                return -1
            break
        wave, tail = sizes_within(f, q, g, o, (b, count))
        while tail > F.TOP * wave and count >= F.LEAST:
            count //= 2
            wave, tail = sizes_within(f, q, g, o, (b, count))
        if tail > F.TOP * wave:
            break
        width = 2 * P + 1
        bends_within(g, o, (b, width, count))
        clear, size_ = clear_until(f, q, g, o, (b, count))
        missed = max(missed, 2.0 * transit * (F.LOST * wave + tail))
        largest, reach, closed = max(largest, wave), max(reach, size_), clear < count
        if clear == 0:
            break
        energy, imbalance = passing(f, q, g, o, rows * b)
        square, residual = max(square, energy), max(residual, imbalance)
        g[o[F.COUNTS] + b], total = clear, total + clear
        many, each = (n + 1) * P, (last + 1) * P
        waves, zetas = o[F.WAVES] + many * rows * b, o[F.ZETAS] + each * rows * b
        at_trip(g, waves, many, clear - 1.0, o[F.LAST_WAVE])
        at_trip(g, zetas, each, clear - 1.0, o[F.LAST_ZETA])
        value, rest, impulse = levels_after(g, begins, float(clear), (value, rest), g[begins + 1])
        b += 1
        if b < F.BLOCKS:
            block_begun(g, o, C, (waves, many, clear))
    if total < F.LEAST:
        return 0
    balanced(f, q, (value, rest), (square, total * residual * (abs(f[law + M.STRESS]) + rate * reach)))
    top = top_of(f, q, g, o, b) if f[law + M.TOUCHING] > 0.0 else 0.0
    scale = returned(f, q, g, o)
    carried(f, q, total, (value, rest), (scale, largest, missed, impulse, top))
    g[F.MISSED], g[F.FOUND] = missed, b
    return int(total)


def sampled(t: Array, edges: Array, table: Array, numbers: Array, out: Array) -> None:
    """Values of a series on the pieces of round trips of a block, at ascending instants.

    ``t``, ``out``: (n,) instants [transits], and where the values go; ``edges``: (P+1,) ends of the pieces; ``table``:
    (J, P, k) terms of the series in the number of the round trip, Chebyshev's; ``numbers``: the first round trip of the
    block, how many it has, and how many of them are there.
    """
    first, count, most = numbers[0], numbers[1], numbers[2]
    J, P, size = table.shape
    c = np.empty(size)
    for i in range(len(t)):
        trip = min(max(math.floor(0.5 * t[i]) - first, 0.0), most - 1.0)
        place, p, last = t[i] - 2.0 * (trip + first), 0, P - 1
        while p < last:
            middle = (p + last + 1) // 2
            if edges[middle] <= place:
                p = middle
            else:
                last = middle - 1
        y = trip * (2.0 / count) - 1.0
        for k in range(size):
            c[k] = table[0, p, k]
        weight, before = 1.0, y
        for j in range(1, J):
            weight, before = before, 2.0 * y * before - weight
            for k in range(size):
                c[k] += weight * table[j, p, k]
        x = local(place, edges[p], edges[p + 1])
        total, before = 0.0, 0.0
        for k in range(size - 1, 0, -1):
            total, before = 2.0 * x * total - before + c[k], total
        out[i] = x * total - before + c[0]


def recorded(
    t: Array, tables: tuple[Array, Array, Array], places: tuple[Counts, Counts, Counts], what: Counts, out: Array
) -> None:
    """Values of one of the series of a record, at instants.

    ``t``, ``out``: (n,) instants [transits], and where the values go; ``tables``, ``places``: ``low``, ``high``,
    ``coef`` and ``first``, ``start``, ``degree`` of :class:`lure.rod.motion.record.Record`; ``what``: the first round
    trip, and which series.
    """
    (low, high, coef), (first, start, degree), number, column = tables, places, what[0], what[1]
    for i in range(len(t)):
        trip = min(max(math.floor(0.5 * t[i]) - number, 0), len(first) - 2)
        place, p, last = t[i] - 2.0 * (trip + number), first[trip], first[trip + 1] - 1
        while p < last:
            middle = (p + last + 1) // 2
            if low[middle] <= place:
                p = middle
            else:
                last = middle - 1
        c = start[p]
        for k in range(column):
            c += degree[p, k] + 1
        out[i] = value(coef, c, degree[p, column], local(place, low[p], high[p]))
