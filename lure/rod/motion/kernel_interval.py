r"""Round trips in which nothing happens: one state each, on pieces that stay the same.

On a straight segment the coefficients of ``W`` on the pieces and ``zeta`` where the round trip begins give those of the
next.  Per piece ``zeta`` is a matrix times the coefficients, plus what the start and the constant stress of the segment
make of it; only where a piece begins depends on the pieces before.  So a round trip costs some fifty operations a
piece, and what is kept of it is its state.

A force that is a sum of ``w t^K e^{lambda t}`` is, in round trip ``n``, a sum of ``v_k(n) = n^k e^{2 lambda T n}``
times fixed functions of the time inside the round trip, which are series on the pieces.

The memory of an interval is one array ``s`` of doubles and one array ``d`` of integers, apart from those of the motion,
which go on; ``force`` holds the exponents and weights.  A table ``(k, p)`` of coefficients on pieces lies row by row.
"""

from __future__ import annotations

import math

import numpy as np

from lure.rod.motion.kernel_piece import integrated, local, relaxed
from lure.rod.motion.kernel_series import (
    AREA,
    COEF,
    COUNT,
    DEGREE,
    ECHO,
    ENERGY,
    ERROR,
    EXTRA,
    HIGH,
    HIGHEST,
    IMPEDANCE,
    IMPULSE,
    INNER,
    LATER,
    LAW,
    LOW,
    MOBILITY,
    NODES,
    OLD,
    OLD_DEGREES,
    OPEN,
    ORIGIN,
    PEAK,
    RATE,
    REST,
    SCALE,
    SEGMENT,
    SEGMENT_SIZE,
    SHARE,
    SINCE,
    SIZE,
    START,
    STOP,
    STORED,
    STRESS,
    TOUCHING,
    TRANSIT,
    TRIP,
    UNTIL,
    VALUE,
    WORK,
    WORK_REST,
    WORST,
    ZETA,
    Counts,
    fitted,
    in_loops,
    kernel,
    mean,
    peak,
    product,
    right_end,
)
from lure.rod.motion.kernel_trip import stored
from lure.rod.motion.pieces import Array, values
from lure.rod.motion.trip_matrix import Doubles, Layout, TripMatrix, trip_matrix

# s: origin, stress and rate of the segment; what of W comes back, of zeta, of the stress; share of a dashpot; T
FROM, PUSHED, STIFFNESS, BACK_W, BACK_Z, BACK_P, SHARED, TIME = range(0, 8)
# s: impulse per integral of d p; the round trip at hand, zeta there and its remainder, the impulse before it
LOADING, AT_HAND, ZETA_NOW, REST_NOW, IMPULSE_NOW = range(8, 13)
# s: largest zeta at an edge in the last round trips; local error of a round trip [m]
HIGHEST_, MISSED_ = range(13, 15)
TABLES = 15
# d: pieces, degree of W, coefficients of zeta, N + 1; whether zeta is but the integral of W to rounding
PIECES_, TOP_DEGREE, DEPTH, WIDTH, SOFT = range(0, 5)
# d: first round trip, and how many apart the states are that are kept
NUMBER, STRIDE = range(5, 7)
# d: places in s, one number each piece: ends, half widths [s]; what zeta at the start of a piece adds to its end, first
# coefficient and mean; what the stress does; where zeta begins in the round trip at hand
EDGES, HALVES, HOLD_END, HOLD_FIRST, HOLD_MEAN, LEVEL_END, LEVEL_FIRST, LEVEL_MEAN, BEGINS = range(7, 16)
# d: places in s: coefficients of zeta per coefficient of W (p, k, j), per start and stress (p, k)
OWN, HOLD, LEVEL = range(16, 19)
# d: places in s of tables (k, p): end, first coefficient, mean of zeta per coefficient of W; what the next W takes of
# the coefficient before and after; columns of the load (c, k, p); the wave at hand, and the wave that comes back
OF_END, OF_FIRST, OF_MEAN, BEFORE_, AFTER_, LOADS, WAVES, BACK = range(19, 27)
# d: place in s of the exponentials of the rates and their factors a round trip
TURNS = 27
PLACES = 28

