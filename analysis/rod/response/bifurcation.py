"""How the response changes with a parameter: stroboscopic points against its value."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor

import numpy as np

from lure.analysis.rod.response.plan import Plan, settling
from lure.analysis.rod.response.recording import Watch, follow
from lure.analysis.rod.response.run import classified, stroboscopic, watched_times
from lure.analysis.rod.response.statistics import impulses, share_in_contact
from lure.analysis.rod.response.sweeping import Bifurcation, Point, Sweep
from lure.analysis.rod.response.varying import Case, cases, checked_values, staircase
from lure.errors import AssumptionError, InputError
from lure.rod.parameters import Rod


def bifurcation(
    rod: Rod, force: str, parameter: str, values: Sequence[float], *, sweep: Sweep | None = None
) -> Bifurcation:
    """Response of the rod at several values of a parameter.

    Parameters
    ----------
    rod : Rod
        The rod.
    force : str
        Formula of ``g(t)`` [N].
    parameter : str
        A field of the rod (``damping``, ``gap``, ``compliance``, ...) or a symbol in the formula, such as ``F`` or
        ``w`` in ``1 + F*sin(w*t)``.
    values : sequence of float
        Its values, in SI units.
    sweep : Sweep, optional
        How long to wait and watch, where each value starts, and who is told of the progress.

    Returns
    -------
    Bifurcation
        Evidence: OBSERVED.  ``KeyboardInterrupt`` ends it with what is done, ``complete`` is then False.  A value at
        which the motion cannot be followed is kept with the reason.

    Raises
    ------
    InputError
        The parameter, a value, or the force is not possible; found before anything is followed.

    Examples
    --------
    >>> from lure.rod import Rod
    >>> rod = Rod(youngs_modulus=1, density=1, length=1, area=1, damping=0.2, compliance=0.01)
    >>> plan = Plan(settle=1500, run=16, samples=8)
    >>> seen = bifurcation(rod, "0.3 + F*sin(t/2)", "F", [0.2, 0.7], sweep=Sweep(plan=plan))
    >>> [point.multiple for point in seen.points]
    [1, 2]
    """
    sweep = sweep or Sweep()
    wanted = checked_values(values)
    if sweep.order != "separate":
        wanted = tuple(sorted(wanted, reverse=sweep.order == "down"))
    family = cases(rod, sweep.start, force, (parameter, wanted), sweep.plan.period)
    for member in family:
        settling(member.rod, sweep.plan, member.period)  # refuses before anything is followed
    found: list[Point] = []
    complete = True
    try:
        followed = _one_motion if sweep.order != "separate" else _in_turn if sweep.workers == 1 else _in_parallel
        for point in followed(family, sweep):
            found.append(point)
    except KeyboardInterrupt:
        complete = False
    return Bifurcation(
        parameter=parameter,
        force=force,
        values=wanted,
        points=tuple(found),
        order=sweep.order,
        complete=complete and len(found) == len(family),
    )


def _in_turn(family: Sequence[Case], sweep: Sweep) -> Iterator[Point]:
    for i, member in enumerate(family):
        if sweep.progress is not None:
            sweep.progress(f"value {i + 1} of {len(family)}: {member.value:g}", i / len(family))
        yield _point(member, sweep.plan)


def _in_parallel(family: Sequence[Case], sweep: Sweep) -> Iterator[Point]:
    """In processes of their own; handed on in order."""
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(
        sweep.workers, mp_context=context, initializer=signal.signal, initargs=(signal.SIGINT, signal.SIG_IGN)
    )
    try:
        futures: list[Future[Point]] = [pool.submit(_point, member, sweep.plan) for member in family]
        for i, future in enumerate(futures):
            if sweep.progress is not None:
                sweep.progress(f"value {i + 1} of {len(family)}: {family[i].value:g}", i / len(family))
            yield future.result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _point(member: Case, plan: Plan) -> Point:
    settled = settling(member.rod, plan, member.period)
    watch = Watch(member.rod, plan.boundary, watched_times(plan, member.period, settled.time), plan.samples)
    try:
        follow(member.rod, member.scenario, [watch])
    except (AssumptionError, InputError) as error:
        return Point(value=member.value, poincare=np.empty((0, 2)), problem=str(error))
    return _summary(member, watch, plan)


def _one_motion(family: Sequence[Case], sweep: Sweep) -> Iterator[Point]:
    """One motion through all values; what was seen before it is interrupted or breaks off is handed on."""
    plan, rod = sweep.plan, family[0].rod
    starts, watches, start = [], [], 0.0
    for member in family:
        starts.append(start)
        begin = start + settling(rod, plan, member.period).time
        watches.append(Watch(rod, plan.boundary, watched_times(plan, member.period, begin), plan.samples))
        start = float(watches[-1].t[-1])
    interrupted, problem = False, ""
    try:
        follow(rod, staircase(family, starts), watches, sweep.progress)
    except KeyboardInterrupt:
        interrupted = True
    except AssumptionError as error:
        problem = str(error)
    for member, watch in zip(family, watches, strict=True):
        if watch.done:
            yield _summary(member, watch, plan)
        elif problem:
            yield Point(value=member.value, poincare=np.empty((0, 2)), problem=problem)
    if interrupted:
        raise KeyboardInterrupt


def _summary(member: Case, watch: Watch, plan: Plan) -> Point:
    seen = watch.record()
    regime, transients = classified(seen, member.scenario, plan)
    hits = impulses(seen, plan.run)
    return Point(
        value=member.value,
        poincare=stroboscopic(seen, plan),
        regime=regime.kind,
        multiple=regime.multiple,
        trend=transients.trend,
        duty=share_in_contact(seen),
        impacts=hits.per_period,
        peak_stress=hits.peak_stress,
    )
