"""A parameter varied: what is asked for, and what was seen, periods, statistics and stroboscopic points."""

from __future__ import annotations

import math
import multiprocessing
import re
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import replace
from fractions import Fraction
from typing import Literal

import numpy as np

from lure.analysis.drawing import drawn
from lure.analysis.rod.response.period import load_period
from lure.analysis.rod.response.recording import Plan, Progress, Watch, follow, settling
from lure.analysis.rod.response.run import classified, stroboscopic, watched_times
from lure.analysis.rod.response.seen import impulses, share_in_contact
from lure.analysis.verdict import Evidence
from lure.arrays import Reals as Array
from lure.errors import AssumptionError, InputError, demand_whole
from lure.exact import exact_number
from lure.expressions import Expression
from lure.expressions.tree import Apply, Node, Number, Variable
from lure.record import Column, Page, Record, derived, described, numbered, quantity
from lure.rod import datasets
from lure.rod.parameters import PARAMETERS, Rod
from lure.rod.scenario import Scenario
from lure.rod.systems import rod_from_exact

# A family of rods and forces with one parameter: a field of the rod, or a symbol in the formula of the force.

_MOST_STEPS = 400


@described(frozen=True, kw_only=True, eq=False)
class Case:
    """One member of a family."""

    value: float = quantity("Of the parameter")
    rod: Rod = quantity("The rod")
    scenario: Scenario = quantity("Its loads and initial data")
    period: float = quantity("Of the loads", "s")


def cases(
    rod: Rod, scenario: Scenario, force: str, varied: tuple[str, Sequence[float]], period: float | None
) -> tuple[Case, ...]:
    """The members of a family, all of them checked before any is followed.

    ``rod``, ``scenario``: a field that is the parameter and the force are replaced; ``force``: formula of ``g``, which
    may contain the parameter as a symbol beside ``t``; ``varied``: name of the parameter and its values; ``period``: of
    the loads, if the user gives it [s].

    Raises
    ------
    InputError
        The parameter is neither a field of the rod nor a symbol of the force, or both; a value is not possible; a
        force has no period; or no load changes with time.
    """
    name, values = varied
    in_force = re.search(rf"\b{re.escape(name)}\b", force) is not None
    if in_force and name in PARAMETERS:
        raise InputError(f"{name} is a field of the rod and a symbol of the force; use another symbol")
    if name == "t" or not (in_force or name in PARAMETERS):
        raise InputError(
            f"there is no parameter {name!r:.40}; give one of {', '.join(PARAMETERS)}, or write a symbol in the force "
            "and give its name, such as F in F*sin(4*t)"
        )
    if not len(values):
        raise InputError("there are no values of the parameter; give one at least")
    found = []
    for value in values:
        exact = exact_number(value, name)
        text = re.sub(rf"\b{re.escape(name)}\b", f"({float(exact)!r})", force)
        member = rod if in_force else rod_from_exact({**rod.exact, name: exact})
        load = replace(scenario, force=Expression.parse(text, variables=("t",), field="force.g"))
        known = load_period(load, period, 2.0 * member.travel_time)[0]
        found.append(Case(value=float(exact), rod=member, scenario=load, period=known))
    if all(member.scenario.force.is_constant and member.scenario.body_force.is_constant for member in found):
        raise InputError(
            f"the force is {force}, which does not change with time: the rod only comes to rest, and there is no "
            "response to follow; give a periodic force such as 0.3+F*sin(3000*t) (--force on the command line)"
        )
    return tuple(found)