# a state: zeta and its remainder, impulse so far, then W (k, p); a group: largest zeta at an edge, most that it exceeds
VALUE_, REMAINDER, PASSED_ON, HEAD = range(0, 4)
GROUP, GROUP_SIZE = 64, 2
WAVE_, RETURNED_, PUSH_, Z_ = range(0, 4)
LEAST = 16
MOST_PIECES_ = 64
_TOP = 1e-16  # of the wave: what its last coefficients may be
_SEEN, _RESOLVED, _LOST = 1e-17, 2e-16, 1e-17
_SMALL, _NOTHING = 1e-19, 1e-17
_MARGIN, _CANCELLED = 1e-12, 4e-16
_LOOK = 16  # groups between two looks at the residual


Memory = tuple[Array, Counts, Array, Array]


def places(d: Counts, pieces: int, width: int, columns: int, rates: int) -> int:
    """Enter the places of all tables for so many pieces, coefficients, and columns of the load; the size of ``s``."""
    at, table = TABLES, width * pieces
    d[PIECES_], d[WIDTH] = pieces, width
    for name in range(EDGES, BEGINS + 1):
        d[name], at = at, at + pieces + 1
    for name, size in ((OWN, table * width), (HOLD, table), (LEVEL, table)):
        d[name], at = at, at + size
    for name in range(OF_END, AFTER_ + 1):
        d[name], at = at, at + table
    d[LOADS], at = at, at + columns * table
    for name in (WAVES, BACK):  # with a row of zeros on either side
        d[name], at = at + pieces, at + table + 2 * pieces
    d[TURNS] = at
    return at + 4 * rates


def _matrix(s: Doubles, d: Counts) -> TripMatrix:
    """The round trip as a matrix, made once."""
    made = getattr(s, "made", None)  # memory of compiled code that is run as it stands keeps none
    if made is None:
        whole, pieces, width = np.frombuffer(s).copy(), d[PIECES_], d[WIDTH]
        table = pieces * width
        tables = {
            name: whole[d[place] : d[place] + size]
            for name, place, size in (
                ("hold_end", HOLD_END, pieces),
                ("level_end", LEVEL_END, pieces),
                ("hold_mean", HOLD_MEAN, pieces),
                ("level_mean", LEVEL_MEAN, pieces),
                ("halves", HALVES, pieces),
                ("end", OF_END, table),
                ("mean", OF_MEAN, table),
                ("own", OWN, table * width),
                ("hold", HOLD, table),
                ("level", LEVEL, table),
                ("loads", LOADS, d[WAVES] - pieces - d[LOADS]),
            )
        }
        names = ("pushed", "stiffness", "back_w", "back_z", "back_p", "shared", "time", "loading")
        numbers = dict(zip(names, s[PUSHED : LOADING + 1], strict=True))
        made = trip_matrix(
            Layout(pieces=pieces, degree=d[TOP_DEGREE], depth=d[DEPTH], width=width, numbers=numbers, tables=tables)
        )
        if isinstance(s, Doubles):
            s.made = made
    return made


@kernel
def _columns(f: Array, q: Counts, s: Array, d: Counts, force: Array) -> int:
    """Fill the columns of the load; the degree, or -1 if ``N`` is not enough."""
    pieces, size, found, c, at = d[PIECES_], d[WIDTH], 0, 0, 1
    inner = q[INNER] + q[DEGREE] * size
    for _ in range(int(force[0])):
        re, im, power = force[at], force[at + 1], int(force[at + 2])
        for k in range(power + 1):
            for part in range(1 if im == 0.0 else 2):
                largest, to = 0.0, d[LOADS] + c * size * pieces
                for p in range(pieces):
                    low, high = s[d[EDGES] + p], s[d[EDGES] + p + 1]
                    for j in range(size):
                        x = low + 0.5 * (high - low) * (f[inner + j] + 1.0) - 1.0
                        u, v, factor, power_of = 0.0, 0.0, 2.0**k, 1.0
                        for m in range(k, power + 1):
                            u += factor * power_of * force[at + 3 + 2 * m]
                            v += factor * power_of * force[at + 4 + 2 * m]
                            factor *= (m + 1.0) / (m + 1.0 - k)
                            power_of *= x
                        grown = math.exp(re * x)
                        a, b = grown * math.cos(im * x), grown * math.sin(im * x)
                        f[NODES + j] = u * a - v * b if part == 0 else -(u * b + v * a)
                    largest = max(largest, fitted(f, q, q[DEGREE], EXTRA))
                    for j in range(size):
                        s[to + j * pieces + p] = f[EXTRA + j]
                tiny = _RESOLVED * (1.0 + abs(re) + abs(im)) * largest
                n, seen = size, 0.0
                while n > 0 and seen <= tiny:
                    n -= 1
                    for p in range(pieces):
                        seen = max(seen, abs(s[to + n * pieces + p]))
                if n == q[DEGREE]:
                    return -1
                found, c = max(found, n), c + 1
        at += 3 + 2 * (power + 1)
    return int(found)


