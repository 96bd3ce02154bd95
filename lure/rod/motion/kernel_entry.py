"""What compiled code keeps of the motion: pieces, impacts, the energy balance, the wave that leaves."""

from __future__ import annotations

import math

from lure.rod.motion.chebyshev import Array
from lure.rod.motion.jit import compiled, inlined
from lure.rod.motion.kernel_crossing import peak
from lure.rod.motion.kernel_data import (
    ARCS,
    AREA,
    BEFORE,
    BEGUN,
    COEF,
    CROSSINGS,
    DEGREE,
    ECHO,
    ENDINGS,
    ENDS,
    ENERGY,
    ERROR,
    EXTRA,
    HIGH,
    HIGHEST,
    IMPACT,
    IMPACTS,
    IMPEDANCE,
    IMPULSE,
    LAW,
    LEFT,
    LOW,
    MARKS,
    MISSED,
    MOBILITY,
    MOST_NUMBERS,
    MOST_PIECES,
    NEW,
    NEW_DEGREES,
    NUMBERS,
    OPEN,
    ORIGIN,
    OUT_ENDINGS,
    OUT_ENDS,
    OUT_IMPACTS,
    OUT_MARKS,
    OUT_NUMBERS,
    OUT_PIECES,
    PASSED,
    PEAK,
    PIECE,
    PIECES,
    PUSH,
    RATE,
    REST,
    ROOM,
    SEGMENT,
    SEGMENT_SIZE,
    SEGMENTS,
    SHARE,
    SINCE,
    SIZE,
    START,
    STOP,
    STORED,
    STRESS,
    TERM,
    TOUCHING,
    TRANSIT,
    TRIP,
    UNTIL,
    VALUE,
    WAVE,
    WINDOWS,
    WORK,
    WORK_REST,
    WORST,
    ZETA,
    Counts,
)
from lure.rod.motion.kernel_series import mean, product

Span = tuple[float, float]
Degrees = tuple[int, int, int]


@compiled
def emitted(f: Array, q: Counts, span: Span, degrees: Degrees) -> bool:
    """Enter the piece in ``WAVE``, ``ZETA``, ``PUSH`` everywhere; whether there was room."""
    (low, high), (n, nz, np_) = span, degrees
    i, at = q[PIECES], q[NUMBERS]
    if i == q[MOST_PIECES] or at + n + nz + np_ + 3 > q[MOST_NUMBERS] or q[LEFT] == q[ROOM]:
        return False
    head, ends = q[OUT_PIECES] + PIECE * i, q[OUT_ENDS] + ENDS * i
    q[head], q[head + 1], q[head + 2], q[head + 3] = at, n, nz, np_
    f[ends], f[ends + 1] = low, high
    out = q[OUT_NUMBERS] + at
    for k in range(n + 1):
        f[out + k] = f[WAVE + k]
    out += n + 1
    for k in range(nz + 1):
        f[out + k] = f[ZETA + k]
    f[out] += f[q[LAW] + SEGMENT_SIZE * q[SEGMENT] + ORIGIN]
    out += nz + 1
    for k in range(np_ + 1):
        f[out + k] = f[PUSH + k]
    q[PIECES], q[NUMBERS] = i + 1, at + n + nz + np_ + 3
    half = 0.5 * f[TRANSIT] * (high - low)
    f[PASSED] += 0.25 * f[IMPEDANCE] * half * product(f, q, (WAVE, n), (WAVE, n))
    pushed = np_ > 0 or f[PUSH] != 0.0
    if pushed:
        for k in range(max(n, np_) + 1):
            speed = f[SHARE] * f[WAVE + k] if k <= n else 0.0
            f[EXTRA + k] = speed - f[PUSH + k] if k <= np_ else speed
        work = product(f, q, (PUSH, np_), (EXTRA, max(n, np_)))
        f[TERM] += f[IMPEDANCE] / f[SHARE] * half * work
    _sent(f, q, span, n, np_ if pushed else -1)
    if q[BEGUN] == 0:
        q[BEGUN], q[ARCS] = 1, q[ARCS] + 1
    _touched(f, q, span, np_)
    return True


