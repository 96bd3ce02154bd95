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

from lure.rod.motion.kernel_piece import integrated, relaxed
from lure.rod.motion.kernel_series import (
    AREA,
    COEF,
    COUNT,
    DEGREE,
    ECHO,
    EXTRA,
    INNER,
    LAW,
    MOBILITY,
    NODES,
    OLD,
    OLD_DEGREES,
    ORIGIN,
    RATE,
    SEGMENT,
    SEGMENT_SIZE,
    SHARE,
    SIZE,
    START,
    STOP,
    STRESS,
    TOUCHING,
    TRANSIT,
    ZETA,
    Counts,
    fitted,
    kernel,
    mean,
    right_end,
)
from lure.rod.motion.pieces import Array

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
HEAD = 3
GROUP, GROUP_SIZE = 64, 2
TOP = 1e-16  # of the wave: what its last coefficients may be
_SEEN, _RESOLVED = 1e-17, 2e-16
_SMALL, _NOTHING = 1e-19, 1e-17


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
def made(f: Array, q: Counts, s: Array, d: Counts, force: Array) -> bool:
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
    n = max(n, _seen(f, q, _SEEN if rate == 0.0 else TOP))
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
