r"""One piece of the motion: ``zeta' + s zeta = h`` solved on a segment of the nonlinearity, and tested for its end.

On ``[-1, 1]``, with ``zeta = sum z_k T_k``, the integrated equation of a straight segment reads
``2 k z_k + s (z_{k-1} - z_{k+1}) = h_{k-1} - h_{k+1}`` (``z_0``, ``h_0`` twice for ``k = 1``): tridiagonal, with the
start as one more row.  A residual that vanishes at 1 is left in the last row, ``U_n - (n+1)/n U_{n-1}``, which adds
``s (n+1)/n`` to the diagonal: at ``s -> inf`` the solution takes the value ``h/s`` at the right end.  Elimination from
the last row up has pivots ``2 k + s^2/(next pivot) > 0``, and the work is proportional to the degree.

Against a power law, ``z' = W - d c_n max(z, 0)^m``, ``zeta`` is the polynomial with the given start that satisfies the
equation at the Chebyshev extrema except the left one (stiffly accurate); Newton's method finds it.  A piece is kept if
the last coefficients of ``zeta`` and of the stress have fallen to rounding, and cut otherwise: near contact and
release, where a power that is no whole number is not smooth, pieces shrink geometrically.
"""

from __future__ import annotations

import math

import numpy as np

from lure.rod.motion.kernel_series import (
    AT_EXTREMA,
    BEGUN,
    COEF,
    COLLOCATION,
    DEGREE,
    EXTRA,
    FREE,
    FROM_EXTREMA,
    HIGH,
    LARGEST,
    LAW,
    LOW,
    MISSED,
    NEVER,
    NOW,
    ORIGIN,
    PIVOT,
    POWER,
    POWERED,
    PUSH,
    RATE,
    REST,
    RIGHT,
    SEGMENT,
    SEGMENT_SIZE,
    SHARE,
    SIZE,
    START,
    STEP,
    STOP,
    STRESS,
    TOLERANCE,
    TRANSIT,
    TRAVEL,
    TRAVELLED,
    UNDECIDED,
    UNIT,
    VALUE,
    WAVE,
    ZETA,
    Counts,
    first_rise,
    inlined,
    kernel,
    right_end,
    short_part,
    trimmed,
    variation,
)
from lure.rod.motion.pieces import Array

_SMALL = 1e-19
SAME = 2e-15
TINY = 1e-19  # of the scale of the wave: what a long sum of echoes never shows
GRAZE, RESOLVED = 8e-15, 3e-15
_ULPS = 2e-15
SOLVED, TOO_STIFF, TOO_MANY = 0, 1, 2
MOST_POWERED = 2000  # pieces against a power law
_STRESS, _PLACE = 3e-14, 3e-15
_NARROWEST, _THINNEST = 1e-11, 3e-11
_ITERATIONS = 40


@inlined
def integrated(f: Array, q: Counts, load: tuple[int, int], out: int) -> int:
    """The quadrature from -1, ``s = 0``; the degree, one more than that of ``h`` if there is room."""
    h, n = load
    total, sign, m = 0.0, -1.0, min(n + 1, q[DEGREE])
    for k in range(1, m + 1):
        z = 2.0 * f[h] if k == 1 else f[h + k - 1]
        if k + 1 <= n:
            z -= f[h + k + 1]
        z /= 2.0 * k
        total += sign * z
        sign = -sign
        f[out + k] = z
    f[out] = -total
    return int(m)


@kernel
def relaxed(f: Array, q: Counts, load: tuple[int, int], problem: tuple[float, float], out: int) -> int:
    """The solution for ``s > 0`` from a start; its degree is that of ``h`` and what the exponential needs."""
    (h, n), (s, start), most = load, problem, q[DEGREE]
    m, term, j = n + 1, 1.0, 0
    while term > _SMALL and m < most:
        j += 1
        m += 1
        term *= s / (2.0 * j)
    m = min(m, most)
    for k in range(m, 0, -1):
        right = 0.0
        if k - 1 <= n:
            right = 2.0 * f[h] if k == 1 else f[h + k - 1]
        if k + 1 <= n:
            right -= f[h + k + 1]
        if k == m:
            f[PIVOT + k] = 2.0 * k + s * (k + 1.0) / k
            f[RIGHT + k] = right + ((k + 1.0) / k * f[h + k] if k <= n else 0.0)
        else:
            share = s / f[PIVOT + k + 1]
            f[PIVOT + k] = 2.0 * k + s * share
            f[RIGHT + k] = right + share * f[RIGHT + k + 1]
    free, unit, free_sum, unit_sum, sign = 0.0, 2.0, 0.0, 1.0, -1.0
    for k in range(1, m + 1):
        free = (f[RIGHT + k] - s * free) / f[PIVOT + k]
        unit = -s * unit / f[PIVOT + k]
        f[FREE + k], f[UNIT + k] = free, unit
        free_sum += sign * free
        unit_sum += sign * unit
        sign = -sign
    first = (start - free_sum) / unit_sum
    f[out] = first
    for k in range(1, m + 1):
        f[out + k] = f[FREE + k] + first * f[UNIT + k]
    return int(m)


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


