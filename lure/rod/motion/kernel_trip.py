"""Round trips one after the other: the wave that comes back with its loads, arcs and pieces, and what is kept of them.

Each round trip ``2T`` the wave that left ``x = L`` is back, reflected and reinforced.  Times inside a round trip are
kept apart from its number: an event stays at the same place, to the last bit, in all round trips in which its echoes
pass, and free flight is a multiplication by ``-a``.
"""

from __future__ import annotations

import math

import numpy as np

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
    ARCS,
    AREA,
    BEFORE,
    BEGUN,
    BLOCK,
    COEF,
    COUNT,
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
    INNER,
    LARGEST,
    LATER,
    LAW,
    LEFT,
    LOW,
    MARKS,
    MERGED,
    MISSED,
    MOBILITY,
    MOST_NUMBERS,
    MOST_PIECES,
    NEVER,
    NEW,
    NEW_DEGREES,
    NODES,
    NOISE,
    NOW,
    NOW_DEGREES,
    NUMBERS,
    OLD,
    OLD_DEGREES,
    OPEN,
    ORIGIN,
    OUT_ENDINGS,
    OUT_ENDS,
    OUT_IMPACTS,
    OUT_MARKS,
    OUT_NUMBERS,
    OUT_PIECES,
    PANEL,
    PART,
    PASSED,
    PEAK,
    PIECE,
    PIECES,
    POWER,
    PUSH,
    RATE,
    REST,
    ROOM,
    SCALE,
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
    UNDECIDED,
    UNTIL,
    VALUE,
    WAVE,
    WINDOWS,
    WORK,
    WORK_REST,
    WORST,
    ZERO,
    ZETA,
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
    i, at, cuts, events, fresh, layer = ZERO, q[NOW], 0, 0, True, 2.0
    low = f[at + START]
    # when the arc began, until when it is kept; see _turned
    since, until, last, turns, moment = low, low, 0, 0, _FIRST
    begun(f, q, pieces, i, low)
    while i < pieces:
        stop, degree = f[at + STOP], q[q[NOW_DEGREES] + i]
        high = until if low + SAME < until < stop - SAME else stop
        nonlinearity = q[LAW] + SEGMENT_SIZE * q[SEGMENT]
        rate, rough, n, nz, np_, curved = f[nonlinearity + RATE], 0.0, 0, 0, 0, False
        if powers is not None:
            curved = f[nonlinearity + POWER] != 1.0
            if curved:
                found, high, n = against_power(f, q, (at, degree), (low, high))
                if found != SOLVED:
                    return STIFF if found == TOO_STIFF else MANY
                nz, np_ = q[DEGREE], q[DEGREE]
        if not curved:
            n = cut_out(f, q, (at, degree), (low, high), WAVE)
            nz, np_ = solved(f, q, n, high - low)
            rough = roughness(f, q, n, nz)
        if fresh:
            layer, fresh = _LAYER / max(rate * f[TRANSIT], 1e-300) if rate > 0.0 else 2.0, False
        while rough > 0.0 and cuts < _MOST_CUTS and high - low > _NARROWEST:
            high = low + (layer if high - low > 1.01 * layer else 0.5 * (high - low))
            cuts += 1
            n = cut_out(f, q, (at, degree), (low, high), WAVE)
            nz, np_ = solved(f, q, n, high - low)
            rough = roughness(f, q, n, nz)
            layer = 2.0 * (high - low)
        if rough > 0.0:
            f[MISSED] += rate * rough * (high - low)
        step, x = departure(f, q, nz, np_) if low >= until - SAME else (0, NEVER)
        if x == UNDECIDED:
            return NEAR
        instant = high
        if x != NEVER:
            instant = low + 0.5 * (high - low) * (x + 1.0)
            instant = low if instant - low <= SAME else high if high - instant <= SAME else instant
            if low < instant < high:
                n, nz, np_ = _shortened(f, q, (n, nz, np_), x)
        if instant > low and not emitted(f, q, (low, instant), (n, nz, np_)):
            return FULL
        if x == NEVER:
            moved(f, q, nz)
        else:
            _passed(f, q, step)
            turns, moment, keep = _turned((last, step), instant - since, turns, moment)
            if f[q[LAW] + SEGMENT_SIZE * q[SEGMENT] + POWER] != 1.0:
                keep = 0.0
            since, until, last = instant, instant + keep, step
            f[MISSED] += keep * f[LARGEST]
            events, high = events + 1, instant
            if events >= _MOST_EVENTS:
                return CHATTER
        low = high
        if high >= stop:
            i, at, cuts, fresh = i + 1, at + q[DEGREE] + 1 + COEF, 0, True
        if x != NEVER:
            cuts, fresh = 0, True
            begun(f, q, pieces, i, low)
    return DONE


