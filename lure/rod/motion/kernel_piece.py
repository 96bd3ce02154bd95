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

from lure.rod.motion import kernel_series as M
from lure.rod.motion.kernel_series import Counts, first_rise, inlined, kernel, right_end, short_part, trimmed, variation
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
    total, sign, m = 0.0, -1.0, min(n + 1, q[M.DEGREE])
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
    (h, n), (s, start), most = load, problem, q[M.DEGREE]
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
            f[M.PIVOT + k] = 2.0 * k + s * (k + 1.0) / k
            f[M.RIGHT + k] = right + ((k + 1.0) / k * f[h + k] if k <= n else 0.0)
        else:
            share = s / f[M.PIVOT + k + 1]
            f[M.PIVOT + k] = 2.0 * k + s * share
            f[M.RIGHT + k] = right + share * f[M.RIGHT + k + 1]
    free, unit, free_sum, unit_sum, sign = 0.0, 2.0, 0.0, 1.0, -1.0
    for k in range(1, m + 1):
        free = (f[M.RIGHT + k] - s * free) / f[M.PIVOT + k]
        unit = -s * unit / f[M.PIVOT + k]
        f[M.FREE + k], f[M.UNIT + k] = free, unit
        free_sum += sign * free
        unit_sum += sign * unit
        sign = -sign
    first = (start - free_sum) / unit_sum
    f[out] = first
    for k in range(1, m + 1):
        f[out + k] = f[M.FREE + k] + first * f[M.UNIT + k]
    return int(m)


@inlined
def local(x: float, low: float, high: float) -> float:
    """``x`` in ``[low, high]`` as a number in ``[-1, 1]``."""
    return min(max(((x - low) - (high - x)) / (high - low), -1.0), 1.0)


@inlined
def cut_out(f: Array, q: Counts, piece: tuple[int, int], span: tuple[float, float], out: int) -> int:
    """A piece of a wave, of a degree, between two instants, and the degree there."""
    (at, n), (a, b) = piece, span
    low, high = f[at + M.START], f[at + M.STOP]
    if a == low and b == high:
        for k in range(n + 1):
            f[out + k] = f[at + M.COEF + k]
        return n
    return short_part(f, q, (at + M.COEF, n), (local(a, low, high), local(b, low, high)), out)


@kernel
def begun(f: Array, q: Counts, pieces: int, i: int, low: float) -> None:
    """Begin an arc: the sizes on which its tolerances depend, over the pieces ahead."""
    nonlinearity, width = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT], q[M.DEGREE] + 1 + M.COEF
    rate, stress, largest, reach = f[nonlinearity + M.RATE], abs(f[nonlinearity + M.STRESS]), 0.0, 0.0
    power = f[nonlinearity + M.POWER]
    for j in range(i, pieces):
        at = q[M.NOW] + width * j
        largest = max(largest, f[at + M.SIZE])
        if rate == math.inf:
            reach = max(reach, f[M.SHARE] * f[at + M.SIZE])
        else:
            time = 0.5 * f[M.TRANSIT] * (f[at + M.STOP] - (low if j == i else f[at + M.START]))
            if rate > 0.0 and power == 1.0:
                time = min(time, 1.0 / rate)
            reach = max(reach, time * (f[M.SHARE] * f[at + M.SIZE] + stress))
    if power < 1.0:
        reach = f[M.SHARE] * largest
    elif power > 1.0:
        reach = min(reach, float(np.float64(f[M.SHARE] * largest / rate) ** (1.0 / power)))
    if 0.0 < rate < math.inf and power >= 1.0:
        reach = max(reach, abs(f[M.VALUE] + f[M.REST]))
    f[M.LARGEST], f[M.TOLERANCE], f[M.TRAVELLED], q[M.BEGUN] = largest, GRAZE * reach, 0.0, 0
    f[M.STEP], q[M.POWERED] = math.inf, 0