@kernel
def _seen(f: Array, q: Counts, share: float) -> int:
    """The highest degree of which a coefficient of what comes back is not below a share of the largest wave."""
    width, largest, found = q[DEGREE] + 1 + COEF, 0.0, 0
    for p in range(q[COUNT]):
        largest = max(largest, f[q[OLD] + width * p + SIZE])
    for p in range(q[COUNT]):
        k, at = q[q[OLD_DEGREES] + p], q[OLD] + width * p + COEF
        while k > found and abs(f[at + k]) <= share * largest:
            k -= 1
        found = max(found, k)
    return int(found)


@kernel
def _made(f: Array, q: Counts, s: Array, d: Counts, force: Array) -> bool:
    """Fill the tables from what the kernel has at hand; False where these pieces will not do."""
    width, nonlinearity = q[DEGREE] + 1 + COEF, q[LAW] + SEGMENT_SIZE * q[SEGMENT]
    rate, push, share, stiffest = f[nonlinearity + RATE], f[nonlinearity + STRESS], f[SHARE], 0.0
    s[FROM], s[PUSHED], s[STIFFNESS], s[SHARED] = f[nonlinearity + ORIGIN], push, rate, share
    s[BACK_W], s[TIME] = f[ECHO] * (2.0 * share - 1.0), f[TRANSIT]
    s[BACK_Z], s[BACK_P] = -2.0 * f[ECHO] * rate, -2.0 * f[ECHO] * push
    s[LOADING] = f[AREA] / f[MOBILITY] if f[nonlinearity + TOUCHING] > 0.0 else 0.0
    for p in range(d[PIECES_]):
        at = q[OLD] + width * p
        s[d[EDGES] + p], s[d[EDGES] + p + 1] = f[at + START], f[at + STOP]
        s[d[HALVES] + p] = 0.5 * f[TRANSIT] * (f[at + STOP] - f[at + START])
        stiffest = max(stiffest, rate * s[d[HALVES] + p])
    n = _columns(f, q, s, d, force)
    if n < 0:
        return False
    n = max(n, _seen(f, q, _SEEN if rate == 0.0 else _TOP))
    last = n + 1
    if rate > 0.0:
        n, last, term = n + 1, n + 2, 1.0
        for k in range(1, last + 1):
            term *= stiffest / (2.0 * k)
        while term > _SMALL and last < q[DEGREE]:
            last += 1
            term *= stiffest / (2.0 * last)
        if n > q[DEGREE] or term > _SMALL:
            return False
    d[TOP_DEGREE], d[DEPTH] = n, min(last, q[DEGREE]) + 1
    d[SOFT] = 1 if 2.0 * stiffest * stiffest <= _NOTHING else 0
    for p in range(d[PIECES_]):
        _piece(f, q, s, d, p)
        for k in range(n + 1):
            seen = k <= q[q[OLD_DEGREES] + p]
            s[d[BACK] + k * d[PIECES_] + p] = f[q[OLD] + width * p + COEF + k] if seen else 0.0
    return True


