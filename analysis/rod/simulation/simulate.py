"""Run the closed loop and account for everything along it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.energy import discrete_energy
from lure.analysis.rod.simulation.account import Account, Peak, summary
from lure.analysis.rod.simulation.trajectory import Trajectory
from lure.arrays import Reals as Array
from lure.errors import InputError, demand_seconds, demand_whole
from lure.rod.discretisation import UpwindScheme, upwind
from lure.rod.scenario import Scenario, initial_state
from lure.rod.scheme.flow import Segment, flow
from lure.rod.scheme.loads import Loads, loads_of
from lure.rod.scheme.poisson import poisson_rows
from lure.rod.scheme.register import ShiftRegister
from lure.rod.scheme.steps import Plan, plan_steps

LARGEST_CELLS = 1000
LARGEST_WORK = 2e8
_LARGEST_TABLE = 5e7
_STIFFEST = 1e9
_LARGEST_STATE = 1e100
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

    In free flight, and in contact with a linear contact law, there is no error of time stepping: the motion is the
    Poisson average of a shift register (:mod:`lure.rod.scheme.poisson`).  Contact with another nonlinearity, or one
    stiffer than about two cells of rod, is collocated to ``tolerance``.  Beginning and end of contact are located as
    events that cannot be missed above rounding (:mod:`lure.rod.scheme.crossing`).

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
    >>> from lure.rod import builtin_system, upwind
    >>> system = builtin_system("paper-rod")
    >>> run = simulate(upwind(system.rod, 10), system.scenario, until=system.until)
    >>> run.contact, run.rest_is_final, round(run.rest_position, 7)
    (False, True, -0.0199)
    """
    _check_request(scheme, until=until, samples=samples, frames=frames, tolerance=tolerance)
    plain = upwind(scheme.rod, scheme.cells, form=scheme.form)
    register = ShiftRegister(scheme=plain)
    loads = loads_of(plain, scenario, until, max(1e-13, 1e-3 * tolerance))
    state = initial_state(plain, scenario)
    _check_motion(register, loads, state, until)
    state[-1] *= register.rate
    t, t_frames = np.linspace(0.0, until, samples), np.linspace(0.0, until, frames) if frames else np.empty(0)
    times = np.union1d(t, t_frames)

    account = Account(
        scheme=plain,
        register=register,
        loads=loads,
        t=t,
        t_frames=t_frames,
        times=times,
        states=np.empty((times.size, plain.order)),
        peak=Peak(best=float(state[-1])),
        energy=float(discrete_energy(plain, initial_state(plain, scenario))),
    )
    plan = plan_steps(register, longest=_LONGEST, tolerance=1e-2 * tolerance)
    with np.errstate(over="ignore", invalid="ignore"):
        for segment in _segments(plan, loads, state, until):
            account.add(segment)
        ended = account.finish(until, most=_MOST_STEPS)
        finer = plan_steps(register, longest=_SHORTER, tolerance=1e-4 * tolerance)
        again = np.full(account.times.size, np.nan)
        if account.segments < _MOST_STEPS:
            _coordinates(finer, loads, state, account.times, again)
    return summary(account, plan, again, ended)


def _segments(plan: Plan, loads: Loads, state: Array, until: float) -> Iterator[Segment]:
    return islice(flow(plan, loads, state, until * plan.register.rate), _MOST_STEPS)


def _coordinates(plan: Plan, loads: Loads, state: Array, times: Array, gaps: Array) -> None:
    """Write ``z`` [m] at the instants, up to the end or an early one."""
    register, filled = plan.register, 0
    for segment in _segments(plan, loads, state, max(float(times[-1]), 1.0 / register.rate)):
        first, filled = filled, int(np.searchsorted(times, segment.stop(register.rate) * (1.0 + 1e-15), side="right"))
        if filled > first:
            tau = segment.tau(times[first:filled], register.rate)
            gaps[first:filled] = poisson_rows(tau, segment.step.tables.columns) @ segment.step.gap / register.rate


def in_steps(scheme: UpwindScheme, until: float) -> bool:
    """Whether :func:`simulate` takes so many cells for so long; :func:`.structured_motion` may where it does not.

    ``until``: end of the run [s].
    """
    return scheme.cells <= LARGEST_CELLS and 2.0 * scheme.cells * scheme.rate * until <= LARGEST_WORK


def _check_request(scheme: UpwindScheme, *, until: float, samples: int, frames: int, tolerance: float) -> None:
    """Refuse a run that is not well posed or would take minutes.

    Raises
    ------
    InputError
        With the field, the value and what would do.
    """
    demand_seconds("simulation.until", until)
    demand_whole("simulation.samples", samples, 2, 10**7)
    if frames != 0:
        demand_whole("simulation.frames", frames, 2, 10**7)
    if not 1e-12 <= tolerance <= 1e-3:
        raise InputError(f"simulation.tolerance is {tolerance!r}; give a number from 1e-12 to 1e-3")
    N = scheme.cells
    if N > LARGEST_CELLS:
        raise InputError(
            f"simulation.cells is {N}; give at most {LARGEST_CELLS}: every step moves {2 * N} waves and there are "
            f"{scheme.rate:.3g} of them a second, so that a finer grid takes minutes for what a coarser one shows"
        )
    work = 2.0 * N * scheme.rate * until
    if work > LARGEST_WORK:
        fewer = int(math.sqrt(LARGEST_WORK * scheme.rod.travel_time / (2.0 * until)))
        coarser = f", or at most {fewer} cells" if fewer else ""
        raise InputError(
            f"simulation.until is {until:g} s: with {N} cells that is {work:.2g} cell updates, more than "
            f"{LARGEST_WORK:g}; give at most {LARGEST_WORK / (2.0 * N * scheme.rate):.3g} s{coarser}"
        )
    if (samples + frames) * scheme.order > _LARGEST_TABLE:
        most = int(_LARGEST_TABLE / scheme.order)
        raise InputError(
            f"simulation.samples is {samples}; with {N} cells give at most {most} samples and frames together"
        )


def _check_motion(register: ShiftRegister, loads: Loads, state: NDArray[np.float64], until: float) -> None:
    """Refuse initial data that are not finite, and contact too stiff for double precision.

    Raises
    ------
    InputError
        With the field, the value and what would do.
    """
    if not np.isfinite(state).all():
        raise InputError(
            "initial.u0 and initial.u1 have no finite value at some grid point; give formulas defined on [0, L]"
        )
    largest = float(np.abs(state).max())
    if largest != 0.0 and not 1.0 / _LARGEST_STATE < largest < _LARGEST_STATE:
        raise InputError(
            f"initial.u0 and initial.u1 start a motion of size {largest:.3g} in SI units, whose energy leaves the "
            f"range of double precision (from {1.0 / _LARGEST_STATE:g} to {_LARGEST_STATE:g}); rescale the units"
        )
    force = np.abs(loads.force_at(np.linspace(0.0, until, 257))).max()
    pressed = float(register.push(np.maximum(state[-1:] * register.rate, 0.0))[0])
    speed = max(float(np.abs(state[:-1]).max()), register.force_gain * float(force), pressed)
    depth = float(register.penetration(np.array(speed)))
    if speed > _STIFFEST * depth:
        compliance = 1.0 / register.scheme.rod.nonlinearity.stiffness
        raise InputError(
            f"rod.compliance is {compliance:g}: the obstacle stops an end that moves at {speed:.3g} m/s in "
            f"{depth / speed:.1g} of the time a wave takes for one cell, which double precision cannot follow (limit "
            f"{1.0 / _STIFFEST:g}); give a larger compliance"
        )