@kernel
def _shortened(f: Array, q: Counts, degrees: Degrees, x: float) -> Degrees:
    """Leave of the series of the piece the part up to the place ``x``; its degrees."""
    n, nz, np_ = degrees
    return (
        short_part(f, q, (WAVE, n), (-1.0, x), WAVE),
        short_part(f, q, (ZETA, nz), (-1.0, x), ZETA),
        short_part(f, q, (PUSH, np_), (-1.0, x), PUSH),
    )


@kernel
def _passed(f: Array, q: Counts, step: int) -> None:
    """To the next segment of the nonlinearity, at the bound between."""
    nonlinearity = q[LAW] + SEGMENT_SIZE * q[SEGMENT]
    bound = f[nonlinearity + HIGH] if step > 0 else f[nonlinearity + LOW]
    q[SEGMENT] += step
    f[VALUE], f[REST] = bound - f[q[LAW] + SEGMENT_SIZE * q[SEGMENT] + ORIGIN], 0.0


@kernel
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


@kernel
def incoming(f: Array, q: Counts, loads: tuple[Array, Counts], span: float) -> int:
    """Fill the wave of the round trip; the number of pieces, or ``NO_ROOM``.  ``heads``: see :mod:`sources`."""
    load, heads = loads
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


@kernel
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


@kernel
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


@kernel
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


@kernel
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


@kernel
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


@kernel
def entered(f: Array, q: Counts) -> None:
    """Enter the round trip in the record, and in the energy balance.

    The balance, ``Z/4 int (W^2 - V^2) dt - k_L int z'^2 dt - A [P(z)]`` since the start, is zero in exact numbers.  The
    waves bring what they carry from ``x = 0`` and along the rod without change, so that an error of the motion can only
    be here: in the solution of ``z' = W - d p(z)`` and in the instants of contact and release.
    """
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


@kernel
def stored(f: Array, q: Counts, z: float) -> float:
    """``A P(z)`` [J]."""
    total = 0.0
    for j in range(q[SEGMENTS]):
        nonlinearity = q[LAW] + SEGMENT_SIZE * j
        rate, stress, origin, n = (
            f[nonlinearity + RATE],
            f[nonlinearity + STRESS],
            f[nonlinearity + ORIGIN],
            f[nonlinearity + POWER] + 1.0,
        )
        low, high = max(f[nonlinearity + LOW], min(0.0, z)), min(f[nonlinearity + HIGH], max(0.0, z))
        if low >= high or rate == math.inf or (rate == 0.0 and stress == 0.0):
            continue
        a, b = low - origin, high - origin
        area = stress * (b - a)
        if n == 2.0:
            area += rate * 0.5 * (b - a) * (b + a)
        else:
            area += rate * float(np.float64(max(b, 0.0)) ** n - np.float64(max(a, 0.0)) ** n) / n
        total += area if z > 0.0 else -area
    return float(f[AREA] * total / f[MOBILITY])


@kernel
def largest_wave(f: Array, q: Counts, pieces: int, at: int) -> None:
    """Enter the largest wave of the pieces that begin at a place."""
    for j in range(pieces):
        f[HIGHEST] = max(f[HIGHEST], f[at + (q[DEGREE] + 1 + COEF) * j + SIZE])


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