@kernel
def _piece(f: Array, q: Counts, s: Array, d: Counts, p: int) -> None:
    """What ``zeta`` is on a piece: the solutions for ``W = T_j``, for ``zeta = 1`` at its start, for the stress."""
    pieces, n, depth, half = d[PIECES_], d[TOP_DEGREE], d[DEPTH], s[d[HALVES] + p]
    stiff = s[STIFFNESS] * half
    for j in range(n + 3):
        given = j if j <= n else 0
        for k in range(given):
            f[EXTRA + k] = 0.0
        f[EXTRA + given] = half * s[SHARED]
        if j > n:
            f[EXTRA] = 0.0 if j == n + 1 else -half * s[PUSHED]
        start = 1.0 if j == n + 1 else 0.0
        if stiff > 0.0:
            m = relaxed(f, q, (EXTRA, given), (stiff, start), ZETA)
        else:
            m = integrated(f, q, (EXTRA, given), ZETA)
            f[ZETA] += start
        for k in range(m + 1, depth):
            f[ZETA + k] = 0.0
        end, average, i = right_end(f, ZETA, depth - 1), mean(f, ZETA, depth - 1), j * pieces + p
        if j > n:
            to = (HOLD if j == n + 1 else LEVEL, HOLD_END if j == n + 1 else LEVEL_END)
            for k in range(depth):
                s[d[to[0]] + p * d[WIDTH] + k] = f[ZETA + k]
            s[d[to[1]] + p], s[d[to[1] + 1] + p], s[d[to[1] + 2] + p] = end - start, f[ZETA], average
            continue
        if stiff == 0.0:  # nothing, not rounding, for odd degrees
            end = 0.0 if j & 1 else 2.0 * half * s[SHARED] / (1.0 - float(j) * float(j))
        s[d[OF_END] + i], s[d[OF_FIRST] + i], s[d[OF_MEAN] + i] = end, f[ZETA], average
        for k in range(depth):
            s[d[OWN] + (p * d[WIDTH] + k) * d[WIDTH] + j] = f[ZETA + k]
        if j < n:
            s[d[BEFORE_] + i + pieces] = s[BACK_Z] * f[ZETA + j + 1]
        if j > 1:
            s[d[AFTER_] + i - pieces] = s[BACK_Z] * f[ZETA + j - 1]


@kernel
def _turned(s: Array, d: Counts, force: Array, number: int) -> None:
    """The exponentials of a round trip, and their factors from each to the next."""
    at, turn = 1, d[TURNS]
    for _ in range(int(force[0])):
        re, im = 2.0 * force[at], 2.0 * force[at + 1]
        grown, step = math.exp(re * number), math.exp(re)
        s[turn], s[turn + 1] = grown * math.cos(im * number), grown * math.sin(im * number)
        s[turn + 2], s[turn + 3] = step * math.cos(im), step * math.sin(im)
        at, turn = at + 3 + 2 * (int(force[at + 2]) + 1), turn + 4


@in_loops(lambda *_: _loaded_in_loops)
def _loaded(s: Doubles, d: Counts, force: Array, number: int) -> None:
    """The wave of a round trip: what comes back, and its load."""
    step, whole = _matrix(s, d), np.frombuffer(s)
    back = whole[d[BACK] : d[BACK] + len(step.matrix) - 2]
    whole[d[WAVES] : d[WAVES] + len(back)] = back + step.loads(force, np.array([float(number)]))[0]


@kernel
def _loaded_in_loops(s: Array, d: Counts, force: Array, number: int) -> None:
    """The same, a number at a time, the exponentials at hand."""
    table, at, turn = (d[TOP_DEGREE] + 1) * d[PIECES_], 1, d[TURNS]
    column, more, trip = d[LOADS], d[WIDTH] * d[PIECES_], float(number)
    w, back = s[d[WAVES] : d[WAVES] + table], s[d[BACK] : d[BACK] + table]
    for i in range(table):
        w[i] = back[i]
    for _ in range(int(force[0])):
        a, b, power = s[turn], s[turn + 1], int(force[at + 2])
        other = 0 if force[at + 1] == 0.0 else more
        for _k in range(power + 1):
            real, imaginary = s[column : column + table], s[column + other : column + other + table]
            if other == 0:
                b = 0.0
            for i in range(table):
                w[i] += a * real[i] + b * imaginary[i]
            column += more + other
            a, b = a * trip, b * trip
        at, turn = at + 3 + 2 * (power + 1), turn + 4


