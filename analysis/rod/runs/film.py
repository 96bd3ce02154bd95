"""What a picture of the whole rod needs: a stretch of time short enough for its waves to be seen, and the fields."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.runs.exact import along_motion
from lure.analysis.rod.runs.request import Performed
from lure.analysis.rod.runs.sampled import Along, SampledRun
from lure.errors import InputError
from lure.rod.motion import Motion

Array = NDArray[np.float64]

MOST_TRANSITS = 80
_USUAL_TRANSITS = 10
_PLACES = 201
_TRACE = 2001
_FEWEST = 4  # samples in a transit below which waves are no longer seen


@dataclass(frozen=True, kw_only=True, eq=False)
class Film:
    """A stretch of a motion, along the whole rod.

    Attributes
    ----------
    run : SampledRun
        The motion, for its name, evidence, rod and contacts.
    t : ndarray
        (frames,) instants [s].
    along : Along
        Fields at these instants.
    trace_t, trace_u : ndarray
        (n,) instants [s] and ``u(t, L)`` [m], more closely.
    """

    run: SampledRun
    t: Array
    along: Along
    trace_t: Array
    trace_u: Array


def film(done: Performed, span: tuple[float, float] | None, *, frames: int, displaced: bool = True) -> Film:
    """A stretch of a motion to draw.

    Parameters
    ----------
    done : Performed
        The motion; without an exact one the samples must have fields.
    span : (float, float) or None
        First and last instant [s]; by default all if that is at most 15 transits, else 10 transits around the contact
        of largest impulse, or from the start.
    frames : int
        Number of frames; at most so many where there are samples only.
    displaced : bool
        Whether the displacement is needed, too.

    Raises
    ------
    InputError
        The span is empty, leaves the motion or is longer than 80 transits, or the samples are too far apart.
    """
    first, last = span or usual_span(done.run)
    check_span((first, last), done.run.until, done.run.rod.travel_time)
    if done.motion is not None:
        fields = partial(along_motion, done.motion, displaced=displaced)
        return _of_motion(done.motion, done.run, np.linspace(first, last, frames), fields)
    return _of_samples(done.run, (first, last), frames)


def usual_span(run: SampledRun) -> tuple[float, float]:
    """All of a short motion; of a long one ten transits around the contact of largest impulse, or from the start.

    Parameters
    ----------
    run : SampledRun
        The motion.
    """
    length = _USUAL_TRANSITS * run.rod.travel_time
    if run.until <= 1.5 * length * (1.0 + 1e-12):
        return 0.0, run.until
    if not run.impacts:
        return 0.0, length
    strongest = max(run.impacts, key=lambda impact: -1.0 if math.isnan(impact.impulse) else impact.impulse)
    first = min(max(0.0, strongest.start - length / 3.0), run.until - length)
    return first, first + length


def check_span(span: tuple[float, float], until: float, transit: float | None = None) -> None:
    """Refuse a stretch of time that cannot be drawn.

    Parameters
    ----------
    span : (float, float)
        First and last instant [s].
    until : float
        End of the motion [s].
    transit : float, optional
        ``T`` [s], if the whole rod is to be drawn.

    Raises
    ------
    InputError
        It is empty, leaves the motion or is too long for the waves to be seen.
    """
    first, last = span
    if not 0.0 <= first < last <= until:
        raise InputError(f"span is {first:g} to {last:g} s; give two instants in order in [0, {until:g}] s")
    if transit is not None and last - first > MOST_TRANSITS * transit * (1.0 + 1e-12):
        raise InputError(
            f"span is {first:g} to {last:g} s, {(last - first) / transit:.3g} transits of the rod; a picture shows the "
            f"waves of at most {MOST_TRANSITS}, give at most {MOST_TRANSITS * transit:.3g} s"
        )


def check_samples_seen(samples: int, until: float, transit: float) -> None:
    """Refuse samples too far apart for the waves to be seen in a picture made of them.

    Parameters
    ----------
    samples : int
        Number of instants from 0 to ``until``.
    until : float
        End of the motion [s].
    transit : float
        ``T`` [s].

    Raises
    ------
    InputError
        There are fewer than four in a transit.
    """
    least = math.ceil(_FEWEST * until / transit * (1.0 - 1e-12)) + 1
    if samples < least:
        raise InputError(
            f"samples is {samples}, {(samples - 1) * transit / until:.2g} in a transit of the rod; for its waves to be "
            f"seen give at least {least}, or a shorter time"
        )


def _of_motion(motion: Motion, run: SampledRun, t: Array, fields: Callable[[Array, int], Along]) -> Film:
    trace = np.linspace(t[0], t[-1], _TRACE)
    return Film(run=run, t=t, along=fields(t, _PLACES), trace_t=trace, trace_u=motion.end_displacement(trace))


def _of_samples(run: SampledRun, span: tuple[float, float], frames: int) -> Film:
    along, T = run.along, run.rod.travel_time
    if along is None:
        raise InputError("the fields along the rod were not kept; give a number of places")
    step = float(run.t[1] - run.t[0])
    check_samples_seen(len(run.t), run.until, T)
    inside = np.flatnonzero((run.t >= span[0] - 0.5 * step) & (run.t <= span[1] + 0.5 * step))
    if len(inside) < 2:
        raise InputError(f"span is {span[0]:g} to {span[1]:g} s, less than two samples; give a longer one")
    kept = inside[:: math.ceil(len(inside) / frames)]
    fields = Along(x=along.x, v=along.v[kept], w=along.w[kept], u=along.u[kept])
    return Film(run=run, t=run.t[kept], along=fields, trace_t=run.t[inside], trace_u=run.u_end[inside])