@kernel
def solved(f: Array, q: Counts, n: int, width: float) -> tuple[int, int]:
    """Fill ``ZETA`` and ``PUSH`` for the wave of degree ``n`` in ``WAVE``; their degrees."""
    nonlinearity = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT]
    rate, stress = f[nonlinearity + M.RATE], f[nonlinearity + M.STRESS]
    if rate == math.inf:
        f[M.ZETA] = 0.0
        for k in range(n + 1):
            f[M.PUSH + k] = f[M.SHARE] * f[M.WAVE + k]
        return 0, n
    half = 0.5 * f[M.TRANSIT] * width
    for k in range(n + 1):
        f[M.EXTRA + k] = half * (f[M.SHARE] * f[M.WAVE + k])
    f[M.EXTRA] -= half * stress
    if rate == 0.0:
        m = integrated(f, q, (M.EXTRA, n), M.ZETA)
        f[M.TRAVEL] = right_end(f, M.ZETA, m)
        f[M.ZETA] += f[M.TRAVELLED] + f[M.REST]
        f[M.ZETA] += f[M.VALUE]
        f[M.PUSH] = stress
        return m, 0
    m = relaxed(f, q, (M.EXTRA, n), (rate * half, f[M.VALUE] + f[M.REST]), M.ZETA)
    m = trimmed(f, M.ZETA, m, TINY * f[M.LARGEST] * min(f[M.TRANSIT], 1.0 / rate))
    for k in range(m + 1):
        f[M.PUSH + k] = rate * f[M.ZETA + k]
    f[M.PUSH] += stress
    return m, m


@inlined
def roughness(f: Array, q: Counts, n: int, m: int) -> float:
    """The last coefficients of ``zeta`` (degree ``m``), if neither rounding nor those of ``W`` explain them; else 0."""
    nonlinearity = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT]
    rate = f[nonlinearity + M.RATE]
    if m < q[M.DEGREE] or rate == 0.0 or rate == math.inf:
        return 0.0
    tail, given = max(abs(f[M.ZETA + m]), abs(f[M.ZETA + m - 1])), 0.0
    for k in range(m - 1, n + 1):
        given = max(given, f[M.SHARE] * abs(f[M.WAVE + k]))
    time = min(f[M.TRANSIT], 1.0 / rate)
    reach = (f[M.LARGEST] + abs(f[nonlinearity + M.STRESS])) * time
    allowed = max(RESOLVED * max(reach, abs(f[M.VALUE] + f[M.REST])), min(2.0 * time * given, 3.0 * RESOLVED * reach))
    return float(tail) if tail > allowed else 0.0


@kernel
def departure(f: Array, q: Counts, nz: int, np_: int) -> tuple[int, float]:
    """Step to the next segment and place of the first departure, ``NEVER`` or ``UNDECIDED``."""
    nonlinearity, tolerance = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT], f[M.TOLERANCE]
    if f[nonlinearity + M.RATE] == math.inf or f[nonlinearity + M.POWER] < 1.0:
        for k in range(np_ + 1):
            f[M.EXTRA + k] = -f[M.PUSH + k]
        return -1, first_rise(f, q, M.EXTRA, np_, tolerance)
    swing, step, place = variation(f, M.ZETA, nz), 0, M.NEVER
    for way in (1, -1):
        bound = f[nonlinearity + M.HIGH] if way > 0 else f[nonlinearity + M.LOW]
        distance = bound - f[nonlinearity + M.ORIGIN]
        over = way * (f[M.ZETA] - distance) - _ULPS * abs(distance)
        if math.isinf(bound) or over + swing <= tolerance:
            continue
        f[M.EXTRA] = over
        for k in range(1, nz + 1):
            f[M.EXTRA + k] = way * f[M.ZETA + k]
        found = first_rise(f, q, M.EXTRA, nz, tolerance)
        if found == M.UNDECIDED:
            return way, M.UNDECIDED
        if found < place:
            step, place = way, found
    return step, place


@inlined
def moved(f: Array, q: Counts, nz: int) -> None:
    """Carry ``z`` to the end of the piece."""
    rate = f[q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT] + M.RATE]
    if rate == math.inf:
        f[M.VALUE], f[M.REST] = 0.0, 0.0
    elif rate == 0.0:
        f[M.TRAVELLED] += f[M.TRAVEL]
    else:
        f[M.VALUE], f[M.REST] = right_end(f, M.ZETA, nz), 0.0


