"""Neighbouring pieces of a wave made one, in compiled code, where one series will do."""

from __future__ import annotations

from lure.rod.motion.chebyshev import Array
from lure.rod.motion.jit import compiled
from lure.rod.motion.kernel_data import (
    COEF,
    COUNT,
    DEGREE,
    EXTRA,
    INNER,
    LATER,
    MERGED,
    NODES,
    OLD,
    OLD_DEGREES,
    PART,
    SCALE,
    SIZE,
    START,
    STOP,
    ZERO,
    Counts,
)
from lure.rod.motion.kernel_incoming import local
from lure.rod.motion.kernel_series import NOISE, fitted, left_end, part, right_end, trimmed, value

MERGE = 2e-15


@compiled
def merged(f: Array, q: Counts) -> None:
    """Merge pairs of pieces of the wave that comes next, each piece once."""
    width, degrees, count = q[DEGREE] + 1 + COEF, q[OLD_DEGREES], q[COUNT]
    tolerance, i, m = MERGE * f[SCALE], ZERO, ZERO
    while i < count:
        at, to, n, taken = q[OLD] + width * i, q[OLD] + width * m, -1, 1
        if i + 1 < count:
            n = _one(f, q, i, tolerance)
        stop = f[at + STOP]
        if n >= 0:
            stop, taken = f[at + width + STOP], 2
        else:
            n = q[degrees + i]
            for k in range(n + 1):
                f[EXTRA + k] = f[at + COEF + k]
        f[to + START], f[to + STOP], f[to + SIZE], q[degrees + m] = f[at + START], stop, 0.0, n
        for k in range(n + 1):
            f[to + COEF + k] = f[EXTRA + k]
            f[to + SIZE] += abs(f[EXTRA + k])
        i, m = i + taken, m + 1
    if m < count:
        f[LATER] += 2.0 * tolerance
    q[COUNT], q[MERGED] = m, max(8, m)


@compiled
def _one(f: Array, q: Counts, i: int, tolerance: float) -> int:
    """Pieces ``i`` and ``i + 1`` as one series in ``EXTRA``, and its degree; -1 if one will not do."""
    first = q[OLD] + (q[DEGREE] + 1 + COEF) * i
    second = first + q[DEGREE] + 1 + COEF
    n, m = q[q[OLD_DEGREES] + i], q[q[OLD_DEGREES] + i + 1]
    low, middle, high = f[first + START], f[first + STOP], f[second + STOP]
    if abs(right_end(f, first + COEF, n) - left_end(f, second + COEF, m)) > tolerance:
        return -1
    degree, cut = max(n, m), local(middle, low, high)
    while True:
        inner = q[INNER] + degree * (q[DEGREE] + 1)
        for j in range(degree + 1):
            x = low + 0.5 * (high - low) * (f[inner + j] + 1.0)
            if x < middle:
                f[NODES + j] = value(f, first + COEF, n, local(x, low, middle))
            else:
                f[NODES + j] = value(f, second + COEF, m, local(x, middle, high))
        size = fitted(f, q, degree, EXTRA)
        if _same(f, q, (degree, first, n), (-1.0, cut), tolerance) and _same(
            f, q, (degree, second, m), (cut, 1.0), tolerance
        ):
            return trimmed(f, EXTRA, degree, NOISE * size)
        if degree == q[DEGREE]:
            return -1
        degree = q[DEGREE]


@compiled
def _same(f: Array, q: Counts, pair: tuple[int, int, int], span: tuple[float, float], tolerance: float) -> bool:
    """Whether a part of the series in ``EXTRA`` is a piece, in the sum of the differences of coefficients."""
    degree, piece, n = pair
    part(f, q, (EXTRA, degree), span, PART)
    miss = 0.0
    for k in range(max(degree, n) + 1):
        ours = f[PART + k] if k <= degree else 0.0
        theirs = f[piece + COEF + k] if k <= n else 0.0
        miss += abs(ours - theirs)
    return miss <= tolerance
