"""Event-free round trips one after the other, as a loop over numbers or as products with a matrix; and their values."""

from __future__ import annotations

import math

import numpy as np

from lure.rod.motion.kernel_piece import local
from lure.rod.motion.kernel_series import (
    Counts,
    in_loops,
    kernel,
)
from lure.rod.motion.kernel_tables import (
    AFTER_,
    AT_HAND,
    BACK,
    BACK_P,
    BACK_W,
    BACK_Z,
    BEFORE_,
    BEGINS,
    DEPTH,
    EDGES,
    FROM,
    HALVES,
    HEAD,
    HIGHEST_,
    HOLD,
    HOLD_END,
    HOLD_FIRST,
    HOLD_MEAN,
    IMPULSE_NOW,
    LEVEL,
    LEVEL_END,
    LEVEL_FIRST,
    LEVEL_MEAN,
    LOADING,
    LOADS,
    NUMBER,
    OF_END,
    OF_FIRST,
    OF_MEAN,
    OWN,
    PIECES_,
    PUSHED,
    REST_NOW,
    SHARED,
    SOFT,
    STIFFNESS,
    STRIDE,
    TIME,
    TOP_DEGREE,
    TURNS,
    WAVES,
    WIDTH,
    ZETA_NOW,
    Memory,
)
from lure.rod.motion.pieces import Array, values
from lure.rod.motion.trip_matrix import Doubles, Layout, TripMatrix, trip_matrix

WAVE_, RETURNED_, PUSH_, Z_ = range(0, 4)
_CANCELLED = 4e-16


def _matrix(s: Array, d: Counts) -> TripMatrix:
    """The round trip as a matrix, made once."""
    made = getattr(s, "made", None)  # memory of compiled code that is run as it stands keeps none
    if made is None:
        whole, pieces, width = np.frombuffer(s).copy(), d[PIECES_], d[WIDTH]
        table = pieces * width
        tables = {
            name: whole[d[place] : d[place] + size]
            for name, place, size in (
                ("hold_end", HOLD_END, pieces),
                ("level_end", LEVEL_END, pieces),
                ("hold_mean", HOLD_MEAN, pieces),
                ("level_mean", LEVEL_MEAN, pieces),
                ("halves", HALVES, pieces),
                ("end", OF_END, table),
                ("mean", OF_MEAN, table),
                ("own", OWN, table * width),
                ("hold", HOLD, table),
                ("level", LEVEL, table),
                ("loads", LOADS, d[WAVES] - pieces - d[LOADS]),
            )
        }
        names = ("pushed", "stiffness", "back_w", "back_z", "back_p", "shared", "time", "loading")
        numbers = dict(zip(names, s[PUSHED : LOADING + 1], strict=True))
        made = trip_matrix(
            Layout(pieces=pieces, degree=d[TOP_DEGREE], depth=d[DEPTH], width=width, numbers=numbers, tables=tables)
        )
        if isinstance(s, Doubles):
            s.made = made
    return made


@kernel
def turned(s: Array, d: Counts, force: Array, number: int) -> None:
    """The exponentials of a round trip, and their factors from each to the next."""
    at, turn = 1, d[TURNS]
    for _ in range(int(force[0])):
        re, im = 2.0 * force[at], 2.0 * force[at + 1]
        grown, step = math.exp(re * number), math.exp(re)
        s[turn], s[turn + 1] = grown * math.cos(im * number), grown * math.sin(im * number)
        s[turn + 2], s[turn + 3] = step * math.cos(im), step * math.sin(im)
        at, turn = at + 3 + 2 * (int(force[at + 2]) + 1), turn + 4


@in_loops(lambda *_: _loaded_in_loops)
def loaded(s: Array, d: Counts, force: Array, number: int) -> None:
    """The wave of a round trip: what comes back, and its load."""
    step, whole = _matrix(s, d), np.frombuffer(s)
    back = whole[d[BACK] : d[BACK] + len(step.matrix) - 2]
    whole[d[WAVES] : d[WAVES] + len(back)] = back + step.loads(force, np.array([float(number)]))[0]


