r"""The motion window by window: each round trip ``2T`` the wave that left ``x = L`` is back, reflected and reinforced.

.. math:: W(t) = -a\,V(t - 2T) + 2 b\,g(t - T) + \ldots, \qquad z' = \frac{W}{1 + k_L/Z} - d\,p(z), \qquad V = 2 z' - W.

Times inside a window are kept apart from its number: an event stays at the same place, to the last bit, in all windows
in which its echoes pass, and free flight is a multiplication by ``-a``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from lure.errors import AssumptionError, InputError
from lure.rod.motion.chebyshev import Array, largest
from lure.rod.motion.crossing import first_crossing
from lure.rod.motion.end_law import EndLaw, Segment
from lure.rod.motion.impacts import Impact, Touch, with_touch
from lure.rod.motion.kernel_hold import FIRST, next_turn
from lure.rod.motion.pieces import SAME, Pieces, joined, merged, union
from lure.rod.motion.power_motion import power_arc
from lure.rod.motion.segment_motion import Arc, Level, departure, flat_arc, rigid_arc, straight_arc
from lure.rod.motion.sources import Sources

MERGE = 2e-15
_MOST_EVENTS = 4000
_LARGEST = 1e100


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Window:
    """One round trip.

    Attributes
    ----------
    number : int
        It spans ``2T number`` to ``2T number + span T``.
    edges : ndarray
        (m+1,) from 0 to ``span``, at most 2 [transits].
    wave, returned, push, z : ndarray
        (m, N+1) Chebyshev series on the pieces: ``W = r1(t, L)``, ``V = r2(t, L)``, ``d p`` [m/s] with ``d`` reduced by
        a dashpot at ``x = L``, and the contact coordinate [m].
    impacts : tuple of Impact
        Those that ended here.
    crossings : int
        Passages from one segment of the law to another.
    error : float
        Estimate of the local errors made here, as a change of ``V`` times its duration [m].
    end : State
        The end of the rod after this window.
    """

    number: int
    edges: Array
    wave: Array
    returned: Array
    push: Array
    z: Array
    impacts: tuple[Impact, ...]
    crossings: int
    error: float
    end: State


@dataclass(frozen=True, kw_only=True, slots=True)
class State:
    """Where the end of the rod is.

    Attributes
    ----------
    segment : int
        Segment of the law.
    zeta : Level
        ``z`` from the origin of the segment [m].
    impact : Impact or None
        The contact that goes on.
    """

    segment: int
    zeta: Level
    impact: Impact | None = None


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Problem:
    """What the windows of one motion share.

    Attributes
    ----------
    sources : Sources
        Loads and initial data.
    law : EndLaw
        The obstacle.
    share : float
        ``1/(1 + k_L/Z)``.
    transits : float
        Length of the motion in ``T``.
    """

    sources: Sources
    law: EndLaw
    share: float
    transits: float


def windows(problem: Problem) -> Iterator[Window]:
    """The windows one after the other; only the last is needed for the next.

    Raises
    ------
    InputError
        Data are not finite, or the end begins inside a rigid obstacle.
    AssumptionError
        There are more than 4000 events in one round trip.
    """
    sources = problem.sources
    state, scale = first_state(problem), 0.0
    wave, error = sources.initial_wave()
    merged_to = 8
    for number in range(math.ceil(problem.transits / 2.0)):
        span = min(2.0, problem.transits - 2.0 * number)
        scale = max(abs(sources.echo) * scale, largest(wave.series))
        if span < 2.0:
            wave = wave.on(np.append(wave.edges[wave.edges < span - SAME], span))
        added = sources.loads(number, span, scale)
        if added is not None:
            wave, load = joined(wave, added[0])
            wave = Pieces(wave.edges, wave.series + load.series)
            error += added[1]
        scale = max(scale, largest(wave.series))
        if not scale < _LARGEST:
            raise InputError(
                f"the wave in round trip {number} is {scale:.3g} m/s, more than {_LARGEST:g}; give smaller "
                "data or loads"
            )
        window = _window(problem, number, wave, state)
        state = window.end
        yield replace(window, error=window.error + error * sources.rod.travel_time)
        wave, error = Pieces(window.edges, sources.echo * window.returned), 0.0
        if len(wave.series) > 1.25 * merged_to:
            wave = merged(wave, MERGE * scale)
            merged_to, error = max(8, len(wave.series)), 2.0 * MERGE * scale


def first_state(problem: Problem) -> State:
    """Segment and place of the end at the start.

    Raises
    ------
    InputError
        It begins inside a rigid obstacle.
    """
    rod, segments = problem.sources.rod, problem.law.segments
    z = problem.sources.scenario.contact_coordinate(rod)
    if not z < _LARGEST:
        raise InputError(f"initial.u0 and rod.gap put the end at z = {z:.3g} m, beyond {_LARGEST:g}; give smaller data")
    j = max(next(i for i, segment in enumerate(segments) if z <= segment.high), 0)
    if math.isinf(segments[j].rate):
        raise InputError(
            f"initial.u0 and rod.gap put the end {z:.4g} m inside the obstacle, which is rigid; give a larger gap"
        )
    return State(segment=j, zeta=Level(value=z - segments[j].origin))


def _window(problem: Problem, number: int, wave: Pieces, state: State) -> Window:
    """One window: arcs of the segments, each up to the first crossing."""
    arcs: list[tuple[Segment, Arc]] = []
    segments, rest, end, zeta = problem.law.segments, wave, state.segment, state.zeta
    turns, moment, keep, last = 0, FIRST, 0.0, 0
    for _ in range(_MOST_EVENTS):
        if keep > 0.0:
            rest = rest.on(union(rest.edges, rest.edges[:1] + keep))
        arc = _arc(problem, segments[end], rest, zeta)
        if keep > 0.0:
            arc = replace(arc, error=arc.error + keep * largest(rest.series))
        found = _first_departure(segments[end], arc, float(rest.edges[0]) + keep)
        if found is None and arc.wave.edges[-1] < rest.edges[-1]:
            raise AssumptionError("the end of the rod leaves a power law too slowly to be followed; change the data")
        if found is None:
            arcs.append((segments[end], arc))
            return _collected(problem, number, arcs, (state, end, arc.end))
        step, instant = found
        if instant > rest.edges[0]:
            arcs.append((segments[end], _until(arc, instant)))
        bound = segments[end].high if step > 0 else segments[end].low
        end += step
        zeta = Level(value=bound - segments[end].origin)
        if instant >= rest.edges[-1]:
            return _collected(problem, number, arcs, (state, end, zeta))
        turns, moment, keep = next_turn((last, step), instant - float(rest.edges[0]), turns, moment)
        last, keep = step, keep if segments[end].power == 1.0 else 0.0
        rest = rest.on(np.append(instant, rest.edges[rest.edges > instant]))
    raise AssumptionError(
        f"the end passes from contact to flight {_MOST_EVENTS} times in round trip {number}, which is chattering; "
        "follow a shorter time"
    )


def _arc(problem: Problem, segment: Segment, wave: Pieces, zeta: Level) -> Arc:
    transit = problem.sources.rod.travel_time
    if math.isinf(segment.rate):
        return rigid_arc(problem.share, wave)
    if segment.power != 1.0:
        return power_arc(segment, problem.share, transit, wave, zeta)
    solve = flat_arc if segment.rate == 0.0 else straight_arc
    return solve(segment, problem.share, transit, wave, zeta)


def _first_departure(segment: Segment, arc: Arc, after: float) -> tuple[int, float] | None:
    """Step to the next segment and instant of the first departure on the pieces that begin after an instant."""
    functions, tolerance = departure(segment, arc)
    first = int(np.searchsorted(arc.wave.edges[:-1], after - SAME))
    best: tuple[int, float] | None = None
    for step, series in functions:
        crossing = first_crossing(series[first:], tolerance)
        if crossing is not None:
            i, x = first + crossing[0], crossing[1]
            low, high = float(arc.wave.edges[i]), float(arc.wave.edges[i + 1])
            instant = low + 0.5 * (high - low) * (x + 1.0)
            instant = low if instant - low <= SAME else high if high - instant <= SAME else instant
            if best is None or instant < best[1]:
                best = step, instant
    return best


def _until(arc: Arc, instant: float) -> Arc:
    edges = np.append(arc.wave.edges[arc.wave.edges < instant], instant)
    zeta, push = (Pieces(arc.wave.edges, series).on(edges).series for series in (arc.zeta, arc.push))
    return replace(arc, wave=arc.wave.on(edges), zeta=zeta, push=push)


def _collected(problem: Problem, number: int, arcs: list[tuple[Segment, Arc]], end: tuple[State, int, Level]) -> Window:
    """The arcs as one window, with the impacts they end."""
    rod = problem.sources.rod
    before, segment, zeta = end
    impact, ended = before.impact, []
    for piece, arc in arcs:
        start, stop = (rod.travel_time * (2.0 * number + float(arc.wave.edges[i])) for i in (0, -1))
        if piece.touching:
            touch = Touch(start=start, end=stop, widths=rod.travel_time * arc.wave.widths, push=arc.push)
            impact = with_touch(impact, touch, rod.area, rod.mobility * problem.share)
        elif impact is not None:
            ended.append(replace(impact, end=start, closed=True))
            impact = None
    wave, push, z = (
        np.concatenate(parts)
        for parts in zip(*((arc.wave.series, arc.push, _placed(piece, arc)) for piece, arc in arcs), strict=True)
    )
    return Window(
        number=number,
        edges=np.concatenate((arcs[0][1].wave.edges[:1], *(arc.wave.edges[1:] for _, arc in arcs))),
        wave=wave,
        returned=(2.0 * problem.share - 1.0) * wave - 2.0 * push,
        push=push,
        z=z,
        impacts=tuple(ended),
        crossings=len(arcs) - 1,
        error=rod.travel_time * sum(arc.error for _, arc in arcs),
        end=State(segment=segment, zeta=zeta, impact=impact),
    )


def _placed(segment: Segment, arc: Arc) -> Array:
    z = arc.zeta.copy()
    z[:, 0] += segment.origin
    return z