@kernel
def _begun(s: Array, d: Counts) -> None:
    """Enter where ``zeta`` begins on each piece of the round trip at hand, and at its end."""
    pieces, table, w, e = d[PIECES_], (d[TOP_DEGREE] + 1) * d[PIECES_], d[WAVES], d[OF_END]
    value, travelled = s[ZETA_NOW], s[REST_NOW]
    for p in range(pieces):
        start = value + travelled
        s[d[BEGINS] + p] = start
        way = s[d[LEVEL_END] + p] + s[d[HOLD_END] + p] * start
        for i in range(p, table, pieces):
            way += s[e + i] * s[w + i]
        travelled += way
    s[d[BEGINS] + pieces] = value + travelled


@kernel
def _stepped(s: Array, d: Counts, force: Array) -> None:
    """The exponentials of the next round trip."""
    at, turn = 1, d[TURNS]
    for _ in range(int(force[0])):
        u, v = s[turn], s[turn + 1]
        s[turn], s[turn + 1] = u * s[turn + 2] - v * s[turn + 3], u * s[turn + 3] + v * s[turn + 2]
        at, turn = at + 3 + 2 * (int(force[at + 2]) + 1), turn + 4


@in_loops(lambda *_: _advanced_in_loops)
def _advanced(memory: Memory, m: int, keep: int) -> None:
    """Go some round trips on; enter the states before each if they are to be kept, and the largest ``zeta`` at an edge.

    As whole arrays, for code that is not compiled; compiled code does the same in loops.
    """
    s, d, force, states = memory
    step = _matrix(s, d)
    T, first, whole = len(step.matrix) - 2, int(s[AT_HAND]), np.frombuffer(s)
    W = np.empty((m + 1, T))
    W[0] = whole[d[WAVES] : d[WAVES] + T]
    loads = step.loads(force, d[NUMBER] + first + 1 + np.arange(m, dtype=float))
    value, rest, impulse = s[ZETA_NOW], s[REST_NOW], s[IMPULSE_NOW]
    heads = np.empty((m, HEAD))
    back = W[0]
    for i in range(m):
        heads[i] = value, rest, impulse
        found = step.matrix @ W[i]
        found += (value + rest) * step.held
        found += step.level
        back = found[:T]
        travel = float(found[T]) + rest
        if abs(travel - rest) <= _CANCELLED * step.ways(W[i]):
            travel = rest
        impulse += float(found[T + 1])
        total = value + travel
        undone = total - value
        value, rest = total, (value - (total - undone)) + (travel - undone)
        W[i + 1] = back + loads[i]
    whole[d[BACK] : d[BACK] + T], whole[d[WAVES] : d[WAVES] + T] = back, W[m]
    s[HIGHEST_] = float(step.starts(heads, W[:m]).max())
    if keep:
        rows = np.frombuffer(states)
        kept = np.flatnonzero((first + np.arange(m)) % d[STRIDE] == 0)
        low, size = (first + d[STRIDE] - 1) // d[STRIDE], HEAD + T
        rows[low * size : (low + len(kept)) * size] = np.hstack((heads, W[:m]))[kept].ravel()
    s[ZETA_NOW], s[REST_NOW], s[IMPULSE_NOW], s[AT_HAND] = value, rest, impulse, first + m


