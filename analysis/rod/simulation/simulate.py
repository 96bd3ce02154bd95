"""Run the closed loop and account for everything along it."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.energy import discrete_energy
from lure.analysis.rod.simulation.checks import check_motion, check_request
from lure.analysis.rod.simulation.flow import flow
from lure.analysis.rod.simulation.loads import Loads, loads_of
from lure.analysis.rod.simulation.plan import Plan, plan_steps
from lure.analysis.rod.simulation.poisson import poisson_rows
from lure.analysis.rod.simulation.record import Peak, Record
from lure.analysis.rod.simulation.ring import ring_of
from lure.analysis.rod.simulation.segment import Segment
from lure.analysis.rod.simulation.summary import summary
from lure.analysis.rod.simulation.trajectory import Trajectory
from lure.rod.scenario import Scenario, initial_state
from lure.rod.upwind import UpwindScheme, upwind

Array = NDArray[np.float64]

_MOST_STEPS = 100_000
_LONGEST, _SHORTER = 64.0, 48.0


def simulate(  # noqa: PLR0913  (what, from where, and four keyword-only settings with defaults)
    scheme: UpwindScheme,
    scenario: Scenario,
    *,
    until: float,
    samples: int = 2001,
    tolerance: float = 1e-9,
    frames: int = 0,
) -> Trajectory:
    r"""Motion of the closed loop ``y' = A y + b1 mu + b2 g + f``-terms, ``mu = -p(z)``, from the initial data.

    In free flight, and in contact with a linear law, there is no error of time stepping: the motion is the Poisson
    average of a shift register (:mod:`lure.analysis.rod.simulation.poisson`).  Contact with another law, or one
    stiffer than
    about two cells of rod, is collocated to ``tolerance``.  Beginning and end of contact are located as events that
    cannot be missed above rounding (:mod:`lure.analysis.rod.simulation.certify`).

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme, in any ordering; at most 1000 cells.
    scenario : Scenario
        Loads and initial data.
    until : float
        End of the run [s].
    samples : int
        Number of samples, evenly spaced from 0 to ``until``.
    tolerance : float
        Relative accuracy of contact that is not exact, and of the loads on each step.
    frames : int
        Number of instants at which both waves are kept along the whole rod; 0 for none.

    Returns
    -------
    Trajectory
        The motion, its contacts, and what the theory says must hold along it.  It confirms or contradicts; it proves
        nothing, neither about other initial data nor, since the scheme damps waves that the rod keeps, about the rod.

    Raises
    ------
    InputError
        A request is malformed, would take minutes, or the contact is too stiff for double precision.

    Notes
    -----
    A load is a polynomial on each step, fitted at 12 points and checked one cell-crossing time apart: what it does
    between two checks is not seen.  Instants at which its formula changes end a step.

    Examples
    --------
    >>> from lure import builtin_system, upwind
    >>> system = builtin_system("paper-rod")
    >>> run = simulate(upwind(system.rod, 10), system.scenario, until=system.until)
    >>> run.contact, run.rest_is_final, round(run.rest_position, 7)
    (False, True, -0.0199)
    """
    check_request(scheme, until=until, samples=samples, frames=frames, tolerance=tolerance)
    plain = upwind(scheme.rod, scheme.cells, form=scheme.form)
    ring = ring_of(plain)
    loads = loads_of(plain, scenario, until, max(1e-13, 1e-3 * tolerance))
    state = initial_state(plain, scenario)
    check_motion(ring, loads, state, until)
    state[-1] *= ring.rate
    t, t_frames = np.linspace(0.0, until, samples), np.linspace(0.0, until, frames) if frames else np.empty(0)
    times = np.union1d(t, t_frames)

    record = Record(
        scheme=plain,
        ring=ring,
        loads=loads,
        t=t,
        t_frames=t_frames,
        times=times,
        states=np.empty((times.size, plain.order)),
        peak=Peak(best=float(state[-1])),
        energy=float(discrete_energy(plain, initial_state(plain, scenario))),
    )
    plan = plan_steps(ring, longest=_LONGEST, tolerance=1e-2 * tolerance)
    with np.errstate(over="ignore", invalid="ignore"):
        for segment in _segments(plan, loads, state, until):
            record.add(segment)
        ended = record.finish(until, most=_MOST_STEPS)
        finer = plan_steps(ring, longest=_SHORTER, tolerance=1e-4 * tolerance)
        again = np.full(record.times.size, np.nan)
        if record.segments < _MOST_STEPS:
            _coordinates(finer, loads, state, record.times, again)
    return summary(record, plan, again, ended)


def _segments(plan: Plan, loads: Loads, state: Array, until: float) -> Iterator[Segment]:
    return islice(flow(plan, loads, state, until * plan.ring.rate), _MOST_STEPS)


def _coordinates(plan: Plan, loads: Loads, state: Array, times: Array, gaps: Array) -> None:
    """Write ``z`` [m] at the instants, up to the end or an early one."""
    ring, filled = plan.ring, 0
    for segment in _segments(plan, loads, state, max(float(times[-1]), 1.0 / ring.rate)):
        first, filled = filled, int(np.searchsorted(times, segment.stop(ring.rate) * (1.0 + 1e-15), side="right"))
        if filled > first:
            tau = segment.tau(times[first:filled], ring.rate)
            gaps[first:filled] = poisson_rows(tau, segment.step.tables.columns) @ segment.step.gap / ring.rate
