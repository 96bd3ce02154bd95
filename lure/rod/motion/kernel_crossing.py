"""The first crossing and the largest value of a series in compiled code; the rules are those of ``crossing.py``."""

from __future__ import annotations

from lure.rod.motion.chebyshev import Array
from lure.rod.motion.jit import compiled
from lure.rod.motion.kernel_data import PART, SLOPE, STACK, Counts
from lure.rod.motion.kernel_series import differentiated, direction, left_end, part, right_end, value, variation

NEVER, UNDECIDED = 2.0, 3.0
_MOST_INTERVALS = 20_000
_THINNEST = 1e-14
_FLAT = 0.25
_MOST_HALVES = 400
_LEVEL = 4e-15


@compiled
def first_rise(f: Array, q: Counts, c: int, n: int, tolerance: float) -> float:
    """The zero before the first excursion above ``tolerance``; ``NEVER``, or ``UNDECIDED`` after 20000 intervals."""
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


@compiled
def _halved(f: Array, depth: int, low: float, high: float) -> None:
    """Both halves on the stack, the first on top."""
    at, middle = STACK + 2 * depth, 0.5 * (low + high)
    f[at], f[at + 1], f[at + 2], f[at + 3] = middle, high, low, middle


@compiled
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


@compiled
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