@kernel
def _loaded_in_loops(s: Array, d: Counts, force: Array, number: int) -> None:
    """The same, a number at a time, the exponentials at hand."""
    table, at, turn = (d[TOP_DEGREE] + 1) * d[PIECES_], 1, d[TURNS]
    column, more, trip = d[LOADS], d[WIDTH] * d[PIECES_], float(number)
    w, back = s[d[WAVES] : d[WAVES] + table], s[d[BACK] : d[BACK] + table]
    for i in range(table):
        w[i] = back[i]
    for _ in range(int(force[0])):
        a, b, power = s[turn], s[turn + 1], int(force[at + 2])
        other = 0 if force[at + 1] == 0.0 else more
        for _k in range(power + 1):
            real, imaginary = s[column : column + table], s[column + other : column + other + table]
            if other == 0:
                b = 0.0
            for i in range(table):
                w[i] += a * real[i] + b * imaginary[i]
            column += more + other
            a, b = a * trip, b * trip
        at, turn = at + 3 + 2 * (power + 1), turn + 4


@kernel
def begun(s: Array, d: Counts) -> None:
    """Enter where ``zeta`` begins on each piece of the round trip at hand, and at its end."""
    pieces, table, w, e = d[PIECES_], (d[TOP_DEGREE] + 1) * d[PIECES_], d[WAVES], d[OF_END]
    value, travelled = s[ZETA_NOW], s[REST_NOW]
    for p in range(pieces):
        start = value + travelled
        s[d[BEGINS] + p] = start
        way = s[d[LEVEL_END] + p] + s[d[HOLD_END] + p] * start
        for i in range(p, table, pieces):
            way += s[e + i] * s[w + i]
        travelled += way
    s[d[BEGINS] + pieces] = value + travelled


@kernel
def _stepped(s: Array, d: Counts, force: Array) -> None:
    """The exponentials of the next round trip."""
    at, turn = 1, d[TURNS]
    for _ in range(int(force[0])):
        u, v = s[turn], s[turn + 1]
        s[turn], s[turn + 1] = u * s[turn + 2] - v * s[turn + 3], u * s[turn + 3] + v * s[turn + 2]
        at, turn = at + 3 + 2 * (int(force[at + 2]) + 1), turn + 4


@in_loops(lambda *_: _advanced_in_loops)
def advanced(memory: Memory, m: int, keep: int) -> None:
    """Go some round trips on; enter the states before each if they are to be kept, and the largest ``zeta`` at an edge.

    As whole arrays, for code that is not compiled; compiled code does the same in loops.
    """
    s, d, force, states = memory
    step = _matrix(s, d)
    T, first, whole = len(step.matrix) - 2, int(s[AT_HAND]), np.frombuffer(s)
    W = np.empty((m + 1, T))
    W[0] = whole[d[WAVES] : d[WAVES] + T]
    loads = step.loads(force, d[NUMBER] + first + 1 + np.arange(m, dtype=float))
    value, rest, impulse = s[ZETA_NOW], s[REST_NOW], s[IMPULSE_NOW]
    heads = np.empty((m, HEAD))
    back = W[0]
    for i in range(m):
        heads[i] = value, rest, impulse
        found = step.matrix @ W[i]
        found += (value + rest) * step.held
        found += step.level
        back = found[:T]
        travel = float(found[T]) + rest
        if abs(travel - rest) <= _CANCELLED * step.ways(W[i]):
            travel = rest
        impulse += float(found[T + 1])
        total = value + travel
        undone = total - value
        value, rest = total, (value - (total - undone)) + (travel - undone)
        W[i + 1] = back + loads[i]
    whole[d[BACK] : d[BACK] + T], whole[d[WAVES] : d[WAVES] + T] = back, W[m]
    s[HIGHEST_] = float(step.starts(heads, W[:m]).max())
    if keep:
        rows = np.frombuffer(states)
        kept = np.flatnonzero((first + np.arange(m)) % d[STRIDE] == 0)
        low, size = (first + d[STRIDE] - 1) // d[STRIDE], HEAD + T
        rows[low * size : (low + len(kept)) * size] = np.hstack((heads, W[:m]))[kept].ravel()
    s[ZETA_NOW], s[REST_NOW], s[IMPULSE_NOW], s[AT_HAND] = value, rest, impulse, first + m


