"""One piece of the motion in compiled code: solved on a segment of the law, and tested for its end."""

from __future__ import annotations

import math

from lure.rod.motion.chebyshev import Array
from lure.rod.motion.jit import compiled, inlined
from lure.rod.motion.kernel_crossing import NEVER, UNDECIDED, first_rise
from lure.rod.motion.kernel_data import (
    BEGUN,
    COEF,
    DEGREE,
    EXTRA,
    HIGH,
    LARGEST,
    LAW,
    LOW,
    NOW,
    ORIGIN,
    PUSH,
    RATE,
    REST,
    SEGMENT,
    SEGMENT_SIZE,
    SHARE,
    SIZE,
    START,
    STOP,
    STRESS,
    TOLERANCE,
    TRANSIT,
    TRAVEL,
    TRAVELLED,
    VALUE,
    WAVE,
    ZETA,
    Counts,
)
from lure.rod.motion.kernel_incoming import TINY
from lure.rod.motion.kernel_series import right_end, trimmed, variation
from lure.rod.motion.kernel_solve import integrated, relaxed

GRAZE, RESOLVED = 8e-15, 3e-15
_ULPS = 2e-15


@compiled
def begun(f: Array, q: Counts, pieces: int, i: int, low: float) -> None:
    """Begin an arc: the sizes on which its tolerances depend, over the pieces ahead."""
    law, width = q[LAW] + SEGMENT_SIZE * q[SEGMENT], q[DEGREE] + 1 + COEF
    rate, stress, largest, reach = f[law + RATE], abs(f[law + STRESS]), 0.0, 0.0
    for j in range(i, pieces):
        at = q[NOW] + width * j
        largest = max(largest, f[at + SIZE])
        if rate == math.inf:
            reach = max(reach, f[SHARE] * f[at + SIZE])
        else:
            time = 0.5 * f[TRANSIT] * (f[at + STOP] - (low if j == i else f[at + START]))
            if rate > 0.0:
                time = min(time, 1.0 / rate)
            reach = max(reach, time * (f[SHARE] * f[at + SIZE] + stress))
    if 0.0 < rate < math.inf:
        reach = max(reach, abs(f[VALUE] + f[REST]))
    f[LARGEST], f[TOLERANCE], f[TRAVELLED], q[BEGUN] = largest, GRAZE * reach, 0.0, 0


@compiled
def solved(f: Array, q: Counts, n: int, width: float) -> tuple[int, int]:
    """Fill ``ZETA`` and ``PUSH`` for the wave of degree ``n`` in ``WAVE``; their degrees."""
    law = q[LAW] + SEGMENT_SIZE * q[SEGMENT]
    rate, stress = f[law + RATE], f[law + STRESS]
    if rate == math.inf:
        f[ZETA] = 0.0
        for k in range(n + 1):
            f[PUSH + k] = f[SHARE] * f[WAVE + k]
        return 0, n
    half = 0.5 * f[TRANSIT] * width
    for k in range(n + 1):
        f[EXTRA + k] = half * (f[SHARE] * f[WAVE + k])
    f[EXTRA] -= half * stress
    if rate == 0.0:
        m = integrated(f, q, (EXTRA, n), ZETA)
        f[TRAVEL] = right_end(f, ZETA, m)
        f[ZETA] += f[TRAVELLED] + f[REST]
        f[ZETA] += f[VALUE]
        f[PUSH] = stress
        return m, 0
    m = relaxed(f, q, (EXTRA, n), (rate * half, f[VALUE] + f[REST]), ZETA)
    m = trimmed(f, ZETA, m, TINY * f[LARGEST] * min(f[TRANSIT], 1.0 / rate))
    for k in range(m + 1):
        f[PUSH + k] = rate * f[ZETA + k]
    f[PUSH] += stress
    return m, m


@inlined
def roughness(f: Array, q: Counts, n: int, m: int) -> float:
    """The last coefficients of ``zeta`` (degree ``m``), if neither rounding nor those of ``W`` explain them; else 0."""
    law = q[LAW] + SEGMENT_SIZE * q[SEGMENT]
    rate = f[law + RATE]
    if m < q[DEGREE] or rate == 0.0 or rate == math.inf:
        return 0.0
    tail, given = max(abs(f[ZETA + m]), abs(f[ZETA + m - 1])), 0.0
    for k in range(m - 1, n + 1):
        given = max(given, f[SHARE] * abs(f[WAVE + k]))
    time = min(f[TRANSIT], 1.0 / rate)
    reach = (f[LARGEST] + abs(f[law + STRESS])) * time
    allowed = max(RESOLVED * max(reach, abs(f[VALUE] + f[REST])), min(2.0 * time * given, 3.0 * RESOLVED * reach))
    return float(tail) if tail > allowed else 0.0


@compiled
def departure(f: Array, q: Counts, nz: int, np_: int) -> tuple[int, float]:
    """Step to the next segment and place of the first departure, ``NEVER`` or ``UNDECIDED``."""
    law, tolerance = q[LAW] + SEGMENT_SIZE * q[SEGMENT], f[TOLERANCE]
    if f[law + RATE] == math.inf:
        for k in range(np_ + 1):
            f[EXTRA + k] = -f[PUSH + k]
        return -1, first_rise(f, q, EXTRA, np_, tolerance)
    swing, step, place = variation(f, ZETA, nz), 0, NEVER
    for way in (1, -1):
        bound = f[law + HIGH] if way > 0 else f[law + LOW]
        distance = bound - f[law + ORIGIN]
        over = way * (f[ZETA] - distance) - _ULPS * abs(distance)
        if math.isinf(bound) or over + swing <= tolerance:
            continue
        f[EXTRA] = over
        for k in range(1, nz + 1):
            f[EXTRA + k] = way * f[ZETA + k]
        found = first_rise(f, q, EXTRA, nz, tolerance)
        if found == UNDECIDED:
            return way, UNDECIDED
        if found < place:
            step, place = way, found
    return step, place


@inlined
def moved(f: Array, q: Counts, nz: int) -> None:
    """Carry ``z`` to the end of the piece."""
    rate = f[q[LAW] + SEGMENT_SIZE * q[SEGMENT] + RATE]
    if rate == math.inf:
        f[VALUE], f[REST] = 0.0, 0.0
    elif rate == 0.0:
        f[TRAVELLED] += f[TRAVEL]
    else:
        f[VALUE], f[REST] = right_end(f, ZETA, nz), 0.0


@compiled
def settled(f: Array, q: Counts) -> None:
    """Add what was travelled in free flight to ``z``, with what rounding loses."""
    if f[q[LAW] + SEGMENT_SIZE * q[SEGMENT] + RATE] == 0.0:
        small = f[TRAVELLED] + f[REST]
        total = f[VALUE] + small
        back = total - f[VALUE]
        f[VALUE], f[REST] = total, (f[VALUE] - (total - back)) + (small - back)