@kernel
def _advanced_in_loops(memory: Memory, m: int, keep: int) -> None:
    """The same, a number at a time."""
    s, d, force, states = memory
    P, T = d[PIECES_], (d[TOP_DEGREE] + 1) * d[PIECES_]
    o = d[WAVES]
    # slices, whose places are known not to be negative
    w, left, right = s[o : o + T], s[o - P : o - P + T], s[o + P : o + P + T]
    b, end, first = s[d[BACK] : d[BACK] + T], s[d[OF_END] : d[OF_END] + T], s[d[OF_FIRST] : d[OF_FIRST] + T]
    mean_, before, after = (
        s[d[OF_MEAN] : d[OF_MEAN] + T],
        s[d[BEFORE_] : d[BEFORE_] + T],
        s[d[AFTER_] : d[AFTER_] + T],
    )
    hold_end, level_end = s[d[HOLD_END] : d[HOLD_END] + P], s[d[LEVEL_END] : d[LEVEL_END] + P]
    hold_first, level_first = s[d[HOLD_FIRST] : d[HOLD_FIRST] + P], s[d[LEVEL_FIRST] : d[LEVEL_FIRST] + P]
    hold_mean, level_mean = s[d[HOLD_MEAN] : d[HOLD_MEAN] + P], s[d[LEVEL_MEAN] : d[LEVEL_MEAN] + P]
    begins, halves = s[d[BEGINS] : d[BEGINS] + P + 1], s[d[HALVES] : d[HALVES] + P]
    back, slope, constant, now = s[BACK_W], s[BACK_Z], s[BACK_P], int(s[AT_HAND])
    value, rest, impulse, highest, straight = s[ZETA_NOW], s[REST_NOW], s[IMPULSE_NOW], -math.inf, slope != 0.0
    mask, at, soft, width = d[STRIDE] - 1, (now + d[STRIDE] - 1) // d[STRIDE] * (HEAD + T), d[SOFT] != 0, d[WIDTH]
    # one rate without a power of time is the rule; its columns and exponential stay at hand
    single, more = force[0] == 1.0 and force[3] == 0.0, d[WIDTH] * P if force[0] > 0.0 and force[2] != 0.0 else 0
    real = s[d[LOADS] : d[LOADS] + T] if single else w
    imaginary = s[d[LOADS] + more : d[LOADS] + more + T] if single else w
    held, level = s[d[HOLD] : d[HOLD] + P * width], s[d[LEVEL] : d[LEVEL] + P * width]
    turn, share, constant_impulse = d[TURNS], 2.0 * s[LOADING] * s[STIFFNESS], 2.0 * s[LOADING] * s[PUSHED] * s[TIME]
    u, v = s[turn], s[turn + 1]
    for _ in range(m):
        if keep != 0 and (now & mask) == 0:
            row = states[at : at + HEAD + T]
            row[0], row[1], row[2] = value, rest, impulse
            for i in range(T):
                row[HEAD + i] = w[i]
            at += HEAD + T
        travelled, ways, total = rest, 0.0, 0.0
        if not straight:
            for i in range(T):
                part_ = end[i] * w[i]
                travelled += part_
                ways += abs(part_)
                b[i] = back * w[i]
            for p in range(P):
                travelled += level_end[p]
                b[p] += constant
            highest = max(highest, value, value + travelled)
        else:
            if soft:
                for i in range(P, T):
                    b[i] = back * w[i] + (before[i] * left[i] + after[i] * right[i])
            for p in range(P):
                start = value + travelled
                begins[p] = start
                way = level_end[p] + hold_end[p] * start
                z, average = level_first[p] + hold_first[p] * start, level_mean[p] + hold_mean[p] * start
                for i in range(p, T, P):
                    x = w[i]
                    way += end[i] * x
                    z += first[i] * x
                    average += mean_[i] * x
                travelled += way
                total += average * halves[p]
                highest = max(highest, start)
                b[p] = back * w[p] + (slope * z + constant)
                if soft:
                    b[P + p] += slope * (held[p * width + 1] * start + level[p * width + 1])
            if not soft:
                for p in range(P):
                    for k in range(1, d[TOP_DEGREE] + 1):
                        b[k * P + p] = back * w[k * P + p] + slope * _coefficient(s, d, p, k)
        if not straight and abs(travelled - rest) <= _CANCELLED * ways:  # ways there and back
            travelled = rest
        impulse += share * total + constant_impulse
        total = value + travelled
        undone = total - value
        value, rest = total, (value - (total - undone)) + (travelled - undone)
        now += 1
        if (now & 63) == 0:
            _turned(s, d, force, d[NUMBER] + now)
            u, v = s[turn], s[turn + 1]
        elif single:
            u, v = u * s[turn + 2] - v * s[turn + 3], u * s[turn + 3] + v * s[turn + 2]
        else:
            _stepped(s, d, force)
        if single:
            for i in range(T):
                w[i] = b[i] + (u * real[i] + v * imaginary[i])
        else:
            _loaded_in_loops(s, d, force, d[NUMBER] + now)
    if single:
        s[turn], s[turn + 1] = u, v
    s[ZETA_NOW], s[REST_NOW], s[IMPULSE_NOW], s[AT_HAND], s[HIGHEST_] = value, rest, impulse, now, highest