@kernel
def _advanced_in_loops(memory: Memory, m: int, keep: int) -> None:
    """The same, a number at a time."""
    s, d, force, states = memory
    P, T = d[PIECES_], (d[TOP_DEGREE] + 1) * d[PIECES_]
    o = d[WAVES]
    # slices, whose places are known not to be negative
    w, left, right = s[o : o + T], s[o - P : o - P + T], s[o + P : o + P + T]
    b, end, first = s[d[BACK] : d[BACK] + T], s[d[OF_END] : d[OF_END] + T], s[d[OF_FIRST] : d[OF_FIRST] + T]
    mean_, before, after = (
        s[d[OF_MEAN] : d[OF_MEAN] + T],
        s[d[BEFORE_] : d[BEFORE_] + T],
        s[d[AFTER_] : d[AFTER_] + T],
    )
    hold_end, level_end = s[d[HOLD_END] : d[HOLD_END] + P], s[d[LEVEL_END] : d[LEVEL_END] + P]
    hold_first, level_first = s[d[HOLD_FIRST] : d[HOLD_FIRST] + P], s[d[LEVEL_FIRST] : d[LEVEL_FIRST] + P]
    hold_mean, level_mean = s[d[HOLD_MEAN] : d[HOLD_MEAN] + P], s[d[LEVEL_MEAN] : d[LEVEL_MEAN] + P]
    begins, halves = s[d[BEGINS] : d[BEGINS] + P + 1], s[d[HALVES] : d[HALVES] + P]
    back, slope, constant, now = s[BACK_W], s[BACK_Z], s[BACK_P], int(s[AT_HAND])
    value, rest, impulse, highest, straight = s[ZETA_NOW], s[REST_NOW], s[IMPULSE_NOW], -math.inf, slope != 0.0
    mask, at, soft, width = d[STRIDE] - 1, (now + d[STRIDE] - 1) // d[STRIDE] * (HEAD + T), d[SOFT] != 0, d[WIDTH]
    # one rate without a power of time is the rule; its columns and exponential stay at hand
    single, more = force[0] == 1.0 and force[3] == 0.0, d[WIDTH] * P if force[0] > 0.0 and force[2] != 0.0 else 0
    real = s[d[LOADS] : d[LOADS] + T] if single else w
    imaginary = s[d[LOADS] + more : d[LOADS] + more + T] if single else w
    held, level = s[d[HOLD] : d[HOLD] + P * width], s[d[LEVEL] : d[LEVEL] + P * width]
    turn, share, constant_impulse = d[TURNS], 2.0 * s[LOADING] * s[STIFFNESS], 2.0 * s[LOADING] * s[PUSHED] * s[TIME]
    u, v = s[turn], s[turn + 1]
    for _ in range(m):
        if keep != 0 and (now & mask) == 0:
            row = states[at : at + HEAD + T]
            row[0], row[1], row[2] = value, rest, impulse
            for i in range(T):
                row[HEAD + i] = w[i]
            at += HEAD + T
        travelled, ways, total = rest, 0.0, 0.0
        if not straight:
            for i in range(T):
                part_ = end[i] * w[i]
                travelled += part_
                ways += abs(part_)
                b[i] = back * w[i]
            for p in range(P):
                travelled += level_end[p]
                b[p] += constant
            highest = max(highest, value, value + travelled)
        else:
            if soft:
                for i in range(P, T):
                    b[i] = back * w[i] + (before[i] * left[i] + after[i] * right[i])
            for p in range(P):
                start = value + travelled
                begins[p] = start
                way = level_end[p] + hold_end[p] * start
                z, average = level_first[p] + hold_first[p] * start, level_mean[p] + hold_mean[p] * start
                for i in range(p, T, P):
                    x = w[i]
                    way += end[i] * x
                    z += first[i] * x
                    average += mean_[i] * x
                travelled += way
                total += average * halves[p]
                highest = max(highest, start)
                b[p] = back * w[p] + (slope * z + constant)
                if soft:
                    b[P + p] += slope * (held[p * width + 1] * start + level[p * width + 1])
            if not soft:
                for p in range(P):
                    for k in range(1, d[TOP_DEGREE] + 1):
                        b[k * P + p] = back * w[k * P + p] + slope * coefficient(s, d, p, k)
        if not straight and abs(travelled - rest) <= _CANCELLED * ways:  # ways there and back
            travelled = rest
        impulse += share * total + constant_impulse
        total = value + travelled
        undone = total - value
        value, rest = total, (value - (total - undone)) + (travelled - undone)
        now += 1
        if (now & 63) == 0:
            turned(s, d, force, d[NUMBER] + now)
            u, v = s[turn], s[turn + 1]
        elif single:
            u, v = u * s[turn + 2] - v * s[turn + 3], u * s[turn + 3] + v * s[turn + 2]
        else:
            _stepped(s, d, force)
        if single:
            for i in range(T):
                w[i] = b[i] + (u * real[i] + v * imaginary[i])
        else:
            _loaded_in_loops(s, d, force, d[NUMBER] + now)
    if single:
        s[turn], s[turn + 1] = u, v
    s[ZETA_NOW], s[REST_NOW], s[IMPULSE_NOW], s[AT_HAND], s[HIGHEST_] = value, rest, impulse, now, highest