@inlined
def _sent(f: Array, q: Counts, span: Span, n: int, np_: int) -> None:
    """The wave that leaves, as it comes back: ``-a V``."""
    j, most = q[LEFT], max(n, np_)
    at, back, size = q[NEW] + (q[DEGREE] + 1 + COEF) * j, 2.0 * f[SHARE] - 1.0, 0.0
    for k in range(most + 1):
        left = back * f[WAVE + k] if k <= n else 0.0
        if k <= np_:
            left -= 2.0 * f[PUSH + k]
        f[at + COEF + k] = f[ECHO] * left
        size += abs(left)
    f[at + START], f[at + STOP], f[at + SIZE] = span[0], span[1], abs(f[ECHO]) * size
    q[q[NEW_DEGREES] + j], q[LEFT] = most, j + 1


@compiled
def _touched(f: Array, q: Counts, span: Span, np_: int) -> None:
    """Continue, begin or end an impact."""
    touching = f[q[LAW] + SEGMENT_SIZE * q[SEGMENT] + TOUCHING] > 0.0
    if not touching and q[OPEN] == 0:
        return
    start = f[TRANSIT] * (2.0 * q[TRIP] + span[0])
    if touching:
        if q[OPEN] == 0:
            q[OPEN], f[SINCE], f[IMPULSE], f[PEAK] = 1, start, 0.0, -math.inf
        f[UNTIL] = f[TRANSIT] * (2.0 * q[TRIP] + span[1])
        f[IMPULSE] += f[AREA] / f[MOBILITY] * mean(f, PUSH, np_) * (f[TRANSIT] * (span[1] - span[0]))
        f[PEAK] = peak(f, q, PUSH, np_, f[PEAK])
    else:
        at = q[OUT_IMPACTS] + IMPACT * q[IMPACTS]
        f[at], f[at + 1], f[at + 2], f[at + 3] = f[SINCE], start, f[IMPULSE], f[PEAK] / f[MOBILITY]
        q[IMPACTS], q[OPEN] = q[IMPACTS] + 1, 0


@compiled
def entered(f: Array, q: Counts) -> None:
    """Enter the round trip in the record, and in the energy balance."""
    w, crossings, error = q[WINDOWS], max(q[ARCS] - 1, 0), f[TRANSIT] * f[MISSED]
    at = q[OUT_MARKS] + MARKS * w
    q[at], q[at + 1], q[at + 2], q[at + 3] = q[SEGMENT], q[OPEN], crossings, q[IMPACTS]
    q[at + 4] = q[BEFORE]
    at = q[OUT_ENDINGS] + ENDINGS * w
    f[at], f[at + 1], f[at + 2], f[at + 3] = error, f[VALUE], f[REST], f[SINCE]
    f[at + 4], f[at + 5], f[at + 6] = f[UNTIL], f[IMPULSE], f[PEAK] / f[MOBILITY]
    q[WINDOWS] = w + 1
    f[ERROR] += error
    q[CROSSINGS] += crossings
    term = f[TERM]
    total = f[WORK] + term
    f[WORK_REST] += (f[WORK] - total) + term if abs(f[WORK]) >= abs(term) else (term - total) + f[WORK]
    f[WORK] = total
    energy = stored(f, q, f[q[LAW] + SEGMENT_SIZE * q[SEGMENT] + ORIGIN] + (f[VALUE] + f[REST]))
    f[WORST] = max(f[WORST], abs(f[WORK] + f[WORK_REST] - (energy - f[STORED])))
    f[ENERGY] = max(f[ENERGY], f[PASSED], abs(energy), abs(f[STORED]))


@compiled
def stored(f: Array, q: Counts, z: float) -> float:
    """``A P(z)`` [J]."""
    total = 0.0
    for j in range(q[SEGMENTS]):
        law = q[LAW] + SEGMENT_SIZE * j
        rate, stress, origin = f[law + RATE], f[law + STRESS], f[law + ORIGIN]
        low, high = max(f[law + LOW], min(0.0, z)), min(f[law + HIGH], max(0.0, z))
        if low >= high or rate == math.inf or (rate == 0.0 and stress == 0.0):
            continue
        a, b = low - origin, high - origin
        area = stress * (b - a) + rate * 0.5 * (b - a) * (b + a)
        total += area if z > 0.0 else -area
    return float(f[AREA] * total / f[MOBILITY])


@compiled
def largest_wave(f: Array, q: Counts, pieces: int, at: int) -> None:
    """Enter the largest wave of the pieces that begin at a place."""
    for j in range(pieces):
        f[HIGHEST] = max(f[HIGHEST], f[at + (q[DEGREE] + 1 + COEF) * j + SIZE])
