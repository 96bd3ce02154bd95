"""The motion as a chain of steps that end where contact begins or ends, each known at every instant of it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lure.arrays import Reals as Array
from lure.record import described, quantity
from lure.rod.scheme.crossing import Mesh, Root, Scan, first_root, last_root, mesh_of, peak, rounding, scan
from lure.rod.scheme.loads import LoadFit, Loads, averaged, fit_loads
from lure.rod.scheme.poisson import poisson_rows
from lure.rod.scheme.steps import Plan, Step, Tables, contact_step, exact_step, quadrature, states_at

_FINEST = 2.0**-40
_FIRST, _FIRST_COLLOCATED = 2.0**-2, 2.0**-14  # shares of the longest step
_RUNAWAY, _NOTHING = 1e30, 1e-100
_NOISE = 3e-14
_FORGIVEN = 30.0  # dips between collocation points, in units of the tolerance


@described(frozen=True, kw_only=True, slots=True)
class Segment:
    """A step, cut where contact begins or ends; read-only."""

    clock: tuple[float, float] = quantity("Start in units of ``1/s``, as a number and what rounding has taken from it")
    length: float = quantity("Length in the same units; the step itself may be longer")
    contact: bool = quantity("Whether the end is in contact with the obstacle")
    step: Step = quantity("The motion")
    seen: Scan = quantity("The contact coordinate on the pieces of the whole step")
    end: Array = quantity("(2N+1,) scaled state at the end")
    event: Root | None = quantity("The crossing that ends the segment")
    floor: float = quantity("Scaled coordinate below which a touch is not told from none")

    def tau(self, t: Array, rate: float) -> Array:
        """Place of the instants ``t`` [s] in the segment."""
        return np.asarray(np.clip((t * rate - self.clock[0]) - self.clock[1], 0.0, self.length))

    def rows(self, tau: Array) -> Array:
        """Poisson weights at places in the segment."""
        return poisson_rows(tau, self.step.tables.columns)

    def stop(self, rate: float) -> float:
        """End of the segment [s]."""
        return (self.clock[0] + (self.clock[1] + self.length)) / rate

    def gauss(self) -> tuple[Array, Array, Array]:
        """Quadrature points and weights on the segment, and the Poisson weights there."""
        tables = self.step.tables
        if self.length == tables.length:
            return tables.gauss, tables.gauss_weights, tables.gauss_rows
        points, weights = quadrature(self.length)
        return points, weights, self.rows(points)

    def bounds(self) -> tuple[float, float]:
        """Largest value of the scaled coordinate at the edges, and a bound on the whole segment."""
        seen = self.seen if self.length == self.step.tables.length else scan(self.step.gap, self._mesh())
        return float(seen.values.max()), float(seen.uppers.max())

    def peak(self, known: float) -> float:
        """Largest scaled coordinate on the whole segment, or ``known`` if that is larger."""
        mesh = self._mesh()
        return peak(self.step.gap, mesh, known, rounding(self.step.gap, mesh))

    def _mesh(self) -> Mesh:
        tables = self.step.tables
        if self.length == tables.length:
            return tables.mesh
        inside = tables.mesh.edges < self.length
        inside[0] = True
        return mesh_of(np.append(tables.mesh.edges[inside], self.length), tables.columns)


def flow(plan: Plan, loads: Loads, state: Array, until: float) -> Iterator[Segment]:
    """Segments of the motion from ``state`` up to ``until``.

    ``state``: (2N+1,) scaled state at the start; ``until``: end, in units of ``1/s``.

    Yields
    ------
    Segment
        In order, without gaps.  The chain ends early only where the state has grown by ``1e30``.
    """
    register = plan.register
    clock, contact = (0.0, 0.0), bool(state[-1] > 0.0)
    stops = [*(t * register.rate for t in loads.breakpoints), until]
    wanted = _first_length(plan, contact=contact)
    largest, start = (0.0, 0.0), float(np.abs(state).max())
    speed = float(np.abs(state if contact else state[:-1]).max())
    while clock[0] < until:
        while stops[0] <= clock[0]:
            stops.pop(0)
        left = (stops[0] - clock[0]) - clock[1]
        length = min(wanted, left)
        kappa = register.kappa if contact and plan.longest_contact else 0.0
        tables = plan.tables(length, kappa, reused=length == wanted)
        fit = fit_loads(loads, tables.grid, (clock[0] + clock[1]) / register.rate, length / register.rate, largest)
        largest = fit.largest
        if not fit.resolved and length > _FINEST:
            wanted = _shortened(wanted, 0.25 * length)
            continue
        done = _advanced(plan, tables, fit, _Start(state=state, speed=speed, contact=contact))
        if done.factor < 1.0 and length > _FINEST:
            wanted = _shortened(wanted, done.factor * length)
            continue
        segment = _until_event(plan, done, clock, contact=contact)
        yield segment
        state = np.where(np.abs(segment.end) < _NOTHING * start, 0.0, segment.end)
        speed = max(speed, float(np.abs(state[:-1]).max()))
        start = max(start, register.force_gain * largest[0], register.body_gain * largest[1])
        if not np.abs(state).max() <= _RUNAWAY * start:
            return
        if segment.event is not None:
            contact = not contact
            wanted = _first_length(plan, contact=contact)
        elif length == wanted:
            wanted = min(_last_length(plan, contact=contact), wanted * _power_of_two(max(1.0, done.factor)))
        whole = segment.event is None and length == left
        clock = (stops[0], 0.0) if whole else _added(clock, segment.length)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Start:
    """State at the start of a step, largest speed met so far, and whether there is contact."""

    state: Array
    speed: float
    contact: bool


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Advance:
    """A whole step before events are looked for.

    ``factor`` is by how much the next step may be longer; below one, this one must be taken again, shorter.  Where
    contact is collocated, ``blur`` is the accuracy of the scaled coordinate: a shallower touch or release is forgiven.
    Of a collocated step, ``gap`` is its value at the end, and ``left`` whether the end of the rod has left the obstacle
    at one of its points.
    """

    step: Step
    factor: float = 4.0
    blur: float = 0.0
    gap: float | None = None
    left: bool = False


def _advanced(plan: Plan, tables: Tables, fit: LoadFit, start: _Start) -> _Advance:
    if not fit.resolved:
        fit = averaged(fit)
    state, allowed = start.state, plan.tolerance * start.speed
    if not start.contact or plan.longest_contact:
        step = exact_step(plan.register, tables, state, fit, plan.register.kappa if start.contact else 0.0)
        return _Advance(step=step, blur=0.0 if plan.longest_contact else allowed)
    done = contact_step(plan.register, exact_step(plan.register, tables, state, fit, 0.0), plan.collocation(tables))
    if not done.converged:
        factor = 0.125
    elif done.error <= _NOISE * start.speed:
        factor = 2.0
    else:
        factor = (allowed / done.error) ** 0.125
        factor = max(1.0, min(4.0, 0.7 * factor)) if factor >= 1.0 else max(0.125, min(0.5, 0.8 * factor))
    return _Advance(step=done.step, factor=factor, blur=_FORGIVEN * allowed, gap=done.gap, left=done.left)


def _until_event(plan: Plan, done: _Advance, clock: tuple[float, float], *, contact: bool) -> Segment:
    step, mesh, columns = done.step, done.step.tables.mesh, done.step.tables.columns
    seen = scan(step.gap, mesh)
    event, exact, length = None, 0.0, step.tables.length
    if (seen.lowers.min() < 0.0) if contact else (seen.uppers.max() > 0.0):
        sign = -1.0 if contact else 1.0
        heading = sign * step.gap
        exact = rounding(step.gap, mesh)
        event = first_root(heading, mesh, Scan(values=sign * seen.values, errors=seen.errors), max(done.blur, exact))
        if done.left or (done.blur > 0.0 and event is not None):
            event = last_root(heading, mesh, length if event is None else event.tau, exact, done.blur)
    if event is None:
        end = states_at(plan.register, step, mesh.rows[-1:])[0]
        if done.gap is not None:
            end[-1] = done.gap
    else:
        length = event.tau
        end = states_at(plan.register, step, poisson_rows(length, columns))[0]
        end[-1] = 0.0
    return Segment(
        clock=clock,
        length=length,
        contact=contact,
        step=step,
        seen=seen,
        end=end,
        event=event,
        floor=max(done.blur, exact),
    )


def _first_length(plan: Plan, *, contact: bool) -> float:
    """Length of the first step after an event."""
    if contact and not plan.longest_contact:
        return _FIRST_COLLOCATED * plan.longest
    return _FIRST * _last_length(plan, contact=contact)


def _last_length(plan: Plan, *, contact: bool) -> float:
    """Greatest length of a step."""
    return (plan.longest_contact if contact else 0.0) or plan.longest


def _shortened(length: float, most: float) -> float:
    """``length`` halved until it is at most ``most``."""
    return length * min(1.0, _power_of_two(most / length))


def _power_of_two(factor: float) -> float:
    """The largest power of two that is not above ``factor``."""
    return math.ldexp(1.0, math.frexp(factor)[1] - 1)


def _added(clock: tuple[float, float], length: float) -> tuple[float, float]:
    """Sum with its rounding error (two-sum), so that a million steps do not drift."""
    rest = clock[1] + length
    total = clock[0] + rest
    return total, (clock[0] - total) + rest