@kernel
def coefficient(s: Array, d: Counts, p: int, k: int) -> float:
    """A coefficient of ``zeta`` on a piece of the round trip at hand."""
    pieces, own = d[PIECES_], d[OWN] + (p * d[WIDTH] + k) * d[WIDTH]
    total = s[d[HOLD] + p * d[WIDTH] + k] * s[d[BEGINS] + p] + s[d[LEVEL] + p * d[WIDTH] + k]
    for j in range(d[TOP_DEGREE] + 1):
        total += s[own + j] * s[d[WAVES] + j * pieces + p]
    return float(total)


@kernel
def reached(s: Array, d: Counts, force: Array, states: Array, trip: int) -> None:
    """A round trip at hand, counted from the first: the nearest state before it that is kept, and steps from there."""
    now, row = int(s[AT_HAND]), trip // d[STRIDE]
    if now > trip or now < row * d[STRIDE]:
        table, now = (d[TOP_DEGREE] + 1) * d[PIECES_], row * d[STRIDE]
        at = row * (HEAD + table)
        s[ZETA_NOW], s[REST_NOW], s[IMPULSE_NOW], s[AT_HAND] = states[at], states[at + 1], states[at + 2], now
        s[d[WAVES] : d[WAVES] + table] = states[at + HEAD : at + HEAD + table]
        if d[STRIDE] > 1:
            turned(s, d, force, d[NUMBER] + now)
    if now < trip:
        advanced((s, d, force, states), trip - now, 0)
    begun(s, d)


def sampled(memory: Memory, given: tuple[Array, Array], count: int, name: int) -> None:
    """Values at instants [transits] in so many round trips, in the second array; on an edge those from the right."""
    _sampled(memory, given, count, name)


