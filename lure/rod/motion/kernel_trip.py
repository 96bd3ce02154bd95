"""Round trips one after the other: the wave that comes back with its loads, arcs and pieces, and what is kept of them.

Each round trip ``2T`` the wave that left ``x = L`` is back, reflected and reinforced.  Times inside a round trip are
kept apart from its number: an event stays at the same place, to the last bit, in all round trips in which its echoes
pass, and free flight is a multiplication by ``-a``.
"""

from __future__ import annotations

import math

import numpy as np

from lure.rod.motion import kernel_series as M
from lure.rod.motion.kernel_piece import (
    SAME,
    SOLVED,
    TINY,
    TOO_STIFF,
    against_power,
    begun,
    cut_out,
    departure,
    local,
    moved,
    roughness,
    solved,
)
from lure.rod.motion.kernel_series import (
    Counts,
    fitted,
    inlined,
    kernel,
    left_end,
    mean,
    part,
    peak,
    product,
    right_end,
    short_part,
    trimmed,
    value,
)
from lure.rod.motion.pieces import Array

Span = tuple[float, float]
Degrees = tuple[int, int, int]
NO_ROOM = -1
_LOAD = 1e-17  # of a load
MERGE = 2e-15
_FIRST = 4e-15  # [transits]
_AT_ONCE = 16.0
_TURNS = 2
DONE, FULL, CHATTER, NEAR, HUGE, STIFF, MANY = 0, 1, 2, 3, 4, 5, 6
_MOST_EVENTS = 4000
_MOST_CUTS = 2000
_NARROWEST = 1e-13
_LAYER = 3.0
LARGEST_WAVE = 1e100


@kernel
def followed(f: Array, q: Counts, pieces: int, powers: int | None) -> int:
    """Arc after arc, piece after piece.

    Where a boundary layer ``exp(-rate t)`` is not resolved the piece is cut at multiples of ``3/rate``, and halved
    where that is not enough: the echoes of a layer after ``n`` round trips are Laguerre functions, with ``n`` zeros.
    """
    i, at, cuts, events, fresh, layer = M.ZERO, q[M.NOW], 0, 0, True, 2.0
    low = f[at + M.START]
    # when the arc began, until when it is kept; see _turned
    since, until, last, turns, moment = low, low, 0, 0, _FIRST
    begun(f, q, pieces, i, low)
    while i < pieces:
        stop, degree = f[at + M.STOP], q[q[M.NOW_DEGREES] + i]
        high = until if low + SAME < until < stop - SAME else stop
        nonlinearity = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT]
        rate, rough, n, nz, np_, curved = f[nonlinearity + M.RATE], 0.0, 0, 0, 0, False
        if powers is not None:
            curved = f[nonlinearity + M.POWER] != 1.0
            if curved:
                found, high, n = against_power(f, q, (at, degree), (low, high))
                if found != SOLVED:
                    return STIFF if found == TOO_STIFF else MANY
                nz, np_ = q[M.DEGREE], q[M.DEGREE]
        if not curved:
            n = cut_out(f, q, (at, degree), (low, high), M.WAVE)
            nz, np_ = solved(f, q, n, high - low)
            rough = roughness(f, q, n, nz)
        if fresh:
            layer, fresh = _LAYER / max(rate * f[M.TRANSIT], 1e-300) if rate > 0.0 else 2.0, False
        while rough > 0.0 and cuts < _MOST_CUTS and high - low > _NARROWEST:
            high = low + (layer if high - low > 1.01 * layer else 0.5 * (high - low))
            cuts += 1
            n = cut_out(f, q, (at, degree), (low, high), M.WAVE)
            nz, np_ = solved(f, q, n, high - low)
            rough = roughness(f, q, n, nz)
            layer = 2.0 * (high - low)
        if rough > 0.0:
            f[M.MISSED] += rate * rough * (high - low)
        step, x = departure(f, q, nz, np_) if low >= until - SAME else (0, M.NEVER)
        if x == M.UNDECIDED:
            return NEAR
        instant = high
        if x != M.NEVER:
            instant = low + 0.5 * (high - low) * (x + 1.0)
            instant = low if instant - low <= SAME else high if high - instant <= SAME else instant
            if low < instant < high:
                n, nz, np_ = _shortened(f, q, (n, nz, np_), x)
        if instant > low and not emitted(f, q, (low, instant), (n, nz, np_)):
            return FULL
        if x == M.NEVER:
            moved(f, q, nz)
        else:
            _passed(f, q, step)
            turns, moment, keep = _turned((last, step), instant - since, turns, moment)
            if f[q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT] + M.POWER] != 1.0:
                keep = 0.0
            since, until, last = instant, instant + keep, step
            f[M.MISSED] += keep * f[M.LARGEST]
            events, high = events + 1, instant
            if events >= _MOST_EVENTS:
                return CHATTER
        low = high
        if high >= stop:
            i, at, cuts, fresh = i + 1, at + q[M.DEGREE] + 1 + M.COEF, 0, True
        if x != M.NEVER:
            cuts, fresh = 0, True
            begun(f, q, pieces, i, low)
    return DONE