def staircase(family: Sequence[Case], starts: Sequence[float]) -> Scenario:
    r"""One scenario in which the force goes from one member of the family to the next.

    .. math:: g(t) = g_j(t - t_j) \quad (t_j \le t < t_{j+1}),

    so that each member begins where the one before has ended, with its own force at its beginning.

    ``family``: members that differ in the force only; ``starts``: ``t_j`` [s], ascending, the first of them 0.

    Raises
    ------
    InputError
        The rods differ, there is a body force that depends on ``t``, or there are more than 400 members.
    """
    first = family[0]
    if any(member.rod != first.rod for member in family):
        raise InputError(
            "a sweep up or down carries the motion from one value to the next, which needs the same rod throughout: "
            "the parameter must be a symbol of the force; give order 'separate' for a field of the rod"
        )
    if not first.scenario.body_force.is_constant:
        raise InputError("a sweep up or down takes no body force that varies; give 0, or order 'separate'")
    if len(family) > _MOST_STEPS:
        raise InputError(f"a sweep up or down has at most {_MOST_STEPS} values; there are {len(family)}")
    parts = [_later(member.scenario.force.tree, start) for member, start in zip(family, starts, strict=True)]
    tree = _tree(parts, [Fraction(start) for start in starts])
    source = f"{first.scenario.force} and {len(family) - 1} more, one after the other"
    return replace(first.scenario, force=Expression(source=source, variables=("t",), tree=tree))


def _tree(parts: Sequence[Node], starts: Sequence[Fraction]) -> Node:
    """A balanced choice between the parts."""
    if len(parts) == 1:
        return parts[0]
    half = len(parts) // 2
    early = Apply("<", (Variable("t"), Number(starts[half])))
    return Apply("where", (early, _tree(parts[:half], starts[:half]), _tree(parts[half:], starts[half:])))


def _later(node: Node, start: float) -> Node:
    """The node with ``t - start`` in place of ``t``."""
    if isinstance(node, Variable) and start:
        return Apply("-", (node, Number(Fraction(start))))
    if isinstance(node, Apply):
        return Apply(node.operation, tuple(_later(part, start) for part in node.arguments))
    return node


def checked_values(values: Sequence[float]) -> tuple[float, ...]:
    """The values as floats; ``values``: of a parameter.

    Raises
    ------
    InputError
        One of them is not a finite number.
    """
    found = tuple(float(value) for value in np.asarray(values, dtype=float).ravel())
    wrong = [value for value in found if not math.isfinite(value)]
    if wrong:
        raise InputError(f"a value asked for is {wrong[0]}; give finite numbers")
    return found


# How the response changes with a parameter: stroboscopic points against its value.


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
    >>> rod = Rod(youngs_modulus=1, density=1, length=1, area=1, damping=0.3, compliance=0.01)
    >>> plan = Plan(settle=200, run=16, samples=8)
    >>> seen = bifurcation(rod, "0.3 + F*sin(t)", "F", [0.6, 0.7], sweep=Sweep(plan=plan))
    >>> [point.multiple for point in seen.points]
    [2, 4]
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


_LISTED = 40
Order = Literal["separate", "up", "down"]
ORDERS: tuple[Order, ...] = ("separate", "up", "down")


class Sweep(Record):
    """How a parameter is varied."""

    plan: Plan = quantity(
        "How long to wait and to watch at each value; ``separation`` is not used", default_factory=Plan
    )
    order: Order = quantity(
        "``separate``: each value starts from the same initial data. ``up``, ``down``: one motion, in which the "
        "force goes through the values in ascending or descending order, so that each value starts from where the "
        "one before has ended; up and down may differ (hysteresis). The rod cannot change in the middle of its "
        "motion: only symbols of the force can be swept",
        default="separate",
    )
    start: Scenario = quantity("Initial data and body force", default_factory=Scenario)
    workers: int = quantity(
        "Processes that share the values of a separate sweep; the result does not depend on it. A script that "
        'asks for more than one needs the usual ``if __name__ == "__main__":``',
        default=1,
    )
    progress: Progress | None = quantity("Called as ``progress(text, share)``", default=None)

    def __post_init__(self) -> None:
        if self.order not in ORDERS:
            raise InputError(f"order is {self.order!r}; give one of {', '.join(ORDERS)}")
        demand_whole("workers", self.workers, 1, 64)

    def _page(self) -> Page:
        rows = [("order", self.order), ("plan", self.plan), ("processes", self.workers)]
        return Page("how a parameter is varied", rows, notes=("A request: nothing was computed yet.",))


