"""The incoming wave of a round trip in compiled code: the echo on its pieces, and the loads on theirs."""

from __future__ import annotations

from lure.rod.motion.chebyshev import Array
from lure.rod.motion.jit import compiled, inlined
from lure.rod.motion.kernel_data import (
    BLOCK,
    COEF,
    COUNT,
    DEGREE,
    ECHO,
    EXTRA,
    INNER,
    LATER,
    MISSED,
    NODES,
    NOW,
    NOW_DEGREES,
    OLD,
    OLD_DEGREES,
    PANEL,
    ROOM,
    SCALE,
    SIZE,
    START,
    STOP,
    TRIP,
    ZERO,
    Counts,
)
from lure.rod.motion.kernel_series import fitted, short_part, trimmed

SAME = 2e-15
NO_ROOM = -1
TINY = 1e-19  # of the scale of the wave: what a long sum of echoes never shows
_LOAD = 1e-17  # of a load


@inlined
def local(x: float, low: float, high: float) -> float:
    """``x`` in ``[low, high]`` as a number in ``[-1, 1]``."""
    return min(max(((x - low) - (high - x)) / (high - low), -1.0), 1.0)


@inlined
def cut_out(f: Array, q: Counts, piece: tuple[int, int], span: tuple[float, float], out: int) -> int:
    """A piece of a wave, of a degree, between two instants, and the degree there."""
    (at, n), (a, b) = piece, span
    low, high = f[at + START], f[at + STOP]
    if a == low and b == high:
        for k in range(n + 1):
            f[out + k] = f[at + COEF + k]
        return n
    return short_part(f, q, (at + COEF, n), (local(a, low, high), local(b, low, high)), out)


@compiled
def load_part(f: Array, q: Counts, load: Array, panel: tuple[int, int], span: tuple[float, float]) -> int:
    """Fill ``EXTRA`` with a panel between two instants of its block; the degree: only as many terms as can be seen."""
    (at, whole), (start, stop) = panel, span
    low, high, n, power = load[at], load[at + 1], ZERO, 1.0
    c, bound = at + PANEL, at + PANEL + q[DEGREE] + 1
    share, tiny = (stop - start) / (high - low), _LOAD * load[at + 2]
    for k in range(1, whole + 1):
        power *= share
        if load[bound + k] * power > tiny:
            n = k
    a, b = local(start, low, high), local(stop, low, high)
    half, inner = 0.5 * (b - a), q[INNER] + n * (q[DEGREE] + 1)
    for j in range(n + 1):
        x = a + half * (f[inner + j] + 1.0)
        total, before = 0.0, 0.0
        for k in range(whole, 0, -1):
            total, before = 2.0 * x * total - before + load[c + k], total
        f[NODES + j] = x * total - before + load[c]
    fitted(f, q, n, EXTRA)
    return n


@compiled
def incoming(f: Array, q: Counts, load: Array, heads: Counts, span: float) -> int:
    """Fill the wave of the round trip; the number of pieces, or ``NO_ROOM``.  ``heads``: see :mod:`panels`."""
    size, width, count = q[DEGREE] + 1 + COEF, 2 * (q[DEGREE] + 1) + PANEL, q[COUNT]
    p, stop, offset, missed, loaded = ZERO, ZERO, 0.0, 0.0, len(load) > 0
    if loaded:
        block = q[TRIP] // BLOCK
        offset = 2.0 * (q[TRIP] - BLOCK * block)
        p, stop = heads[1 + block - heads[0]], heads[2 + block - heads[0]]
    degrees = len(heads) - len(load) // width
    scale = abs(f[ECHO]) * f[SCALE]
    tiny, i, m, old, c = TINY * scale, ZERO, ZERO, q[OLD], q[NOW]
    low = f[old + START]
    while i < count and low < span:
        high, ends = f[old + STOP], True
        if high > span - SAME:
            high = span
        if loaded:
            while p + 1 < stop and load[width * p + 1] - offset <= low + SAME:
                p += 1
            if load[width * p + 1] - offset < high - SAME:
                high, ends = load[width * p + 1] - offset, False
        if m == q[ROOM]:
            return NO_ROOM
        n = cut_out(f, q, (old, q[q[OLD_DEGREES] + i]), (low, high), c + COEF)
        scale = max(scale, f[old + SIZE])
        if loaded and load[width * p + 2] > 0.0:
            more = load_part(f, q, load, (width * p, heads[degrees + p]), (low + offset, high + offset))
            for k in range(n + 1, more + 1):
                f[c + COEF + k] = 0.0
            for k in range(more + 1):
                f[c + COEF + k] += f[EXTRA + k]
            n = max(n, more)
            missed = max(missed, load[width * p + 3] * (high - low))
        n = trimmed(f, c + COEF, n, tiny)
        sum_ = 0.0
        for k in range(n + 1):
            sum_ += abs(f[c + COEF + k])
        q[q[NOW_DEGREES] + m], f[c + START], f[c + STOP], f[c + SIZE] = n, low, high, sum_
        scale, low = max(scale, sum_), high
        m, c = m + 1, c + size
        if ends:
            i, old = i + 1, old + size
    f[SCALE], f[MISSED], f[LATER] = scale, f[LATER] + missed, 0.0
    return m