@kernel
def _shortened(f: Array, q: Counts, degrees: Degrees, x: float) -> Degrees:
    """Leave of the series of the piece the part up to the place ``x``; its degrees."""
    n, nz, np_ = degrees
    return (
        short_part(f, q, (M.WAVE, n), (-1.0, x), M.WAVE),
        short_part(f, q, (M.ZETA, nz), (-1.0, x), M.ZETA),
        short_part(f, q, (M.PUSH, np_), (-1.0, x), M.PUSH),
    )


@kernel
def _passed(f: Array, q: Counts, step: int) -> None:
    """To the next segment of the nonlinearity, at the bound between."""
    nonlinearity = q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT]
    bound = f[nonlinearity + M.HIGH] if step > 0 else f[nonlinearity + M.LOW]
    q[M.SEGMENT] += step
    f[M.VALUE], f[M.REST] = bound - f[q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT] + M.ORIGIN], 0.0


@kernel
def load_part(f: Array, q: Counts, load: Array, panel: tuple[int, int], span: tuple[float, float]) -> int:
    """Fill ``EXTRA`` with a panel between two instants of its block; the degree: only as many terms as can be seen."""
    (at, whole), (start, stop) = panel, span
    low, high, n, power = load[at], load[at + 1], M.ZERO, 1.0
    c, bound = at + M.PANEL, at + M.PANEL + q[M.DEGREE] + 1
    share, tiny = (stop - start) / (high - low), _LOAD * load[at + 2]
    for k in range(1, whole + 1):
        power *= share
        if load[bound + k] * power > tiny:
            n = k
    a, b = local(start, low, high), local(stop, low, high)
    half, inner = 0.5 * (b - a), q[M.INNER] + n * (q[M.DEGREE] + 1)
    for j in range(n + 1):
        x = a + half * (f[inner + j] + 1.0)
        total, before = 0.0, 0.0
        for k in range(whole, 0, -1):
            total, before = 2.0 * x * total - before + load[c + k], total
        f[M.NODES + j] = x * total - before + load[c]
    fitted(f, q, n, M.EXTRA)
    return n


@kernel
def incoming(f: Array, q: Counts, loads: tuple[Array, Counts], span: float) -> int:
    """Fill the wave of the round trip; the number of pieces, or ``NO_ROOM``.  ``heads``: see :class:`.Panels`."""
    load, heads = loads
    size, width, count = q[M.DEGREE] + 1 + M.COEF, 2 * (q[M.DEGREE] + 1) + M.PANEL, q[M.COUNT]
    p, offset, missed, loaded = M.ZERO, 2.0 * (q[M.TRIP] % M.BLOCK), 0.0, len(load) > 0
    scale = abs(f[M.ECHO]) * f[M.SCALE]
    tiny, i, m, old, c = TINY * scale, M.ZERO, M.ZERO, q[M.OLD], q[M.NOW]
    low = f[old + M.START]
    while i < count and low < span:
        high, ends = f[old + M.STOP], True
        if high > span - SAME:
            high = span
        if loaded:
            while p + 1 < heads[1] and load[width * p + 1] - offset <= low + SAME:
                p += 1
            if load[width * p + 1] - offset < high - SAME:
                high, ends = load[width * p + 1] - offset, False
        if m == q[M.ROOM]:
            return NO_ROOM
        n = cut_out(f, q, (old, q[q[M.OLD_DEGREES] + i]), (low, high), c + M.COEF)
        scale = max(scale, f[old + M.SIZE])
        if loaded and load[width * p + 2] > 0.0:
            more = load_part(f, q, load, (width * p, heads[2 + p]), (low + offset, high + offset))
            for k in range(n + 1, more + 1):
                f[c + M.COEF + k] = 0.0
            for k in range(more + 1):
                f[c + M.COEF + k] += f[M.EXTRA + k]
            n = max(n, more)
            missed = max(missed, load[width * p + 3] * (high - low))
        n = trimmed(f, c + M.COEF, n, tiny)
        sum_ = 0.0
        for k in range(n + 1):
            sum_ += abs(f[c + M.COEF + k])
        q[q[M.NOW_DEGREES] + m], f[c + M.START], f[c + M.STOP], f[c + M.SIZE] = n, low, high, sum_
        scale, low = max(scale, sum_), high
        m, c = m + 1, c + size
        if ends:
            i, old = i + 1, old + size
    f[M.SCALE], f[M.MISSED], f[M.LATER] = scale, f[M.LATER] + missed, 0.0
    return m


