r"""The terms of Newton's series of round trips in which nothing happens, in loops, for compiled code.

The state of a round trip gives that of the next, ``y_{n+1} = y_n + D y_n``, and consecutive ones are Newton's series
``y_n = sum_j C(n, j) D^j y_0``: see :mod:`lure.rod.motion.blocks`.  Here no matrix is made.  A term ``D^j y_0`` is a
round trip of the linear problem itself: its wave on the pieces and ``zeta`` at the start give ``zeta`` on the pieces,
piece after piece, by the elimination of :mod:`lure.rod.motion.kernel_piece`, and from that the next term follows.

All is in one array ``g`` of doubles, at places that ``o`` tells.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from lure.rod.motion import kernel_series as M
from lure.rod.motion.kernel_series import Counts, fitted, kernel, mean
from lure.rod.motion.pieces import Array

TERMS = 32
LENGTHS = tuple(16 * round(2 ** (k / 2)) for k in range(4, 19))
LEFT_OUT = 1e-17  # of the wave: what the series leaves out
CANCELLED = 8.0  # what its terms may exceed the wave by
WAY_BACK = 4e-16  # of all ways there and back in free flight
FIRST = 64  # round trips made by doubling
TOP = 4e-16  # of the wave: what its last coefficients may be
SEEN, SMALL = 1e-17, 1e-19
TINY = 5e-16  # of a function of the force, and of its rate: rounding reaches 2.2e-16 in the last coefficient
LEAST = 16  # round trips
MOST_FREE = 64  # pieces
LOST, MARGIN = 1e-17, 1e-12
SLOW = 0.99
BLOCKS = 4  # for which there is room
DEEPEST = 48

# g: what was found: local error of a round trip [m], blocks, degrees of W and zeta
MISSED, FOUND, WAVE_DEGREE, ZETA_DEGREE = range(4)
# places of it in g, for each block: its round trips, zeta with its rest, the terms of zeta and of the impulse
# with which round trips begin, of W and of zeta on the pieces
COUNTS, LEVELS, BEGINS, WAVES, ZETAS = range(5)
# the terms of what is watched: zeta at the edges, mean slopes without the coefficients of W beyond the first; bounds
WATCHED, OTHERS, BENDS, TOPS = range(5, 9)
# half widths of the pieces [s]; wave that comes back; functions of the force on the pieces; elimination
HALVES, BACK, LOADS, PIVOTS, UNITS, FALLS = range(9, 15)
# how much of each function of the force is in the terms, and in the next round trip; sizes of terms; a column
LOADED, MOVED, SIZES, COLUMN = range(15, 19)
# parts of a block still to be looked at, what is watched at their ends and here; the last round trip
PLACES, ROWS, HERE, LAST_WAVE, LAST_ZETA, WHOLE = range(19, 25)
# the force: exponents and functions, places of weights, of what there is of each function at first, of what turns it;
# where it holds [transits], the round trip from which there is another, and before which intervals end
RATES, FUNCTIONS, WEIGHTS, AT_FIRST, TURN, FROM, UP_TO, NEXT, MOST, HEAD = range(10)


@lru_cache(maxsize=16)
def layout(P: int, C: int, size: int) -> Counts:
    """Places in ``g`` for so many pieces, functions of the force and coefficients, and how long it is."""
    rows, w, b = TERMS + 1, 2 * P + 1, BLOCKS
    blocks = (b, 2 * b, 2 * rows * b, rows * P * size * b, rows * P * size * b, rows * w * b, P * b, w * b, b)
    once = (P, P * size, C * P * size, *(P * (size + 1),) * 3)
    rest = (rows * C, C, 2 * rows, size + 2, DEEPEST, DEEPEST * w, w, P * size, P * size)
    return np.cumsum((ZETA_DEGREE + 1, *blocks, *once, *rest))


@kernel
def force_columns(f: Array, q: Counts, g: Array, o: Counts, force: Array) -> int:
    """Fill the functions of the force, as :meth:`.ExponentialForce.columns`; their degree, -1 if it is not enough."""
    least = SMALL * largest_row(g, o[BACK], q[M.COUNT], q[M.DEGREE] + 1)
    C, P, N, inner = int(force[FUNCTIONS]), q[M.COUNT], q[M.DEGREE], q[M.INNER] + q[M.DEGREE] * (q[M.DEGREE] + 1)
    fastest, n, i, at, late = 0.0, 0, 0, int(force[WEIGHTS]), 2.0 * q[M.TRIP]
    for r in range(HEAD, HEAD + 3 * int(force[RATES]), 3):
        fastest = max(fastest, math.hypot(force[r], force[r + 1]))
    for r in range(HEAD, HEAD + 3 * int(force[RATES]), 3):
        b, many = force[r + 1], int(force[r + 2])
        parts, turned = 1 if b == 0.0 else 2, (late, math.cos(late * b), math.sin(late * b))
        for k in range(many):
            largest = (0.0, 0.0)
            for p in range(P):
                piece, to = q[M.OLD] + (N + 1 + M.COEF) * p, o[LOADS] + (N + 1) * (P * i + p)
                low, half = f[piece + M.START], 0.5 * (f[piece + M.STOP] - f[piece + M.START])
                for j in range(N + 1):
                    x = low + half * (f[inner + j] + 1.0) - 1.0
                    real, imaginary = force_pair(force, (r, at, k), x, turned)
                    largest = max(largest[0], abs(real)), max(largest[1], abs(imaginary))
                    f[M.NODES + j], f[M.PART + j] = real, imaginary
                for part in range(parts):
                    if part == 1:
                        for j in range(N + 1):
                            f[M.NODES + j] = f[M.PART + j]
                    fitted(f, q, N, M.EXTRA)
                    for j in range(N + 1):
                        g[to + (N + 1) * P * part + j] = f[M.EXTRA + j]
            for part in range(parts):
                tiny = max(least, TINY * (1.0 + fastest) * largest[part])
                for c in range((N + 1) * P):
                    if c % (N + 1) > n and abs(g[o[LOADS] + (N + 1) * P * (i + part) + c]) > tiny:
                        n = c % (N + 1)
            i += parts
        at += 2 * many
    return -1 if C > 0 and n == N else n


@kernel
def force_pair(
    force: Array, place: tuple[int, int, int], x: float, turned: tuple[float, float, float]
) -> tuple[float, float]:
    """Real and imaginary part of ``m^k e^{2 rate m}`` times what is there at a time ``x`` and ``late`` after it.

    ``place``: of the exponent and its weights, and the power; ``turned``: ``late`` and cosine and sine of its angle.
    """
    (r, at, k), (late, cosine, sine), many = place, turned, int(force[place[0] + 2])
    real, imaginary, share, power = 0.0, 0.0, 2.0**k, 1.0
    for K in range(k, many):  # 2^k C(K, k) w_K (x + late)^(K - k)
        real += share * power * force[at + 2 * K]
        imaginary += share * power * force[at + 2 * K + 1]
        power *= x + late
        share *= (K + 1.0) / (K + 1.0 - k)
    grown, c, s = math.exp(force[r] * x + late * force[r]), math.cos(force[r + 1] * x), math.sin(force[r + 1] * x)
    c, s = grown * (c * cosine - s * sine), grown * (s * cosine + c * sine)
    return c * real - s * imaginary, -(s * real + c * imaginary)


@kernel
def force_at(force: Array, x: float, late: float) -> float:
    """What the force adds to the wave, ``late`` after a time ``x`` since it left ``x = 0``."""
    total, at = 0.0, int(force[WEIGHTS])
    for r in range(HEAD, HEAD + 3 * int(force[RATES]), 3):
        angle = late * force[r + 1]
        total += force_pair(force, (r, at, 0), x, (late, math.cos(angle), math.sin(angle)))[0]
        at += 2 * int(force[r + 2])
    return total


@kernel
def likely_to_end(f: Array, q: Counts) -> bool:
    """Whether an end is likely to be passed within 16 round trips, by the wave that comes back: then none is tried.

    What each round trip adds is taken for the same in all of them where that is nearly so, else for one of them.
    """
    law, zeta = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT], f[M.VALUE]
    low, high, place = zeta, zeta, zeta
    for p in range(q[M.COUNT]):
        at = q[M.OLD] + (q[M.DEGREE] + 1 + M.COEF) * p
        speed = mean(f, at + M.COEF, q[q[M.OLD_DEGREES] + p])
        place += f[M.TRANSIT] * (f[at + M.STOP] - f[at + M.START]) * (f[M.SHARE] * speed - f[law + M.STRESS])
        low, high = min(low, place), max(high, place)
    slow = f[M.ECHO] * (2.0 * f[M.SHARE] - 1.0) > SLOW and f[law + M.RATE] * f[M.TRANSIT] < 1.0 - SLOW
    last = LEAST * (place - zeta) if slow else 0.0
    origin = f[law + M.ORIGIN]
    return bool(low + min(last, 0.0) < f[law + M.LOW] - origin or high + max(last, 0.0) > f[law + M.HIGH] - origin)


@kernel
def trip_degrees(f: Array, q: Counts, g: Array, o: Counts, least: int) -> tuple[int, int]:
    """Degrees of ``W``, at least that of the force, and of ``zeta`` on the pieces; -1 if these pieces will not do."""
    P, most, rate = q[M.COUNT], q[M.DEGREE], f[q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT] + M.RATE]
    tiny, n = (SEEN if rate == 0.0 else TOP) * largest_row(g, o[BACK], P, most + 1), most
    while n > least:
        size = 0.0
        for p in range(P):
            size = max(size, abs(g[o[BACK] + (most + 1) * p + n]))
        if size > tiny:
            break
        n -= 1
    if rate == 0.0:
        return n, min(n + 1, most)
    half, k, term = 0.0, 0, 1.0
    for p in range(P):
        half = max(half, 0.5 * rate * g[o[HALVES] + p])
    while k < n + 2 or (term > SMALL and k < most):
        k += 1
        term *= half / k
    if n + 1 > most or term > SMALL:
        return -1, -1
    return n + 1, min(k, most)


@kernel
def largest_row(g: Array, c: int, count: int, size: int) -> float:
    """The largest sum of ``|c|`` of so many rows."""
    largest = 0.0
    for p in range(count):
        total = 0.0
        for k in range(size):
            total += abs(g[c + size * p + k])
        largest = max(largest, total)
    return largest


@kernel
def eliminated(g: Array, o: Counts, P: int, size: int, rate: float) -> None:
    """Fill inverse pivots, the solution without load, 1 at -1, and how it falls from there, also to the right end.

    See :func:`lure.rod.motion.kernel_piece.relaxed`.  What falls solves ``zeta' + s zeta = -s`` from 0, so that nothing
    is lost where it is little.
    """
    last = int(g[ZETA_DEGREE])
    for p in range(P):
        s, at = rate * g[o[HALVES] + p], (size + 1) * p
        pivots, unit, fall = o[PIVOTS] + at, o[UNITS] + at, o[FALLS] + at
        for k in range(last, 0, -1):
            g[pivots + k] = 1.0 / (2.0 * k + (s * (k + 1.0) / k if k == last else s * s * g[pivots + k + 1]))
        one, free, sign, total, moved = 2.0, 0.0, -1.0, 1.0, 0.0
        for k in range(1, last + 1):
            right = -2.0 * s if k == 1 else 0.0
            one, free = -s * one * g[pivots + k], (right - s * free) * g[pivots + k]
            g[unit + k], g[fall + k] = one, free
            total += sign * one
            moved += sign * free
            sign = -sign
        g[unit], g[fall] = 1.0 / total, -moved / total
        end = g[fall]
        for k in range(1, last + 1):
            g[fall + k] += g[fall] * g[unit + k]
            end += g[fall + k]
            g[unit + k] *= g[unit]
        g[fall + last + 1] = end


@kernel
def solved_trip(f: Array, q: Counts, g: Array, o: Counts, row: int) -> tuple[float, float]:
    """Fill ``zeta`` on the pieces and what is watched for a term; the way and the integral of ``zeta``.

    ``row`` counts the terms of all blocks; only the first of a block has the constant in it.  In flight a way that is
    rounding beside what goes there and back is none.
    """
    law, P, size = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT], q[M.COUNT], q[M.DEGREE] + 1
    n, last, rate, share = int(g[WAVE_DEGREE]), int(g[ZETA_DEGREE]), f[law + M.RATE], f[M.SHARE]
    push = f[law + M.STRESS] if row % (TERMS + 1) == 0 else 0.0
    watched, right, way, area, both = o[WATCHED] + (2 * P + 1) * row, o[COLUMN], 0.0, 0.0, 0.0
    g[watched] = g[o[BEGINS] + 2 * row]
    for p in range(P):
        wave, zeta = o[WAVES] + (n + 1) * (P * row + p), o[ZETAS] + (last + 1) * (P * row + p)
        half, begin = g[o[HALVES] + p], g[watched + p]
        s, load, sign, total = rate * half, half * share, -1.0, 0.0
        first = load * g[wave] - half * push
        if rate == 0.0:
            for k in range(1, last + 1):
                z = 2.0 * first if k == 1 else load * g[wave + k - 1]
                if k + 1 <= n:
                    z -= load * g[wave + k + 1]
                z /= 2.0 * k
                total += sign * z
                sign = -sign
                g[zeta + k] = z
            g[zeta], end = begin - total, 2.0 * first
            both += 2.0 * (abs(load * g[wave]) + abs(half * push))
            for k in range(2, n + 1, 2):
                term = 2.0 * load * g[wave + k] / (1.0 - float(k) * float(k))
                end, both = end + term, both + abs(term)
        else:
            pivots, unit, fall, z = (
                o[PIVOTS] + (size + 1) * p,
                o[UNITS] + (size + 1) * p,
                o[FALLS] + (size + 1) * p,
                0.0,
            )
            for k in range(last, 0, -1):
                z = s * g[pivots + k + 1] * z if k < last else (k + 1.0) / k * load * g[wave + k] if k <= n else 0.0
                if k - 1 <= n:
                    z += 2.0 * first if k == 1 else load * g[wave + k - 1]
                if k + 1 <= n:
                    z -= load * g[wave + k + 1]
                g[right + k] = z
            free = 0.0
            for k in range(1, last + 1):
                free = (g[right + k] - s * free) * g[pivots + k]
                g[right + k] = free
                total += sign * free
                sign = -sign
            end = -total * g[unit]
            g[zeta] = end + begin * g[fall] + begin
            for k in range(1, last + 1):
                z = g[right + k] - total * g[unit + k]
                g[zeta + k] = z + begin * g[fall + k]
                end += z
            end += begin * g[fall + last + 1]
        for k in range(0, last + 1, 2):
            area += half * f[q[M.PRODUCTS] + k] * g[zeta + k]
        g[watched + P + 1 + p] = share * g[wave] - rate * begin - push
        g[watched + p + 1] = begin + end
        way += end
    return 0.0 if abs(way) <= WAY_BACK * both else way, area


@kernel
def next_term(f: Array, q: Counts, g: Array, o: Counts, place: tuple[int, int]) -> None:
    """Fill the wave of the next term: what comes back of ``W`` and ``zeta``, and what the force adds."""
    (row, C), P, size, n = place, q[M.COUNT], q[M.DEGREE] + 1, int(g[WAVE_DEGREE])
    law, last = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT], int(g[ZETA_DEGREE])
    back, echoed = f[M.ECHO] * (2.0 * f[M.SHARE] - 1.0) - 1.0, -2.0 * f[M.ECHO] * f[law + M.RATE]
    constant = -2.0 * f[M.ECHO] * f[law + M.STRESS] if row % (TERMS + 1) == 0 else 0.0
    for p in range(P):
        wave, zeta = o[WAVES] + (n + 1) * (P * row + p), o[ZETAS] + (last + 1) * (P * row + p)
        after = wave + (n + 1) * P
        for k in range(n + 1):
            g[after + k] = back * g[wave + k] + echoed * g[zeta + k]
        g[after] += constant
        for i in range(C):
            load, moved = o[LOADS] + size * (P * i + p), g[o[MOVED] + i]
            for k in range(n + 1):
                g[after + k] += moved * g[load + k]


@kernel
def series_length(f: Array, q: Counts, g: Array, o: Counts) -> int:
    """:meth:`lure.rod.motion.blocks.Steps.length`, from the sizes of the terms."""
    law, sizes = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT], o[SIZES]
    size = max(g[sizes], abs(f[law + M.STRESS]) + f[law + M.RATE] * g[sizes + 1], 1e-300)
    swing = max(2.0 * f[M.TRANSIT] * f[M.SHARE] * size, 5e-324)
    reach, found = CANCELLED * (g[sizes + 1] + FIRST * swing), 0
    left = max(g[sizes + 2 * TERMS] / size, g[sizes + 2 * TERMS + 1] / swing)
    for length in LENGTHS:
        wave, level, weight = 0.0, 0.0, 1.0
        for j in range(TERMS + 1):
            if j > 0:
                weight *= (length - (j - 1.0)) / j
            wave += weight * g[sizes + 2 * j]
            level += weight * g[sizes + 2 * j + 1]
        if not (wave <= CANCELLED * size and level <= reach and weight * left <= LEFT_OUT):
            break
        found = length
    return found


@kernel
def at_trip(g: Array, terms: int, width: int, n: float, out: int) -> None:
    """Values of the series of so many numbers in round trip ``n``."""
    weight = 1.0
    for i in range(width):
        g[out + i] = g[terms + i]
    for j in range(1, TERMS + 1):
        weight *= (n - (j - 1.0)) / j
        if weight == 0.0:
            break
        for i in range(width):
            g[out + i] += weight * g[terms + width * j + i]


@kernel
def terms_made(f: Array, q: Counts, g: Array, o: Counts, turns: tuple[int, int, Array]) -> None:
    """Fill the terms of a block from the first of them."""
    b, C, force = turns
    law, size, turn = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT], q[M.COUNT] * (int(g[WAVE_DEGREE]) + 1), int(force[TURN])
    loading, rate = f[M.AREA] / f[M.MOBILITY] if f[law + M.TOUCHING] > 0.0 else 0.0, f[law + M.RATE]
    for j in range(TERMS + 1):
        row, loaded = (TERMS + 1) * b + j, o[LOADED] + C * j
        for c in range(C):
            gained = 0.0
            for i in range(C):
                gained += force[turn + C * c + i] * g[loaded + i]
            g[o[MOVED] + c] = g[loaded + c] + gained
            if j < TERMS:
                g[loaded + C + c] = gained
        g[o[SIZES] + 2 * j] = 0.0
        for k in range(size):
            g[o[SIZES] + 2 * j] += abs(g[o[WAVES] + size * row + k])
        g[o[SIZES] + 2 * j + 1] = abs(g[o[BEGINS] + 2 * row])
        way, area = solved_trip(f, q, g, o, row)
        if j < TERMS:
            gained = loading * rate * area
            if j == 0:
                gained += 2.0 * loading * f[law + M.STRESS] * f[M.TRANSIT]
            g[o[BEGINS] + 2 * row + 2], g[o[BEGINS] + 2 * row + 3] = way, gained
            next_term(f, q, g, o, (row, C))