@kernel
def begun(f: Array, q: Counts, pieces: int, i: int, low: float) -> None:
    """Begin an arc: the sizes on which its tolerances depend, over the pieces ahead."""
    nonlinearity, width = q[LAW] + SEGMENT_SIZE * q[SEGMENT], q[DEGREE] + 1 + COEF
    rate, stress, largest, reach = f[nonlinearity + RATE], abs(f[nonlinearity + STRESS]), 0.0, 0.0
    power = f[nonlinearity + POWER]
    for j in range(i, pieces):
        at = q[NOW] + width * j
        largest = max(largest, f[at + SIZE])
        if rate == math.inf:
            reach = max(reach, f[SHARE] * f[at + SIZE])
        else:
            time = 0.5 * f[TRANSIT] * (f[at + STOP] - (low if j == i else f[at + START]))
            if rate > 0.0 and power == 1.0:
                time = min(time, 1.0 / rate)
            reach = max(reach, time * (f[SHARE] * f[at + SIZE] + stress))
    if power < 1.0:
        reach = f[SHARE] * largest
    elif power > 1.0:
        reach = min(reach, float(np.float64(f[SHARE] * largest / rate) ** (1.0 / power)))
    if 0.0 < rate < math.inf and power >= 1.0:
        reach = max(reach, abs(f[VALUE] + f[REST]))
    f[LARGEST], f[TOLERANCE], f[TRAVELLED], q[BEGUN] = largest, GRAZE * reach, 0.0, 0
    f[STEP], q[POWERED] = math.inf, 0


@kernel
def solved(f: Array, q: Counts, n: int, width: float) -> tuple[int, int]:
    """Fill ``ZETA`` and ``PUSH`` for the wave of degree ``n`` in ``WAVE``; their degrees."""
    nonlinearity = q[LAW] + SEGMENT_SIZE * q[SEGMENT]
    rate, stress = f[nonlinearity + RATE], f[nonlinearity + STRESS]
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
    nonlinearity = q[LAW] + SEGMENT_SIZE * q[SEGMENT]
    rate = f[nonlinearity + RATE]
    if m < q[DEGREE] or rate == 0.0 or rate == math.inf:
        return 0.0
    tail, given = max(abs(f[ZETA + m]), abs(f[ZETA + m - 1])), 0.0
    for k in range(m - 1, n + 1):
        given = max(given, f[SHARE] * abs(f[WAVE + k]))
    time = min(f[TRANSIT], 1.0 / rate)
    reach = (f[LARGEST] + abs(f[nonlinearity + STRESS])) * time
    allowed = max(RESOLVED * max(reach, abs(f[VALUE] + f[REST])), min(2.0 * time * given, 3.0 * RESOLVED * reach))
    return float(tail) if tail > allowed else 0.0


@kernel
def departure(f: Array, q: Counts, nz: int, np_: int) -> tuple[int, float]:
    """Step to the next segment and place of the first departure, ``NEVER`` or ``UNDECIDED``."""
    nonlinearity, tolerance = q[LAW] + SEGMENT_SIZE * q[SEGMENT], f[TOLERANCE]
    if f[nonlinearity + RATE] == math.inf or f[nonlinearity + POWER] < 1.0:
        for k in range(np_ + 1):
            f[EXTRA + k] = -f[PUSH + k]
        return -1, first_rise(f, q, EXTRA, np_, tolerance)
    swing, step, place = variation(f, ZETA, nz), 0, NEVER
    for way in (1, -1):
        bound = f[nonlinearity + HIGH] if way > 0 else f[nonlinearity + LOW]
        distance = bound - f[nonlinearity + ORIGIN]
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


@kernel
def settled(f: Array, q: Counts) -> None:
    """Add what was travelled in free flight to ``z``, with what rounding loses."""
    if f[q[LAW] + SEGMENT_SIZE * q[SEGMENT] + RATE] == 0.0:
        small = f[TRAVELLED] + f[REST]
        total = f[VALUE] + small
        back = total - f[VALUE]
        f[VALUE], f[REST] = total, (f[VALUE] - (total - back)) + (small - back)