@kernel
def merged(f: Array, q: Counts) -> None:
    """Merge pairs of pieces of the wave that comes next, each piece once."""
    width, degrees, count = q[M.DEGREE] + 1 + M.COEF, q[M.OLD_DEGREES], q[M.COUNT]
    tolerance, i, m = MERGE * f[M.SCALE], M.ZERO, M.ZERO
    while i < count:
        at, to, n, taken = q[M.OLD] + width * i, q[M.OLD] + width * m, -1, 1
        if i + 1 < count:
            n = _one(f, q, i, tolerance)
        stop = f[at + M.STOP]
        if n >= 0:
            stop, taken = f[at + width + M.STOP], 2
        else:
            n = q[degrees + i]
            for k in range(n + 1):
                f[M.EXTRA + k] = f[at + M.COEF + k]
        f[to + M.START], f[to + M.STOP], f[to + M.SIZE], q[degrees + m] = f[at + M.START], stop, 0.0, n
        for k in range(n + 1):
            f[to + M.COEF + k] = f[M.EXTRA + k]
            f[to + M.SIZE] += abs(f[M.EXTRA + k])
        i, m = i + taken, m + 1
    if m < count:
        f[M.LATER] += 2.0 * tolerance
    q[M.COUNT], q[M.MERGED] = m, max(8, m)


@kernel
def _one(f: Array, q: Counts, i: int, tolerance: float) -> int:
    """Pieces ``i`` and ``i + 1`` as one series in ``EXTRA``, and its degree; -1 if one will not do."""
    first = q[M.OLD] + (q[M.DEGREE] + 1 + M.COEF) * i
    second = first + q[M.DEGREE] + 1 + M.COEF
    n, m = q[q[M.OLD_DEGREES] + i], q[q[M.OLD_DEGREES] + i + 1]
    low, middle, high = f[first + M.START], f[first + M.STOP], f[second + M.STOP]
    if abs(right_end(f, first + M.COEF, n) - left_end(f, second + M.COEF, m)) > tolerance:
        return -1
    degree, cut = max(n, m), local(middle, low, high)
    while True:
        inner = q[M.INNER] + degree * (q[M.DEGREE] + 1)
        for j in range(degree + 1):
            x = low + 0.5 * (high - low) * (f[inner + j] + 1.0)
            if x < middle:
                f[M.NODES + j] = value(f, first + M.COEF, n, local(x, low, middle))
            else:
                f[M.NODES + j] = value(f, second + M.COEF, m, local(x, middle, high))
        size = fitted(f, q, degree, M.EXTRA)
        if _same(f, q, (degree, first, n), (-1.0, cut), tolerance) and _same(
            f, q, (degree, second, m), (cut, 1.0), tolerance
        ):
            return trimmed(f, M.EXTRA, degree, M.NOISE * size)
        if degree == q[M.DEGREE]:
            return -1
        degree = q[M.DEGREE]


@kernel
def _same(f: Array, q: Counts, pair: tuple[int, int, int], span: tuple[float, float], tolerance: float) -> bool:
    """Whether a part of the series in ``EXTRA`` is a piece, in the sum of the differences of coefficients."""
    degree, piece, n = pair
    part(f, q, (M.EXTRA, degree), span, M.PART)
    miss = 0.0
    for k in range(max(degree, n) + 1):
        ours = f[M.PART + k] if k <= degree else 0.0
        theirs = f[piece + M.COEF + k] if k <= n else 0.0
        miss += abs(ours - theirs)
    return miss <= tolerance


