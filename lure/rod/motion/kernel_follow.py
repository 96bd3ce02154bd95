"""An event-free interval: bounds that say how far nothing happens, and what the sums of the motion gain by it."""

from __future__ import annotations

import math

from lure.rod.motion.kernel_interval import advanced, begun, coefficient, loaded, reached, turned
from lure.rod.motion.kernel_series import (
    AREA,
    COEF,
    DEGREE,
    ECHO,
    ENERGY,
    ERROR,
    EXTRA,
    HIGH,
    HIGHEST,
    IMPEDANCE,
    IMPULSE,
    LATER,
    LAW,
    LOW,
    MOBILITY,
    OLD,
    OLD_DEGREES,
    OPEN,
    ORIGIN,
    PEAK,
    REST,
    SCALE,
    SEGMENT,
    SEGMENT_SIZE,
    SINCE,
    SIZE,
    STORED,
    TRANSIT,
    TRIP,
    UNTIL,
    VALUE,
    WORK,
    WORK_REST,
    WORST,
    ZETA,
    Counts,
    kernel,
    peak,
    product,
)
from lure.rod.motion.kernel_tables import (
    AT_HAND,
    BACK,
    BACK_P,
    BACK_W,
    BACK_Z,
    BEGINS,
    DEPTH,
    FROM,
    GROUP,
    GROUP_SIZE,
    HALVES,
    HIGHEST_,
    IMPULSE_NOW,
    LOADING,
    LOADS,
    MISSED_,
    NUMBER,
    PIECES_,
    PUSHED,
    REST_NOW,
    SHARED,
    STIFFNESS,
    TIME,
    TOP,
    TOP_DEGREE,
    WAVES,
    WIDTH,
    ZETA_NOW,
    Memory,
    made,
)
from lure.rod.motion.kernel_trip import stored
from lure.rod.motion.pieces import Array

LEAST = 16
_LOST, _MARGIN = 1e-17, 1e-12
_LOOK = 16  # groups between two looks at the residual