@kernel
def against_power(f: Array, q: Counts, piece: tuple[int, int], span: tuple[float, float]) -> tuple[int, float, int]:
    """Fill ``WAVE``, ``ZETA``, ``PUSH`` up to an instant: ``SOLVED`` or why not, the instant, the wave's degree."""
    (low, stop), rate, size = span, f[q[LAW] + SEGMENT_SIZE * q[SEGMENT] + RATE], f[SHARE] * f[LARGEST]
    if np.float64(size / rate) ** (1.0 / f[q[LAW] + SEGMENT_SIZE * q[SEGMENT] + POWER]) < _THINNEST * f[TRANSIT] * size:
        return TOO_STIFF, low, 0
    if q[POWERED] == MOST_POWERED:
        return TOO_MANY, low, 0
    last = q[DEGREE]
    while True:
        step = stop - low if f[STEP] >= 0.75 * (stop - low) else f[STEP]
        high = stop if step == stop - low else low + step
        n = cut_out(f, q, piece, (low, high), WAVE)
        narrow = step <= _NARROWEST
        if not _collocated(f, q, n, 0.5 * f[TRANSIT] * step):
            f[STEP] = 0.25 * step
            if not narrow:
                continue
            for k in range(last + 1):
                f[ZETA + k], f[PUSH + k] = 0.0, f[SHARE] * f[WAVE + k] if k <= n else 0.0
            f[ZETA] = f[VALUE] + f[REST]
        tail = max(abs(f[PUSH + last]), abs(f[PUSH + last - 1]))
        miss = max(tail / _STRESS, max(abs(f[ZETA + last]), abs(f[ZETA + last - 1])) / (_PLACE * f[TRANSIT]))
        if miss > size and not narrow:
            f[STEP] = (0.5 if miss < 1e3 * size else 0.25) * step
            continue
        f[MISSED] += step * tail
        f[STEP] = (4.0 if miss < 1e-2 * size else 2.0) * step
        q[POWERED] += 1
        return SOLVED, high, n


@kernel
def _collocated(f: Array, q: Counts, n: int, half: float) -> bool:
    """Fill ``ZETA`` and ``PUSH`` for the wave in ``WAVE`` over twice ``half`` [s]; whether Newton's method settles."""
    nonlinearity, size = q[LAW] + SEGMENT_SIZE * q[SEGMENT], q[DEGREE] + 1
    rate, m, start = f[nonlinearity + RATE], f[nonlinearity + POWER], f[VALUE] + f[REST]
    wave = np.zeros(size)
    for k in range(n + 1):
        wave[k] = f[SHARE] * f[WAVE + k]
    incoming = np.asarray(f[q[AT_EXTREMA] : q[AT_EXTREMA] + size * size]).reshape((size, size)) @ wave
    table = np.asarray(f[q[COLLOCATION] : q[COLLOCATION] + (size - 1) * (size - 1)])
    K = half * table.reshape((size - 1, size - 1))
    free = start + K @ incoming[1:]
    scale = np.abs(free).max()
    if scale == 0.0:
        for k in range(size):
            f[ZETA + k], f[PUSH + k] = 0.0, 0.0
        return True
    place, push = free, rate * np.maximum(free, 1e-3 * scale) ** m
    settled_, z, p, slope, miss = _newton(K, free, place if m > 1.0 else push, (rate, m, scale))
    if not settled_:
        push = np.maximum(incoming[1:], 1e-9 * np.abs(incoming).max())
        place = (push / rate) ** (1.0 / m)
        settled_, z, p, slope, miss = _newton(K, free, place if m > 1.0 else push, (rate, m, scale))
    if not settled_:
        return False
    # one correction of the push: rounding of z times a large stiffness would spoil it
    better = p - np.linalg.solve(np.diag(1.0 / np.maximum(slope, 1e-200)) + K, miss)
    if m > 1.0:
        better = np.maximum(better, 0.0)
    stiff = slope * np.abs(K).max() > 1.0
    z = np.where(stiff, np.sign(better) * (np.abs(better) / rate) ** (1.0 / m), z)
    if not (np.isfinite(z).all() and np.isfinite(better).all()):
        return False
    values, stresses = np.empty(size), np.empty(size)
    values[0], stresses[0] = start, rate * max(start, 0.0) ** m
    values[1:], stresses[1:] = z, better
    fit = np.asarray(f[q[FROM_EXTREMA] : q[FROM_EXTREMA] + size * size]).reshape((size, size))
    values, stresses = fit @ values, fit @ stresses
    for k in range(size):
        f[ZETA + k], f[PUSH + k] = values[k], stresses[k]
    return True


@kernel
def _newton(
    K: Array, free: Array, x: Array, numbers: tuple[float, float, float]
) -> tuple[bool, Array, Array, Array, Array]:
    """Whether the method settles; place, push, slope of the nonlinearity and miss.

    In ``z`` for ``m > 1``; in the push for ``m < 1``, whose slope is infinite at contact, the nonlinearity made odd
    below zero.
    """
    (rate, m, scale), last, one = numbers, np.inf, np.eye(len(x))
    z, push, slope, miss = x, x, x, x
    for _ in range(_ITERATIONS):
        if m > 1.0:
            inside = np.maximum(x, 0.0)
            z, push, slope = x, rate * inside**m, rate * m * inside ** (m - 1.0)
            system = one + K * slope
        else:
            share = np.abs(x) / rate
            soft = share ** (1.0 / m - 1.0) / (m * rate)
            z, push, slope = np.sign(x) * share ** (1.0 / m), x, 1.0 / np.maximum(soft, 1e-200)
            system = np.diag(soft) + K
        miss = z + K @ push - free
        size = np.abs(miss).max()
        if not size <= 1e6 * scale:
            return False, z, push, slope, miss
        if size <= 2e-16 * scale or (size <= 1e-13 * scale and size >= 0.5 * last):
            return True, z, push, slope, miss
        x, last = x - np.linalg.solve(system, miss), size
    return False, z, push, slope, miss