@kernel
def settled(f: Array, q: Counts) -> None:
    """Add what was travelled in free flight to ``z``, with what rounding loses."""
    if f[q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT] + M.RATE] == 0.0:
        small = f[M.TRAVELLED] + f[M.REST]
        total = f[M.VALUE] + small
        back = total - f[M.VALUE]
        f[M.VALUE], f[M.REST] = total, (f[M.VALUE] - (total - back)) + (small - back)


@kernel
def against_power(f: Array, q: Counts, piece: tuple[int, int], span: tuple[float, float]) -> tuple[int, float, int]:
    """Fill ``WAVE``, ``ZETA``, ``PUSH`` up to an instant: ``SOLVED`` or why not, the instant, the wave's degree."""
    (low, stop), rate, size = span, f[q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT] + M.RATE], f[M.SHARE] * f[M.LARGEST]
    if (
        np.float64(size / rate) ** (1.0 / f[q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT] + M.POWER])
        < _THINNEST * f[M.TRANSIT] * size
    ):
        return TOO_STIFF, low, 0
    if q[M.POWERED] == MOST_POWERED:
        return TOO_MANY, low, 0
    last = q[M.DEGREE]
    while True:
        step = stop - low if f[M.STEP] >= 0.75 * (stop - low) else f[M.STEP]
        high = stop if step == stop - low else low + step
        n = cut_out(f, q, piece, (low, high), M.WAVE)
        narrow = step <= _NARROWEST
        if not _collocated(f, q, n, 0.5 * f[M.TRANSIT] * step):
            f[M.STEP] = 0.25 * step
            if not narrow:
                continue
            for k in range(last + 1):
                f[M.ZETA + k], f[M.PUSH + k] = 0.0, f[M.SHARE] * f[M.WAVE + k] if k <= n else 0.0
            f[M.ZETA] = f[M.VALUE] + f[M.REST]
        tail = max(abs(f[M.PUSH + last]), abs(f[M.PUSH + last - 1]))
        miss = max(tail / _STRESS, max(abs(f[M.ZETA + last]), abs(f[M.ZETA + last - 1])) / (_PLACE * f[M.TRANSIT]))
        if miss > size and not narrow:
            f[M.STEP] = (0.5 if miss < 1e3 * size else 0.25) * step
            continue
        f[M.MISSED] += step * tail
        f[M.STEP] = (4.0 if miss < 1e-2 * size else 2.0) * step
        q[M.POWERED] += 1
        return SOLVED, high, n


@kernel
def _collocated(f: Array, q: Counts, n: int, half: float) -> bool:
    """Fill ``ZETA`` and ``PUSH`` for the wave in ``WAVE`` over twice ``half`` [s]; whether Newton's method settles."""
    nonlinearity, size = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT], q[M.DEGREE] + 1
    rate, m, start = f[nonlinearity + M.RATE], f[nonlinearity + M.POWER], f[M.VALUE] + f[M.REST]
    wave = np.zeros(size)
    for k in range(n + 1):
        wave[k] = f[M.SHARE] * f[M.WAVE + k]
    incoming = np.asarray(f[q[M.AT_EXTREMA] : q[M.AT_EXTREMA] + size * size]).reshape((size, size)) @ wave
    table = np.asarray(f[q[M.COLLOCATION] : q[M.COLLOCATION] + (size - 1) * (size - 1)])
    K = half * table.reshape((size - 1, size - 1))
    free = start + K @ incoming[1:]
    scale = np.abs(free).max()
    if scale == 0.0:
        for k in range(size):
            f[M.ZETA + k], f[M.PUSH + k] = 0.0, 0.0
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
    fit = np.asarray(f[q[M.FROM_EXTREMA] : q[M.FROM_EXTREMA] + size * size]).reshape((size, size))
    values, stresses = fit @ values, fit @ stresses
    for k in range(size):
        f[M.ZETA + k], f[M.PUSH + k] = values[k], stresses[k]
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