def follow(motion: tuple[Array, Counts], memory: Memory, groups: Array, most: int) -> int:
    """Go through up to so many event-free round trips; their number, 0 if there are less than 16 of them.

    Parameters
    ----------
    motion : tuple of ndarray
        ``f`` and ``q``, which go on after them; as they were if there are none.
    memory : tuple of ndarray
        ``s``, and ``d`` with the places entered; ``force``: the number of exponents of the force, then for each the
        exponent per transit (real and imaginary part), the highest power of ``t`` with it, and the weights of all
        powers; the states, to be filled.
    groups : ndarray
        To be filled: what of the peak is known.
    most : int
        Round trips in which the force keeps its formula.
    """
    (f, q), (s, d, force, _) = motion, memory
    if not made(f, q, s, d, force):
        return 0
    nonlinearity, count, known, swing = q[LAW] + SEGMENT_SIZE * q[SEGMENT], 0, 0, 0.0
    ends = (f[nonlinearity + LOW] - f[nonlinearity + ORIGIN], f[nonlinearity + HIGH] - f[nonlinearity + ORIGIN])
    energy, largest, residual, size, wave, top = 0.0, 0.0, 0.0, 0.0, 0.0, -math.inf
    s[ZETA_NOW], s[REST_NOW], s[IMPULSE_NOW] = f[VALUE], f[REST], f[IMPULSE] if q[OPEN] else 0.0
    s[AT_HAND], s[MISSED_], d[NUMBER] = 0.0, 0.0, q[TRIP]
    turned(s, d, force, q[TRIP])
    loaded(s, d, force, q[TRIP])
    while count < most:
        if known == 0:
            begun(s, d)
            known, swing, wave = _free(s, d, force, q[TRIP] + count, ends)
            if known == 0:
                break
            largest, size = max(largest, wave), max(size, abs(s[ZETA_NOW]) + swing)
        group = GROUP_SIZE * (count // GROUP)
        if count % GROUP == 0:
            energy = max(energy, _energy(f, q, s, d))
            if count % (_LOOK * GROUP) == 0:
                residual = max(residual, _residual(s, d))
            groups[group], groups[group + 1] = -math.inf, 0.0
        m = min(known, GROUP - count % GROUP, most - count)
        advanced(memory, m, 1)
        groups[group], groups[group + 1] = max(groups[group], s[HIGHEST_]), max(groups[group + 1], swing)
        top = max(top, s[HIGHEST_])
        known, count = known - m, count + m
    if count < LEAST:
        return 0
    push = abs(s[PUSHED]) + s[STIFFNESS] * size
    _balanced(f, q, s, push * count * f[AREA] / f[MOBILITY] * residual, energy)
    _carried(motion, (s, d), count, largest)
    if s[LOADING] > 0.0:
        f[PEAK] = max(f[PEAK], s[PUSHED] + s[STIFFNESS] * _peak(motion, memory, groups, (count, top)))
    return count


@kernel
def _range(s: Array, d: Counts, p: int) -> tuple[float, float, float]:
    """Bounds on ``zeta`` on a piece, and on the wave: where the slope keeps its sign they are its ends."""
    pieces, start, stop = d[PIECES_], s[d[BEGINS] + p], s[d[BEGINS] + p + 1]
    first, others = s[d[WAVES] + p], 0.0
    for k in range(1, d[TOP_DEGREE] + 1):
        others += abs(s[d[WAVES] + k * pieces + p])
    slope = s[SHARED] * first - s[PUSHED] - s[STIFFNESS] * start
    swing = 2.0 * s[d[HALVES] + p] * (abs(slope) + s[SHARED] * others)
    if abs(slope) >= s[SHARED] * others + s[STIFFNESS] * swing:
        return min(start, stop), max(start, stop), abs(first) + others
    return start - swing, start + swing, abs(first) + others


@kernel
def _free(s: Array, d: Counts, force: Array, number: int, ends: tuple[float, float]) -> tuple[int, float, float]:
    """Round trips from this one on that are certainly free of events, at most 64; the swing in them, largest wave."""
    low, high, wave, rate, top = math.inf, -math.inf, 0.0, s[STIFFNESS], 0.0
    last = d[WAVES] + d[TOP_DEGREE] * d[PIECES_]
    for p in range(d[PIECES_]):
        down, up, size = _range(s, d, p)
        low, high, wave = min(low, down), max(high, up), max(wave, size)
        top = max(top, abs(s[last + p]))
    size = max(abs(low), abs(high))
    room = min(low - ends[0], ends[1] - high) - _MARGIN * (size + (high - low))
    if not room > 0.0 or (rate > 0.0 and top > TOP * wave):
        return 0, 0.0, wave
    load = _most_load(s, d, force, number)
    s[MISSED_] = max(s[MISSED_], 2.0 * s[TIME] * (_LOST * load + (top if rate > 0.0 else 0.0)))
    m, swing, grown = 1, high - low, wave
    while m < GROUP:
        grown = abs(s[BACK_W]) * grown + abs(s[BACK_Z]) * size + abs(s[BACK_P]) + load
        way = 2.0 * s[TIME] * (s[SHARED] * grown + abs(s[PUSHED]) + rate * size)
        size, room = size + way, room - way
        if not room > 0.0:
            break
        m, swing = m + 1, max(swing, way)
    return m, swing, wave


@kernel
def _most_load(s: Array, d: Counts, force: Array, number: int) -> float:
    """A bound on the load in this round trip and the next 64."""
    at, column, pieces, total = 1, d[LOADS], d[PIECES_], 0.0
    for _ in range(int(force[0])):
        re = 2.0 * force[at]
        size = math.exp(max(re * number, re * (number + GROUP)))
        for _k in range(int(force[at + 2]) + 1):
            for _part in range(1 if force[at + 1] == 0.0 else 2):
                most = 0.0
                for p in range(pieces):
                    here = 0.0
                    for k in range(d[TOP_DEGREE] + 1):
                        here += abs(s[column + k * pieces + p])
                    most = max(most, here)
                total += size * most
                column += d[WIDTH] * pieces
            size *= number + GROUP
        at += 3 + 2 * (int(force[at + 2]) + 1)
    return float(total)


@kernel
def _residual(s: Array, d: Counts) -> float:
    """A bound [m] on ``|int (z' - W + d p) dt|`` over parts of the round trip at hand: that of the series of ``z``."""
    pieces, depth, total = d[PIECES_], d[DEPTH], 0.0
    for p in range(pieces):
        half, above, here = s[d[HALVES] + p], 0.0, 0.0
        stiff = half * s[STIFFNESS]
        for k in range(depth - 1, -1, -1):  # with the coefficient k + 1 of the derivative above, k here
            z = coefficient(s, d, p, k)
            off = stiff * z + (here if k > 0 else 0.5 * here)
            if k <= d[TOP_DEGREE]:
                off -= half * s[SHARED] * s[d[WAVES] + k * pieces + p]
            total += abs(off + half * s[PUSHED] if k == 0 else off)
            above, here = here, above + 2.0 * k * z
    return 2.0 * float(total)


@kernel
def _energy(f: Array, q: Counts, s: Array, d: Counts) -> float:
    """``Z/4 int W^2 dt`` over the round trip at hand [J]."""
    pieces, n, total = d[PIECES_], d[TOP_DEGREE], 0.0
    for p in range(pieces):
        for k in range(n + 1):
            f[EXTRA + k] = s[d[WAVES] + k * pieces + p]
        total += 0.25 * f[IMPEDANCE] * s[d[HALVES] + p] * product(f, q, (EXTRA, n), (EXTRA, n))
    return float(total)


@kernel
def _balanced(f: Array, q: Counts, s: Array, imbalance: float, energy: float) -> None:
    """The energy balance: the work follows from where the end begins and stops, up to the residual of its equation."""
    begun, first, last = f[VALUE], f[VALUE] + f[REST], s[ZETA_NOW] + s[REST_NOW]
    before, after = stored(f, q, s[FROM] + first), stored(f, q, s[FROM] + last)
    term = s[PUSHED] + 0.5 * s[STIFFNESS] * (first + last)
    term *= f[AREA] / f[MOBILITY] * (s[ZETA_NOW] - begun + (s[REST_NOW] - f[REST]))
    off, total = f[WORK] + f[WORK_REST] - (before - f[STORED]), f[WORK] + term
    f[WORST] = max(f[WORST], abs(off) + imbalance)
    f[WORK_REST] += (f[WORK] - total) + term if abs(f[WORK]) >= abs(term) else (term - total) + f[WORK]
    f[WORK] = total
    f[ENERGY] = max(f[ENERGY], energy, abs(before), abs(after), abs(f[STORED]))


@kernel
def _carried(motion: tuple[Array, Counts], tables: tuple[Array, Counts], count: int, largest: float) -> None:
    """Put the motion after the interval in the place of that before it, and enter what it adds to the sums."""
    (f, q), (s, d) = motion, tables
    pieces, n, width, scale, top = d[PIECES_], d[TOP_DEGREE], q[DEGREE] + 1 + COEF, 0.0, 0.0
    for p in range(pieces):
        at = q[OLD] + width * p
        q[q[OLD_DEGREES] + p], f[at + SIZE] = n, 0.0
        for k in range(n + 1):
            f[at + COEF + k] = s[d[BACK] + k * pieces + p]
            f[at + SIZE] += abs(f[at + COEF + k])
        scale, top = max(scale, f[at + SIZE]), max(top, abs(f[at + COEF + n]))
    f[VALUE], f[REST] = s[ZETA_NOW], s[REST_NOW]
    if s[LOADING] > 0.0:
        if q[OPEN] == 0:
            q[OPEN], f[SINCE], f[PEAK] = 1, f[TRANSIT] * 2.0 * q[TRIP], -math.inf
        f[UNTIL], f[IMPULSE] = f[TRANSIT] * 2.0 * (q[TRIP] + count), s[IMPULSE_NOW]
    q[TRIP] += count
    f[SCALE] = max(abs(f[ECHO]) ** count * f[SCALE], scale)
    f[HIGHEST] = max(f[HIGHEST], largest)
    f[ERROR] += s[MISSED_] * count + f[LATER] * f[TRANSIT]
    f[LATER] = 0.0


@kernel
def _peak(motion: tuple[Array, Counts], memory: Memory, groups: Array, known: tuple[int, float]) -> float:
    """The largest ``zeta`` of so many round trips, given the largest at the ends of the pieces."""
    (f, q), (s, d, force, states), (count, best) = motion, memory, known
    if s[STIFFNESS] == 0.0:
        return best
    for g in range(0, count, GROUP):
        at = GROUP_SIZE * (g // GROUP)
        if groups[at] + groups[at + 1] <= best:
            continue
        for trip in range(g, min(g + GROUP, count)):
            reached(s, d, force, states, trip)
            for p in range(d[PIECES_]):
                if _range(s, d, p)[1] > best:
                    for k in range(d[DEPTH]):
                        f[ZETA + k] = coefficient(s, d, p, k)
                    best = peak(f, q, ZETA, d[DEPTH] - 1, best)
    return best