@kernel
def emitted(f: Array, q: Counts, span: Span, degrees: Degrees) -> bool:
    """Enter the piece in ``WAVE``, ``ZETA``, ``PUSH`` everywhere; whether there was room."""
    (low, high), (n, nz, np_) = span, degrees
    i, at = q[M.PIECES], q[M.NUMBERS]
    if i == q[M.MOST_PIECES] or at + n + nz + np_ + 3 > q[M.MOST_NUMBERS] or q[M.LEFT] == q[M.ROOM]:
        return False
    head, ends = q[M.OUT_PIECES] + M.PIECE * i, q[M.OUT_ENDS] + M.ENDS * i
    q[head], q[head + 1], q[head + 2], q[head + 3] = at, n, nz, np_
    f[ends], f[ends + 1] = low, high
    out = q[M.OUT_NUMBERS] + at
    for k in range(n + 1):
        f[out + k] = f[M.WAVE + k]
    out += n + 1
    for k in range(nz + 1):
        f[out + k] = f[M.ZETA + k]
    f[out] += f[q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT] + M.ORIGIN]
    out += nz + 1
    for k in range(np_ + 1):
        f[out + k] = f[M.PUSH + k]
    q[M.PIECES], q[M.NUMBERS] = i + 1, at + n + nz + np_ + 3
    half = 0.5 * f[M.TRANSIT] * (high - low)
    f[M.PASSED] += 0.25 * f[M.IMPEDANCE] * half * product(f, q, (M.WAVE, n), (M.WAVE, n))
    pushed = np_ > 0 or f[M.PUSH] != 0.0
    if pushed:
        for k in range(max(n, np_) + 1):
            speed = f[M.SHARE] * f[M.WAVE + k] if k <= n else 0.0
            f[M.EXTRA + k] = speed - f[M.PUSH + k] if k <= np_ else speed
        work = product(f, q, (M.PUSH, np_), (M.EXTRA, max(n, np_)))
        f[M.TERM] += f[M.IMPEDANCE] / f[M.SHARE] * half * work
    _sent(f, q, span, n, np_ if pushed else -1)
    if q[M.BEGUN] == 0:
        q[M.BEGUN], q[M.ARCS] = 1, q[M.ARCS] + 1
    _touched(f, q, span, np_)
    return True


@inlined
def _sent(f: Array, q: Counts, span: Span, n: int, np_: int) -> None:
    """The wave that leaves, as it comes back: ``-a V``."""
    j, most = q[M.LEFT], max(n, np_)
    at, back, size = q[M.NEW] + (q[M.DEGREE] + 1 + M.COEF) * j, 2.0 * f[M.SHARE] - 1.0, 0.0
    for k in range(most + 1):
        left = back * f[M.WAVE + k] if k <= n else 0.0
        if k <= np_:
            left -= 2.0 * f[M.PUSH + k]
        f[at + M.COEF + k] = f[M.ECHO] * left
        size += abs(left)
    f[at + M.START], f[at + M.STOP], f[at + M.SIZE] = span[0], span[1], abs(f[M.ECHO]) * size
    q[q[M.NEW_DEGREES] + j], q[M.LEFT] = most, j + 1


@kernel
def _touched(f: Array, q: Counts, span: Span, np_: int) -> None:
    """Continue, begin or end an impact."""
    touching = f[q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT] + M.TOUCHING] > 0.0
    if not touching and q[M.OPEN] == 0:
        return
    start = f[M.TRANSIT] * (2.0 * q[M.TRIP] + span[0])
    if touching:
        if q[M.OPEN] == 0:
            q[M.OPEN], f[M.SINCE], f[M.IMPULSE], f[M.PEAK] = 1, start, 0.0, -math.inf
        f[M.UNTIL] = f[M.TRANSIT] * (2.0 * q[M.TRIP] + span[1])
        f[M.IMPULSE] += f[M.AREA] / f[M.MOBILITY] * mean(f, M.PUSH, np_) * (f[M.TRANSIT] * (span[1] - span[0]))
        f[M.PEAK] = peak(f, q, M.PUSH, np_, f[M.PEAK])
    else:
        at = q[M.OUT_IMPACTS] + M.IMPACT * q[M.IMPACTS]
        f[at], f[at + 1], f[at + 2], f[at + 3] = f[M.SINCE], start, f[M.IMPULSE], f[M.PEAK] / f[M.MOBILITY]
        q[M.IMPACTS], q[M.OPEN] = q[M.IMPACTS] + 1, 0


