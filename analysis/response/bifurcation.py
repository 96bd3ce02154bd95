"""How the response changes with a parameter: stroboscopic points against its value."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from analysis.evidence import Evidence
from analysis.response.model import plain
from analysis.response.plan import Plan, settling
from analysis.response.recording import Progress, Watch, follow
from analysis.response.run import classified, stroboscopic, watched_times
from analysis.response.statistics import impulses, share_in_contact
from analysis.response.varying import Case, cases, checked_values, staircase
from lure.errors import AssumptionError, InputError
from lure.rod import Rod
from lure.scenario import Scenario

Array = NDArray[np.float64]
Order = Literal["separate", "up", "down"]
ORDERS: tuple[Order, ...] = ("separate", "up", "down")


@dataclass(frozen=True, kw_only=True, slots=True)
class Sweep:
    """How a parameter is varied.

    Attributes
    ----------
    plan : Plan
        How long to wait and to watch at each value; ``separation`` is not used.
    order : {"separate", "up", "down"}
        ``separate``: each value starts from the same initial data.  ``up``, ``down``: one motion, in which the force
        goes through the values in ascending or descending order, so that each value starts from where the one before
        has ended; up and down may differ (hysteresis).  The rod cannot change in the middle of its motion: only symbols
        of the force can be swept.
    start : Scenario
        Initial data and body force.
    workers : int
        Processes that share the values of a separate sweep; the result does not depend on it.  A script that asks for
        more than one needs the usual ``if __name__ == "__main__":``.
    progress : callable or None
        Called as ``progress(text, share)``.
    """

    plan: Plan = field(default_factory=Plan)
    order: Order = "separate"
    start: Scenario = field(default_factory=Scenario)
    workers: int = 1
    progress: Progress | None = None

    def __post_init__(self) -> None:
        if self.order not in ORDERS:
            raise InputError(f"order is {self.order!r}; give one of {', '.join(ORDERS)}")
        if isinstance(self.workers, bool) or not isinstance(self.workers, int) or not 1 <= self.workers <= 64:
            raise InputError(f"workers is {self.workers!r}; give a whole number from 1 to 64")


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Point:
    """What was seen at one value.

    Attributes
    ----------
    value : float
        Of the parameter.
    poincare : ndarray
        (R+1, 2) points ``(z, z')`` at whole periods of the force [m, m/s]; (0, 2) if the motion could not be followed.
    regime, multiple, trend : str, int or None, str
        As in :class:`Regime` and :class:`Transients`.
    duty, impacts, peak_stress : float
        Share of time in contact [-], impacts per period [-], largest stress [Pa].
    problem : str
        Why the motion could not be followed, or nothing.
    """

    value: float
    poincare: Array
    regime: str = "not followed"
    multiple: int | None = None
    trend: str = ""
    duty: float = np.nan
    impacts: float = np.nan
    peak_stress: float = np.nan
    problem: str = ""


@dataclass(frozen=True, kw_only=True, eq=False)
class Bifurcation:
    """Stroboscopic points against a parameter; make one with :func:`bifurcation`.

    Attributes
    ----------
    parameter : str
        Its name.
    force : str
        Formula of ``g``, with the symbol.
    values : tuple of float
        Values asked for, in the order in which they were taken.
    points : tuple of Point
        What was seen at those that were done, in that order.
    order : {"separate", "up", "down"}
        How each value started.
    complete : bool
        Whether all values were done; if not, it was interrupted.
    """

    parameter: str
    force: str
    values: tuple[float, ...]
    points: tuple[Point, ...]
    order: Order
    complete: bool

    @property
    def evidence(self) -> Evidence:
        """OBSERVED: one motion at each value, for a finite time."""
        return Evidence.OBSERVED

    def scatter(self) -> tuple[Array, Array]:
        """All points: values of the parameter (n,) and ``z`` at whole periods (n,) [m]."""
        if not self.points:
            return np.empty(0), np.empty(0)
        values = [np.full(len(point.poincare), point.value) for point in self.points]
        return np.concatenate(values), np.concatenate([point.poincare[:, 0] for point in self.points])

    def __str__(self) -> str:
        counted: dict[str, int] = {}
        for point in self.points:
            name = f"repeats after {point.multiple}" if point.regime == "periodic" else point.regime
            counted[name] = counted.get(name, 0) + 1
        seen = ", ".join(f"{name}: {count}" for name, count in counted.items()) or "nothing"
        starts = {
            "separate": "Each value starts from the same initial data.",
            "up": "One motion, the values in ascending order, each from the end of the one before.",
            "down": "One motion, the values in descending order, each from the end of the one before.",
        }[self.order]
        done = "All" if self.complete else "Interrupted: only"
        waiting = sum(point.trend in ("still approaching", "still changing") for point in self.points)
        late = f"  At {waiting} of them transients were not over." if waiting else ""
        return (
            f"g = {self.force}, {self.parameter} varied.  {done} {len(self.points)} of {len(self.values)} values done."
            f"  {starts}\nSeen: {seen}.{late}\nEvidence: {self.evidence}; of the rod itself, at these values and from "
            "these starts only."
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "parameter": self.parameter,
            "force": self.force,
            "order": self.order,
            "complete": self.complete,
            "values": list(self.values),
            "points": [
                {
                    "value": point.value,
                    "regime": point.regime,
                    "multiple": point.multiple,
                    "transients": point.trend,
                    "contact_duty": plain(point.duty),
                    "impacts_per_period": plain(point.impacts),
                    "peak_stress_Pa": plain(point.peak_stress),
                    "problem": point.problem,
                    "poincare": point.poincare.tolist(),
                }
                for point in self.points
            ],
            "evidence": str(self.evidence),
        }


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
    >>> from lure import Rod
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