@kernel
def _coefficient(s: Array, d: Counts, p: int, k: int) -> float:
    """A coefficient of ``zeta`` on a piece of the round trip at hand."""
    pieces, own = d[PIECES_], d[OWN] + (p * d[WIDTH] + k) * d[WIDTH]
    total = s[d[HOLD] + p * d[WIDTH] + k] * s[d[BEGINS] + p] + s[d[LEVEL] + p * d[WIDTH] + k]
    for j in range(d[TOP_DEGREE] + 1):
        total += s[own + j] * s[d[WAVES] + j * pieces + p]
    return float(total)


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
    if not room > 0.0 or (rate > 0.0 and top > _TOP * wave):
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
            z = _coefficient(s, d, p, k)
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
def _reached(s: Array, d: Counts, force: Array, states: Array, trip: int) -> None:
    """A round trip at hand, counted from the first: the nearest state before it that is kept, and steps from there."""
    now, row = int(s[AT_HAND]), trip // d[STRIDE]
    if now > trip or now < row * d[STRIDE]:
        table, now = (d[TOP_DEGREE] + 1) * d[PIECES_], row * d[STRIDE]
        at = row * (HEAD + table)
        s[ZETA_NOW], s[REST_NOW], s[IMPULSE_NOW], s[AT_HAND] = states[at], states[at + 1], states[at + 2], now
        s[d[WAVES] : d[WAVES] + table] = states[at + HEAD : at + HEAD + table]
        if d[STRIDE] > 1:
            _turned(s, d, force, d[NUMBER] + now)
    if now < trip:
        _advanced((s, d, force, states), trip - now, 0)
    _begun(s, d)


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
    (f, q), (s, d, force, states) = motion, memory
    if not _made(f, q, s, d, force):
        return 0
    nonlinearity, count, known, swing = q[LAW] + SEGMENT_SIZE * q[SEGMENT], 0, 0, 0.0
    ends = (f[nonlinearity + LOW] - f[nonlinearity + ORIGIN], f[nonlinearity + HIGH] - f[nonlinearity + ORIGIN])
    energy, largest, residual, size, wave, top = 0.0, 0.0, 0.0, 0.0, 0.0, -math.inf
    s[ZETA_NOW], s[REST_NOW], s[IMPULSE_NOW] = f[VALUE], f[REST], f[IMPULSE] if q[OPEN] else 0.0
    s[AT_HAND], s[MISSED_], d[NUMBER] = 0.0, 0.0, q[TRIP]
    _turned(s, d, force, q[TRIP])
    _loaded(s, d, force, q[TRIP])
    while count < most:
        if known == 0:
            _begun(s, d)
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
        _advanced(memory, m, 1)
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
            _reached(s, d, force, states, trip)
            for p in range(d[PIECES_]):
                if _range(s, d, p)[1] > best:
                    for k in range(d[DEPTH]):
                        f[ZETA + k] = _coefficient(s, d, p, k)
                    best = peak(f, q, ZETA, d[DEPTH] - 1, best)
    return best


def sampled(memory: Memory, given: tuple[Array, Array], count: int, name: int) -> None:
    """Values at instants [transits] in so many round trips, in the second array; on an edge those from the right."""
    _sampled(memory, given, count, name)


