"""Round trips one after the other in compiled code: the rules are those of ``windows.py``."""

from __future__ import annotations

from lure.rod.motion.chebyshev import Array
from lure.rod.motion.jit import compiled, kept
from lure.rod.motion.kernel_crossing import NEVER, UNDECIDED
from lure.rod.motion.kernel_data import (
    ARCS,
    BEFORE,
    COEF,
    COUNT,
    DEGREE,
    HIGH,
    LARGEST,
    LAW,
    LEFT,
    LOW,
    MERGED,
    MISSED,
    MOST_WINDOWS,
    NEW,
    NEW_DEGREES,
    NOW,
    NOW_DEGREES,
    OLD,
    OLD_DEGREES,
    ORIGIN,
    PASSED,
    PIECES,
    PUSH,
    RATE,
    REST,
    SAVED,
    SAVED_F,
    SCALE,
    SEGMENT,
    SEGMENT_SIZE,
    START,
    STATE,
    STOP,
    TERM,
    TRANSIT,
    TRANSITS,
    TRIP,
    VALUE,
    WAVE,
    WINDOWS,
    ZERO,
    ZETA,
    Counts,
)
from lure.rod.motion.kernel_entry import emitted, entered, largest_wave
from lure.rod.motion.kernel_hold import FIRST, next_turn
from lure.rod.motion.kernel_incoming import NO_ROOM, SAME, cut_out, incoming
from lure.rod.motion.kernel_merge import merged
from lure.rod.motion.kernel_piece import begun, departure, moved, roughness, settled, solved
from lure.rod.motion.kernel_series import short_part

DONE, FULL, CHATTER, NEAR, HUGE = 0, 1, 2, 3, 4
_MOST_EVENTS = 4000
_MOST_CUTS = 2000
_NARROWEST = 1e-13
_LAYER = 3.0
_LARGEST = 1e100
_turned = compiled(next_turn)


@kept
def run(f: Array, q: Counts, load: Array, heads: Counts, stop: int) -> int:
    """Go on to round trip ``stop`` or as far as there is room; ``DONE``, ``FULL`` or why it does not go on."""
    while q[TRIP] < stop:
        if q[WINDOWS] == q[MOST_WINDOWS]:
            return FULL
        for k in range(WAVE):
            f[SAVED_F + k] = f[k]
        for k in range(STATE):
            q[SAVED + k] = q[k]
        found = _window(f, q, load, heads)
        if found == HUGE:
            return found
        if found != DONE:
            for k in range(WAVE):
                f[k] = f[SAVED_F + k]
            for k in range(STATE):
                q[k] = q[SAVED + k]
            return found
    return DONE


@compiled
def _window(f: Array, q: Counts, load: Array, heads: Counts) -> int:
    f[TERM], f[PASSED], q[ARCS], q[LEFT] = 0.0, 0.0, 0, 0
    pieces = incoming(f, q, load, heads, min(2.0, f[TRANSITS] - 2.0 * q[TRIP]))
    if pieces == NO_ROOM:
        return FULL
    if not f[SCALE] < _LARGEST:
        return HUGE
    largest_wave(f, q, pieces, q[NOW])
    q[BEFORE] = q[PIECES]
    found = _followed(f, q, pieces)
    if found != DONE:
        return found
    settled(f, q)
    entered(f, q)
    q[COUNT], q[TRIP] = q[LEFT], q[TRIP] + 1
    q[OLD], q[NEW] = q[NEW], q[OLD]
    q[OLD_DEGREES], q[NEW_DEGREES] = q[NEW_DEGREES], q[OLD_DEGREES]
    if q[COUNT] > 1.25 * q[MERGED]:
        before = 2 * q[COUNT]
        while q[COUNT] < 0.9 * before:
            before = q[COUNT]
            merged(f, q)
    return DONE


@compiled
def _followed(f: Array, q: Counts, pieces: int) -> int:
    """Arc after arc, piece after piece."""
    i, at, cuts, events, fresh, layer = ZERO, q[NOW], 0, 0, True, 2.0
    low = f[at + START]
    # when the arc began, until when it is kept; see kernel_hold.py
    since, until, last, turns, moment = low, low, 0, 0, FIRST
    begun(f, q, pieces, i, low)
    while i < pieces:
        stop, degree = f[at + STOP], q[q[NOW_DEGREES] + i]
        high = until if low + SAME < until < stop - SAME else stop
        n = cut_out(f, q, (at, degree), (low, high), WAVE)
        nz, np_ = solved(f, q, n, high - low)
        rough = roughness(f, q, n, nz)
        rate = f[q[LAW] + SEGMENT_SIZE * q[SEGMENT] + RATE]
        if fresh:
            layer, fresh = _LAYER / (rate * f[TRANSIT]) if rate > 0.0 else 2.0, False
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
        if x == NEVER:
            if not emitted(f, q, (low, high), (n, nz, np_)):
                return FULL
            moved(f, q, nz)
        else:
            instant = low + 0.5 * (high - low) * (x + 1.0)
            instant = low if instant - low <= SAME else high if high - instant <= SAME else instant
            if instant > low and not _shortened(f, q, (low, instant), (n, nz, np_), x if instant < high else 1.0):
                return FULL
            _passed(f, q, step)
            turns, moment, keep = _turned((last, step), instant - since, turns, moment)
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


@compiled
def _shortened(f: Array, q: Counts, span: tuple[float, float], degrees: tuple[int, int, int], x: float) -> bool:
    """Enter the part of the piece up to the place ``x``; whether there was room."""
    (n, nz, np_), cut = degrees, (-1.0, x)
    if x < 1.0:
        n = short_part(f, q, (WAVE, n), cut, WAVE)
        nz = short_part(f, q, (ZETA, nz), cut, ZETA)
        np_ = short_part(f, q, (PUSH, np_), cut, PUSH)
    return emitted(f, q, span, (n, nz, np_))


@compiled
def _passed(f: Array, q: Counts, step: int) -> None:
    """To the next segment of the law, at the bound between."""
    law = q[LAW] + SEGMENT_SIZE * q[SEGMENT]
    bound = f[law + HIGH] if step > 0 else f[law + LOW]
    q[SEGMENT] += step
    f[VALUE], f[REST] = bound - f[q[LAW] + SEGMENT_SIZE * q[SEGMENT] + ORIGIN], 0.0
