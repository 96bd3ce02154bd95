"""The long run itself: wait, watch, and say what was seen."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from lure.analysis.drawing import drawn
from lure.analysis.rod.response.period import load_period
from lure.analysis.rod.response.recording import Plan, Progress, Recording, Settling, Watch, follow, settling
from lure.analysis.rod.response.seen import (
    Balance,
    Impulses,
    Regime,
    Separation,
    Spectrum,
    Transients,
    balance,
    impulses,
    observed_regime,
    pushed,
    separation,
    share_in_contact,
    spectrum,
)
from lure.analysis.verdict import Evidence
from lure.arrays import Reals as Array
from lure.expressions import Expression
from lure.record import Column, Page, Record, derived, finite, numbered, quantity
from lure.rod import datasets
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

# The answer to a long run.

_HARMONICS = 9
_WATCHED = "motion of the rod itself from one start, watched for a finite time; it proves nothing of others"


class Response(Record):
    """What a rod does under a periodic load after a while; make one with :func:`response`.

    Its numbers are those of the rod itself, not of a scheme, and of one motion: other initial data may lead elsewhere,
    and what follows the watch was not computed.
    """

    rod: Rod = quantity("The rod", key="")
    scenario: Scenario = quantity("Loads and initial data", key="force", plainly=lambda scenario: str(scenario.force))
    plan: Plan = quantity("What was asked for", key="")
    period: float = quantity(
        "Period of the loads that ``multiple`` counts in [s]; a multiple of the least one, perhaps", key="period_s"
    )
    period_source: str = quantity(
        "``formula`` (proved from it), ``given`` (the user's word) or ``constant load`` (the round trip ``2T`` in "
        "place of a period)"
    )
    settling: Settling = quantity("How long was waited", inline=True)
    t: Array = quantity("time since the start of the motion, at the samples of the watch", "s", dims="t")
    z: Array = quantity("contact coordinate ``u(t, L) - gap``", "m", dims="t")
    v: Array = quantity("velocity ``z'`` of the end ``x = L``", "m s-1", dims="t")
    regime: Regime = quantity("The kind of motion seen", inline=True)
    transients: Transients = quantity("Whether it was still changing", inline=True)
    duty: float = quantity("Share of the watch in contact", "1", key="contact_duty")
    impulses: Impulses = quantity("Statistics of the impacts", inline=True)
    impact_impulses: Array = quantity(
        "impulse ``A int p dt`` of each contact that begins during the watch and ends",
        "N s",
        dims="hit",
        name="impulse",
    )
    balance: Balance | None = quantity(
        "Momentum per period; None with a body force, a clamped end, or a watch that begins within one transit",
        key="momentum_per_period_Ns",
    )
    spectrum: Spectrum = quantity("Amplitudes of ``z``", inline=True)
    separation: Separation | None = quantity(
        "How two nearby motions part, if asked for",
        key="separation_rate_per_s",
        plainly=lambda found: finite(found and found.rate),
    )
    poincare: Array = quantity("(R+1, 2) points ``(z, z')`` at whole periods of the load [m, m/s]")
    contacts: tuple[tuple[float, float], ...] = quantity("Intervals of contact, cut to the watch", "s", key="")
    energy_residual: float = quantity("Of the motion, see :class:`lure.rod.motion.Motion`")
    error: float = quantity("Of the motion, see :class:`lure.rod.motion.Motion`", "m", key="error_m")

    @property
    @derived()
    def evidence(self) -> Evidence:
        """OBSERVED: a motion followed for a finite time."""
        return Evidence.OBSERVED

    @property
    @derived()
    def watched_periods(self) -> int:
        """Periods of the load that were watched."""
        return len(self.poincare) - 1

    @property
    @derived(key="harmonics_m", plainly=lambda found: [*map(finite, found)])
    def harmonics(self) -> tuple[float, ...]:
        """Amplitudes of ``z`` at 0, 1, .., 8 times the frequency of the load [m]."""
        return tuple(self.spectrum.harmonic(order, self.period) for order in range(_HARMONICS))

    def __str__(self) -> str:
        said = [
            f"Rod under g = {self.scenario.force}: period {self.period:.6g} s ({self.period_source}).",
            str(self.settling),
            str(self.regime),
            str(self.transients),
            self._touching(),
        ]
        if self.balance is not None:
            said.append(
                f"Momentum per period: force {self.balance.force:.6g}, contact {self.balance.contact:.6g}, dashpot "
                f"{self.balance.dashpot:.6g}, left over {self.balance.left:.3g} N s."
            )
        if self.separation is not None:
            said.append(str(self.separation))
        said.append(
            f"Evidence: {self.evidence}; one exact motion of the rod from one start, watched for a finite time."
        )
        return "\n".join(said)

    def _touching(self) -> str:
        hits = self.impulses
        if not self.contacts:
            return "No contact during the watch."
        often = "1 impact" if hits.per_period == 1 else f"{hits.per_period:.4g} impacts"
        said = f"In contact {100.0 * self.duty:.4g} % of the time, {often} a period"
        if hits.count > hits.unfinished:
            said += f", impulse {hits.least:.4g} to {hits.largest:.4g} N s (mean {hits.mean:.4g})"
        return said + (f", peak stress {hits.peak_stress:.4g} Pa." if hits.count else ".")

    def _columns(self) -> dict[str, Column]:
        strobe = "at whole periods of the load"
        starts, ends = ([contact[i] for contact in self.contacts] for i in (0, 1))
        return super()._columns() | {
            "poincare_z": Column(("period",), self.poincare[:, 0], "m", f"z {strobe}"),
            "poincare_v": Column(("period",), self.poincare[:, 1], "m s-1", f"z' {strobe}"),
            "contact_start": Column(("contact",), starts, "s", "instant of contact, cut to the watch"),
            "contact_end": Column(("contact",), ends, "s", "instant of release, cut to the watch"),
            "period": numbered("period", len(self.poincare), "number of the stroboscopic point"),
            "hit": numbered("hit", self.impact_impulses.size, "number of the finished contact, in order"),
        }

    def _attributes(self) -> dict[str, object]:
        return {
            "subject": "rod",
            "evidence": str(self.evidence),
            "comment": f"A {_WATCHED}.",
            "regime": self.regime.kind,
            "period": self.period,
            "period_units": "s",
            "period_source": self.period_source,
            "energy_residual": self.energy_residual,
            "error_estimate": self.error,
            "error_estimate_units": "m",
            **datasets.rod_attributes(self.rod),
            **datasets.scenario_attributes(self.scenario),
        }

    def _page(self) -> Page:
        hits = self.impulses
        rows: list[tuple[str, object]] = [
            ("what moved", "the rod itself"),
            ("force g(t) [N]", self.scenario.force),
            ("period", f"{self.period:.6g} s ({self.period_source})"),
            ("waited", self.settling),
            ("seen", self.regime),
            ("transients", self.transients),
            ("in contact", f"{100 * self.duty:.4g} % of the time, {hits.per_period:.4g} impacts a period"),
        ]
        if hits.count:
            rows.append(("peak stress of these impacts", f"{hits.peak_stress:.4g} Pa"))
        if self.balance is not None:
            rows.append(("momentum left per period", f"{self.balance.left:.3g} N s"))
        if self.separation is not None:
            rows.append(("nearby motions", self.separation))
        rows.append(("energy balance", f"relative residual {self.energy_residual:.1g}"))
        return Page("response of the rod to a periodic load", rows, verdict="OBSERVED", notes=(f"One {_WATCHED}.",))

    plot = drawn(
        "History, stroboscopic points, spectrum and impulses; see :func:`lure.analysis.rod.plots.plot_response`."
    )


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
    A bar pressed against a stiff stop and shaken: the period has doubled twice.

    >>> from lure.rod import Rod
    >>> rod = Rod(youngs_modulus=1, density=1, length=1, area=1, damping=0.3, compliance=0.01)
    >>> seen = response(rod, "0.3 + 0.7*sin(t)", plan=Plan(settle=200, run=16))
    >>> seen.regime.kind, seen.regime.multiple, seen.transients.trend
    ('periodic', 4, 'over')
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
    """A scenario with the force, from rest, or the scenario given; ``force``: see :func:`response`."""
    if isinstance(force, Scenario):
        return force
    return Scenario(force=force) if isinstance(force, Expression) else Scenario.parse(force=force)


def classified(seen: Recording, scenario: Scenario, plan: Plan) -> tuple[Regime, Transients]:
    """The kind of motion, and whether it was still changing.

    ``seen``: the watched motion; ``plan``: how closely it must repeat.
    """
    table = seen.z[:-1].reshape(plan.run, plan.samples)
    constant = scenario.force.is_constant and scenario.body_force.is_constant
    return observed_regime(table, tolerance=plan.tolerance, unloaded=constant)


def stroboscopic(seen: Recording, plan: Plan) -> Array:
    """Points ``(z, z')`` (R+1, 2) at whole periods of the load [m, m/s].

    ``seen``: the watched motion; ``plan``: samples in a period.
    """
    return np.column_stack((seen.z, seen.v))[:: plan.samples]


def watched_times(plan: Plan, period: float, start: float) -> Array:
    """Times of the samples of a watch [s].

    ``plan``: how many periods and samples; ``period``, ``start``: of the load, and of the watch [s].
    """
    return start + period * (np.arange(plan.run * plan.samples + 1) / plan.samples)


def _parted(rod: Rod, scenario: Scenario, seen: Recording, asked: tuple[Plan, float]) -> Separation:
    plan, period = asked
    watch = Watch(rod, plan.boundary, seen.t, plan.samples)
    follow(rod, pushed(scenario, float(seen.t[0]), period), [watch])
    shape = (plan.run, plan.samples)
    return separation(seen.z[:-1].reshape(shape), watch.record().z[:-1].reshape(shape), period)