@in_loops(lambda *_: _sampled_in_loops)
def _sampled(memory: Memory, given: tuple[Array, Array], count: int, name: int) -> None:
    """As whole arrays, for code that is not compiled."""
    s, d, force, states = memory
    (t, out), step = given, _matrix(s, d)
    T, P, n = len(step.matrix) - 2, d[PIECES_], d[TOP_DEGREE]
    trip = np.clip(np.floor(0.5 * t).astype(np.int64) - d[NUMBER], 0, count - 1)
    place = t - 2.0 * (trip + d[NUMBER])
    if d[STRIDE] == 1:
        X = np.frombuffer(states)[: (int(trip.max(initial=0)) + 1) * (HEAD + T)].reshape(-1, HEAD + T)[trip]
    else:
        X = np.empty((len(t), HEAD + T))
        for i in np.argsort(trip, kind="stable").tolist():
            reached(s, d, force, states, int(trip[i]))
            X[i, :HEAD] = s[ZETA_NOW], s[REST_NOW], s[IMPULSE_NOW]
            X[i, HEAD:] = np.frombuffer(s)[d[WAVES] : d[WAVES] + T]
    edges, all_ = np.frombuffer(s)[d[EDGES] : d[EDGES] + P + 1], np.arange(len(t))
    piece = np.clip(np.searchsorted(edges, place, side="right") - 1, 0, P - 1)
    low, high = edges[piece], edges[piece + 1]
    x = np.clip(((place - low) - (high - place)) / (high - low), -1.0, 1.0)
    own = X[:, HEAD:].reshape(-1, n + 1, P)[all_, :, piece]
    wave = values(own, x[:, None])[:, 0]
    if name == WAVE_:
        out[:] = wave
        return
    start = step.starts(X[:, :HEAD], X[:, HEAD:])[all_, piece]
    series = np.einsum("ikj,ij->ik", step.own[piece], own) + step.hold[piece] * start[:, None] + step.constant[piece]
    zeta = values(series, x[:, None])[:, 0]
    push = s[PUSHED] + s[STIFFNESS] * zeta
    out[:] = s[FROM] + zeta if name == Z_ else push if name == PUSH_ else (2.0 * s[SHARED] - 1.0) * wave - 2.0 * push


@kernel
def _sampled_in_loops(memory: Memory, given: tuple[Array, Array], count: int, name: int) -> None:
    """The same, a number at a time."""
    s, d, force, states = memory
    (t, out), pieces, edges, depth = given, d[PIECES_], d[EDGES], d[DEPTH]
    for i in range(len(t)):
        trip = min(max(math.floor(0.5 * t[i]) - d[NUMBER], 0), count - 1)
        place, p = t[i] - 2.0 * (trip + d[NUMBER]), 0
        if trip != s[AT_HAND]:
            reached(s, d, force, states, trip)
        while p + 1 < pieces and s[edges + p + 1] <= place:
            p += 1
        x = local(place, s[edges + p], s[edges + p + 1])
        wave, before, w = 0.0, 0.0, d[WAVES] + p
        for k in range(d[TOP_DEGREE], 0, -1):
            wave, before = 2.0 * x * wave - before + s[w + k * pieces], wave
        wave = x * wave - before + s[w]
        if name == WAVE_:
            out[i] = wave
            continue
        zeta, before = 0.0, 0.0
        for k in range(depth - 1, 0, -1):
            zeta, before = 2.0 * x * zeta - before + coefficient(s, d, p, k), zeta
        zeta = x * zeta - before + coefficient(s, d, p, 0)
        push = s[PUSHED] + s[STIFFNESS] * zeta
        returned = (2.0 * s[SHARED] - 1.0) * wave - 2.0 * push
        out[i] = s[FROM] + zeta if name == Z_ else push if name == PUSH_ else returned


def unrolled(memory: Memory, first: int, stop: int, out: Array) -> None:
    """The states of consecutive round trips, counted from the first, and the one after them."""
    s, d, force, states = memory
    size = HEAD + (d[TOP_DEGREE] + 1) * d[PIECES_]
    for trip in range(first, stop + 1):
        if trip < stop:
            reached(s, d, force, states, trip)
        else:
            advanced(memory, 1, 0)
            begun(s, d)
        at = (trip - first) * size
        out[at], out[at + 1], out[at + 2] = s[ZETA_NOW], s[REST_NOW], s[IMPULSE_NOW]
        for i in range(size - HEAD):
            out[at + HEAD + i] = s[d[WAVES] + i]