class Point(Record):
    """What was seen at one value."""

    value: float = quantity("value of the parameter")
    poincare: Array = quantity(
        "(R+1, 2) points ``(z, z')`` at whole periods of the force [m, m/s]; (0, 2) if the motion could not be followed"
    )
    regime: str = quantity("kind of motion seen, as in :class:`Regime`", "1", dims="", default="not followed")
    multiple: int | None = quantity(
        "periods of the force in a repetition; nan if none was seen", "1", dims="", default=None
    )
    trend: str = quantity(
        "whether it was still changing, as in :class:`Transients`",
        "1",
        dims="",
        key="transients",
        name="transients",
        default="",
    )
    duty: float = quantity("share of time in contact", "1", dims="", key="contact_duty", default=math.nan)
    impacts: float = quantity(
        "impacts that begin, per period of the force", "1", dims="", key="impacts_per_period", default=math.nan
    )
    peak_stress: float = quantity(
        "largest stress of these impacts", "Pa", dims="", key="peak_stress_Pa", default=math.nan
    )
    problem: str = quantity("why the motion could not be followed, or nothing", "1", dims="", default="")


class Bifurcation(Record):
    """Stroboscopic points against a parameter; make one with :func:`bifurcation`."""

    parameter: str = quantity("Its name")
    force: str = quantity("Formula of ``g``, with the symbol")
    values: tuple[float, ...] = quantity("Values asked for, in the order in which they were taken")
    points: tuple[Point, ...] = quantity(
        "What was seen at those that were done, in that order", dims="value", each=Point
    )
    order: Order = quantity("How each value started")
    complete: bool = quantity("Whether all values were done; if not, it was interrupted")

    @property
    @derived()
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

    def _columns(self) -> dict[str, Column]:
        points = self.points
        strobe = np.full((len(points), max((len(point.poincare) for point in points), default=0), 2), np.nan)
        for i, point in enumerate(points):
            strobe[i, : len(point.poincare)] = point.poincare
        both, text = ("value", "period"), "at whole periods of the force; nan beyond the last"
        unit = datasets.UNITS.get(self.parameter, "unit of the symbol in the force")
        return super()._columns() | {
            "value": Column(("value",), [point.value for point in points], unit, f"parameter {self.parameter}"),
            "period": numbered("period", strobe.shape[1], "number of the stroboscopic point"),
            "poincare_z": Column(both, strobe[:, :, 0], "m", f"z {text}"),
            "poincare_v": Column(both, strobe[:, :, 1], "m s-1", f"z' {text}"),
        }

    def _attributes(self) -> dict[str, object]:
        return {
            "subject": "rod",
            "evidence": str(self.evidence),
            "comment": "At each value one motion of the rod itself from one start; nothing is said between the values.",
            "parameter": self.parameter,
            "force_g": self.force,
            "order": self.order,
            "complete": int(self.complete),
        }

    def _page(self) -> Page:
        points = self.points
        step = max(1, -(-len(points) // _LISTED))
        rows = [
            (
                f"{point.value:.6g}",
                point.problem or point.regime,
                "-" if point.multiple is None else point.multiple,
                f"{100 * point.duty:.3g} %",
                f"{point.impacts:.3g}",
                f"{point.peak_stress:.4g}" if point.impacts > 0 else "-",
            )
            for point in points[::step]
        ]
        head = (self.parameter, "seen", "repeats after", "in contact", "impacts a period", "peak stress of these [Pa]")
        notes = [] if step == 1 else [f"Shown is one value in {step}."]
        title = f"response of the rod itself against {self.parameter}, g = {self.force}"
        return Page(title, rows, head, "OBSERVED", (*notes, *str(self).split("\n")))

    plot = drawn("Stroboscopic points against the parameter; see :func:`lure.analysis.rod.plots.plot_bifurcation`.")