@kernel
def entered(f: Array, q: Counts) -> None:
    """Enter the round trip in the record, and in the energy balance.

    The balance, ``Z/4 int (W^2 - V^2) dt - k_L int z'^2 dt - A [P(z)]`` since the start, is zero in exact numbers.  The
    waves bring what they carry from ``x = 0`` and along the rod without change, so that an error of the motion can only
    be here: in the solution of ``z' = W - d p(z)`` and in the instants of contact and release.
    """
    w, crossings, error = q[M.WINDOWS], max(q[M.ARCS] - 1, 0), f[M.TRANSIT] * f[M.MISSED]
    at = q[M.OUT_MARKS] + M.MARKS * w
    q[at], q[at + 1], q[at + 2], q[at + 3] = q[M.SEGMENT], q[M.OPEN], crossings, q[M.IMPACTS]
    q[at + 4] = q[M.BEFORE]
    at = q[M.OUT_ENDINGS] + M.ENDINGS * w
    f[at], f[at + 1], f[at + 2], f[at + 3] = error, f[M.VALUE], f[M.REST], f[M.SINCE]
    f[at + 4], f[at + 5], f[at + 6] = f[M.UNTIL], f[M.IMPULSE], f[M.PEAK] / f[M.MOBILITY]
    q[M.WINDOWS] = w + 1
    f[M.ERROR] += error
    q[M.CROSSINGS] += crossings
    term = f[M.TERM]
    total = f[M.WORK] + term
    f[M.WORK_REST] += (f[M.WORK] - total) + term if abs(f[M.WORK]) >= abs(term) else (term - total) + f[M.WORK]
    f[M.WORK] = total
    energy = stored(f, q, f[q[M.LAW] + M.SEGMENT_SIZE * q[M.SEGMENT] + M.ORIGIN] + (f[M.VALUE] + f[M.REST]))
    f[M.WORST] = max(f[M.WORST], abs(f[M.WORK] + f[M.WORK_REST] - (energy - f[M.STORED])))
    f[M.ENERGY] = max(f[M.ENERGY], f[M.PASSED], abs(energy), abs(f[M.STORED]))


@kernel
def stored(f: Array, q: Counts, z: float) -> float:
    """``A P(z)`` [J]."""
    total = 0.0
    for j in range(q[M.SEGMENTS]):
        nonlinearity = q[M.LAW] + M.SEGMENT_SIZE * j
        rate, stress, origin, n = (
            f[nonlinearity + M.RATE],
            f[nonlinearity + M.STRESS],
            f[nonlinearity + M.ORIGIN],
            f[nonlinearity + M.POWER] + 1.0,
        )
        low, high = max(f[nonlinearity + M.LOW], min(0.0, z)), min(f[nonlinearity + M.HIGH], max(0.0, z))
        if low >= high or rate == math.inf or (rate == 0.0 and stress == 0.0):
            continue
        a, b = low - origin, high - origin
        area = stress * (b - a)
        if n == 2.0:
            area += rate * 0.5 * (b - a) * (b + a)
        else:
            area += rate * float(np.float64(max(b, 0.0)) ** n - np.float64(max(a, 0.0)) ** n) / n
        total += area if z > 0.0 else -area
    return float(f[M.AREA] * total / f[M.MOBILITY])


@kernel
def largest_wave(f: Array, q: Counts, pieces: int, at: int) -> None:
    """Enter the largest wave of the pieces that begin at a place."""
    for j in range(pieces):
        f[M.HIGHEST] = max(f[M.HIGHEST], f[at + (q[M.DEGREE] + 1 + M.COEF) * j + M.SIZE])


@kernel
def _turned(steps: tuple[int, int], lasted: float, turns: int, length: float) -> tuple[int, float, float]:
    """Turns so far and the next moment's length after a departure, and how long the segment entered is kept [transits].

    Where rounding sends the end to and fro between contact and flight at one instant: in a piece that is hardly wider
    than the rounding of time, each of two neighbouring segments of the nonlinearity may find that the end has just left
    it. After two departures back at once the segment entered is kept for a moment, twice as long each time that does
    not help: what this leaves out of ``z`` is at most the moment times the wave.

    Parameters
    ----------
    steps : tuple of int
        The step of the departure before this one, and of this one: 1 or -1.
    lasted : float
        Time between the two [transits].
    turns, length
        As they were returned; 0 and ``_FIRST`` at first.
    """
    if steps[0] != -steps[1] or lasted > _AT_ONCE * length:
        return 0, _FIRST, 0.0
    if turns + 1 < _TURNS:
        return turns + 1, length, 0.0
    return turns + 1, 2.0 * length, length
