"""The long run itself: wait, watch, and say what was seen."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from lure.analysis.rod.response.model import Response
from lure.analysis.rod.response.period import load_period
from lure.analysis.rod.response.plan import Plan, settling
from lure.analysis.rod.response.recording import Array, Progress, Recording, Watch, follow
from lure.analysis.rod.response.regime import Regime, Transients, observed_regime
from lure.analysis.rod.response.separation import Separation, pushed, separation
from lure.analysis.rod.response.statistics import balance, impulses, share_in_contact, spectrum
from lure.expressions import Expression
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

Load = Scenario | Expression | str | int | float | Fraction


def response(rod: Rod, force: Load, *, plan: Plan | None = None, progress: Progress | None = None) -> Response:
    """Steady response of the rod to a periodic load, after transients, from its exact motion.

    Parameters
    ----------
    rod : Rod
        The rod.
    force : Scenario, Expression, str or number
        ``g(t)`` [N], from rest at ``u = 0``; or a scenario with other initial data and a body force.  Its period must
        follow from the formula (sines and cosines with commensurable frequencies in any combination), or be given.
    plan : Plan, optional
        How long to wait and to watch, and how closely the motion must repeat.
    progress : callable, optional
        Called as ``progress(text, share)``.

    Returns
    -------
    Response
        Evidence: OBSERVED.  One motion from one start, for a finite time; nothing is shown about other starts or later
        times, and a motion that was not seen to repeat is not thereby proved chaotic.

    Raises
    ------
    InputError
        No period follows from the formula and none is given, or an argument is out of its range.
    AssumptionError
        The rod never forgets its start and no settling time is given, or the motion cannot be followed.

    Notes
    -----
    A force of mean 0 has no periodic response with contact (see :class:`Balance`): nothing but the force presses the
    rod against the obstacle.  Memory grows with ``run * samples`` and with the number of impacts, not with the time
    waited.

    Examples
    --------
    A bar pressed against a stiff stop and shaken: the period has doubled.

    >>> from lure.rod import Rod
    >>> rod = Rod(youngs_modulus=1, density=1, length=1, area=1, damping=0.2, compliance=0.01)
    >>> seen = response(rod, "0.3 + 0.7*sin(t/2)", plan=Plan(settle=1500, run=24))
    >>> seen.regime.kind, seen.regime.multiple, seen.transients.trend
    ('periodic', 2, 'over')
    >>> print(f"{seen.balance.contact / seen.balance.force:.9f}")
    1.000000000
    """
    plan = plan or Plan()
    scenario = scenario_of(force)
    period, source = load_period(scenario, plan.period, 2.0 * rod.travel_time)
    settled = settling(rod, plan, period)
    watch = Watch(rod, plan.boundary, watched_times(plan, period, settled.time), plan.samples)
    motion = follow(rod, scenario, [watch], progress)
    seen = watch.record()
    regime, transients = classified(seen, scenario, plan)
    return Response(
        rod=rod,
        scenario=scenario,
        plan=plan,
        period=period,
        period_source=source,
        settling=settled,
        regime=regime,
        transients=transients,
        t=seen.t,
        z=seen.z,
        v=seen.v,
        poincare=stroboscopic(seen, plan),
        contacts=seen.contacts,
        impact_impulses=np.array([impact.impulse for impact in seen.impacts if impact.closed]),
        duty=share_in_contact(seen),
        impulses=impulses(seen, plan.run),
        balance=balance(seen, scenario, period, regime.multiple),
        spectrum=spectrum(seen, regime, period, plan.samples),
        separation=_parted(rod, scenario, seen, (plan, period)) if plan.separation else None,
        energy_residual=motion.energy_residual,
        error=motion.error,
    )


def scenario_of(force: Load) -> Scenario:
    """A scenario with the force, from rest, or the scenario given.

    Parameters
    ----------
    force : Scenario, Expression, str or number
        See :func:`response`.
    """
    if isinstance(force, Scenario):
        return force
    return Scenario(force=force) if isinstance(force, Expression) else Scenario.parse(force=force)


def classified(seen: Recording, scenario: Scenario, plan: Plan) -> tuple[Regime, Transients]:
    """The kind of motion, and whether it was still changing.

    Parameters
    ----------
    seen : Recording
        The watched motion.
    scenario : Scenario
        Its loads.
    plan : Plan
        How closely it must repeat.
    """
    table = seen.z[:-1].reshape(plan.run, plan.samples)
    constant = scenario.force.is_constant and scenario.body_force.is_constant
    return observed_regime(table, tolerance=plan.tolerance, unloaded=constant)


def stroboscopic(seen: Recording, plan: Plan) -> Array:
    """Points ``(z, z')`` (R+1, 2) at whole periods of the load [m, m/s].

    Parameters
    ----------
    seen : Recording
        The watched motion.
    plan : Plan
        Samples in a period.
    """
    return np.column_stack((seen.z, seen.v))[:: plan.samples]


def watched_times(plan: Plan, period: float, start: float) -> Array:
    """Times of the samples of a watch [s].

    Parameters
    ----------
    plan : Plan
        How many periods and samples.
    period, start : float
        Of the load, and of the watch [s].
    """
    return start + period * (np.arange(plan.run * plan.samples + 1) / plan.samples)


def _parted(rod: Rod, scenario: Scenario, seen: Recording, asked: tuple[Plan, float]) -> Separation:
    plan, period = asked
    watch = Watch(rod, plan.boundary, seen.t, plan.samples)
    follow(rod, pushed(scenario, float(seen.t[0]), period), [watch])
    shape = (plan.run, plan.samples)
    return separation(seen.z[:-1].reshape(shape), watch.record().z[:-1].reshape(shape), period)
