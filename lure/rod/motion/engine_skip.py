"""How the memory of the compiled engine passes over a stretch of round trips."""

from __future__ import annotations

import numpy as np

from lure.rod.motion.chebyshev import Array
from lure.rod.motion.impacts import Impact
from lure.rod.motion.jit import plain
from lure.rod.motion.kernel_data import (
    COEF,
    COUNT,
    DEGREE,
    ECHO,
    ENERGY,
    ERROR,
    HIGHEST,
    LATER,
    MOBILITY,
    OLD,
    OLD_DEGREES,
    OPEN,
    PEAK,
    REST,
    SCALE,
    SEGMENT,
    SINCE,
    SIZE,
    START,
    STOP,
    STORED,
    TRANSIT,
    TRIP,
    VALUE,
    WORK,
    WORK_REST,
    WORST,
    Counts,
)
from lure.rod.motion.kernel_entry import stored
from lure.rod.motion.pieces import Pieces
from lure.rod.motion.quiet import Quietness
from lure.rod.motion.segment_motion import Level
from lure.rod.motion.windows import Problem, State


def at_hand(f: Array, q: Counts, impact: Impact | None) -> tuple[Pieces, State]:
    """What comes back in the next round trip, without its load, and the end of the rod."""
    table = _table(f, q)
    degrees = q[q[OLD_DEGREES] : q[OLD_DEGREES] + len(table), None]
    series = np.where(np.arange(q[DEGREE] + 1) <= degrees, table[:, COEF:], 0.0)
    zeta = Level(value=float(f[VALUE]), rest=float(f[REST]))
    wave = Pieces(np.append(table[:, START], table[-1, STOP]), series)
    return wave, State(segment=int(q[SEGMENT]), zeta=zeta, impact=impact)


def skipped(f: Array, q: Counts, problem: Problem, found: Quietness) -> None:
    """Put the motion after a stretch in the place of that before it, and enter what the stretch adds to the sums."""
    series, count, table = found.wave.series, len(found.stretch), _table(f, q)
    sizes = np.abs(series).sum(axis=1)
    table[:, SIZE], table[:, COEF:] = sizes, series
    q[q[OLD_DEGREES] : q[OLD_DEGREES] + len(series)] = found.stretch.powers.quiet.degree
    q[TRIP] += count
    f[VALUE], f[REST] = found.state.zeta.value, found.state.zeta.rest
    f[SCALE] = max(abs(f[ECHO]) ** count * f[SCALE], float(sizes.max()))
    if found.state.impact is not None:
        impact = found.state.impact
        q[OPEN] = 1
        f[SINCE : PEAK + 1] = impact.start, impact.end, impact.impulse, impact.peak_stress * f[MOBILITY]
    f[HIGHEST] = max(f[HIGHEST], found.largest)
    f[ERROR] += found.stretch.error * count + f[LATER] * f[TRANSIT]
    f[LATER] = 0.0
    _balanced(f, q, problem, found)


def _balanced(f: Array, q: Counts, problem: Problem, found: Quietness) -> None:
    """The energy balance."""
    stretch, zeta, term = found.stretch, found.state.zeta, found.work
    origin = problem.law.segments[found.state.segment].origin
    begun = float(stretch.states[0, stretch.powers.quiet.waves]) + float(stretch.rests[0])
    before = plain(stored)(f, q, origin + begun)
    after = plain(stored)(f, q, origin + (zeta.value + zeta.rest))
    off = f[WORK] + f[WORK_REST] - (before - f[STORED])
    f[WORST] = max(f[WORST], abs(off + found.imbalance[0]), abs(off + found.imbalance[1]))
    total = f[WORK] + term
    f[WORK_REST] += (f[WORK] - total) + term if abs(f[WORK]) >= abs(term) else (term - total) + f[WORK]
    f[WORK] = total
    f[ENERGY] = max(f[ENERGY], found.passed, abs(before), abs(after), abs(f[STORED]))


def _table(f: Array, q: Counts) -> Array:
    """The pieces of the wave that comes back (COUNT, COEF + N + 1), in their place."""
    count, width = int(q[COUNT]), int(q[DEGREE]) + 1 + COEF
    return f[q[OLD] : q[OLD] + count * width].reshape(count, width)