@in_loops(lambda *_: _sampled_in_loops)
def _sampled(memory: Memory, given: tuple[Array, Array], count: int, name: int) -> None:
    """As whole arrays, for code that is not compiled."""
    s, d, force, states = memory
    (t, out), step = given, _matrix(s, d)
    T, P, n = len(step.matrix) - 2, d[PIECES_], d[TOP_DEGREE]
    trip = np.clip(np.floor(0.5 * t).astype(np.int64) - d[NUMBER], 0, count - 1)
    place = t - 2.0 * (trip + d[NUMBER])
    if d[STRIDE] == 1:
        X = np.frombuffer(states)[: (int(trip.max(initial=0)) + 1) * (HEAD + T)].reshape(-1, HEAD + T)[trip]
    else:
        X = np.empty((len(t), HEAD + T))
        for i in np.argsort(trip, kind="stable").tolist():
            _reached(s, d, force, states, int(trip[i]))
            X[i, :HEAD] = s[ZETA_NOW], s[REST_NOW], s[IMPULSE_NOW]
            X[i, HEAD:] = np.frombuffer(s)[d[WAVES] : d[WAVES] + T]
    edges, all_ = np.frombuffer(s)[d[EDGES] : d[EDGES] + P + 1], np.arange(len(t))
    piece = np.clip(np.searchsorted(edges, place, side="right") - 1, 0, P - 1)
    low, high = edges[piece], edges[piece + 1]
    x = np.clip(((place - low) - (high - place)) / (high - low), -1.0, 1.0)
    own = X[:, HEAD:].reshape(-1, n + 1, P)[all_, :, piece]
    wave = values(own, x[:, None])[:, 0]
    if name == WAVE_:
        out[:] = wave
        return
    start = step.starts(X[:, :HEAD], X[:, HEAD:])[all_, piece]
    series = np.einsum("ikj,ij->ik", step.own[piece], own) + step.hold[piece] * start[:, None] + step.constant[piece]
    zeta = values(series, x[:, None])[:, 0]
    push = s[PUSHED] + s[STIFFNESS] * zeta
    out[:] = s[FROM] + zeta if name == Z_ else push if name == PUSH_ else (2.0 * s[SHARED] - 1.0) * wave - 2.0 * push


@kernel
def _sampled_in_loops(memory: Memory, given: tuple[Array, Array], count: int, name: int) -> None:
    """The same, a number at a time."""
    s, d, force, states = memory
    (t, out), pieces, edges, depth = given, d[PIECES_], d[EDGES], d[DEPTH]
    for i in range(len(t)):
        trip = min(max(math.floor(0.5 * t[i]) - d[NUMBER], 0), count - 1)
        place, p = t[i] - 2.0 * (trip + d[NUMBER]), 0
        if trip != s[AT_HAND]:
            _reached(s, d, force, states, trip)
        while p + 1 < pieces and s[edges + p + 1] <= place:
            p += 1
        x = local(place, s[edges + p], s[edges + p + 1])
        wave, before, w = 0.0, 0.0, d[WAVES] + p
        for k in range(d[TOP_DEGREE], 0, -1):
            wave, before = 2.0 * x * wave - before + s[w + k * pieces], wave
        wave = x * wave - before + s[w]
        if name == WAVE_:
            out[i] = wave
            continue
        zeta, before = 0.0, 0.0
        for k in range(depth - 1, 0, -1):
            zeta, before = 2.0 * x * zeta - before + _coefficient(s, d, p, k), zeta
        zeta = x * zeta - before + _coefficient(s, d, p, 0)
        push = s[PUSHED] + s[STIFFNESS] * zeta
        returned = (2.0 * s[SHARED] - 1.0) * wave - 2.0 * push
        out[i] = s[FROM] + zeta if name == Z_ else push if name == PUSH_ else returned


def unrolled(memory: Memory, first: int, stop: int, out: Array) -> None:
    """The states of consecutive round trips, counted from the first, and the one after them."""
    s, d, force, states = memory
    size = HEAD + (d[TOP_DEGREE] + 1) * d[PIECES_]
    for trip in range(first, stop + 1):
        if trip < stop:
            _reached(s, d, force, states, trip)
        else:
            _advanced(memory, 1, 0)
            _begun(s, d)
        at = (trip - first) * size
        out[at], out[at + 1], out[at + 2] = s[ZETA_NOW], s[REST_NOW], s[IMPULSE_NOW]
        for i in range(size - HEAD):
            out[at + HEAD + i] = s[d[WAVES] + i]
