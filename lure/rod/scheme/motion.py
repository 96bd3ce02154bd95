"""The scheme with its contacts, event to event, for very many cells."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from lure.arrays import Reals as Array
from lure.errors import InputError, demand_seconds, demand_whole
from lure.plants.multivariable import counted
from lure.record import Column, Page, derived, described, quantity
from lure.rod import datasets
from lure.rod.datasets import SampledMotion
from lure.rod.discretisation import UpwindScheme
from lure.rod.scenario import Scenario, initial_state
from lure.rod.scheme.contact import EventFreeInterval, fewest_cells, halved, longest, next_contact
from lure.rod.scheme.crossing import FLOOR, Crossing, Undecided
from lure.rod.scheme.flight import FreeFlight, free_flight
from lure.rod.scheme.loads import Force, force_of
from lure.rod.scheme.poisson import parted, poisson_columns
from lure.rod.scheme.register import RegisterState

if TYPE_CHECKING:
    import control

# From event to event: clock, samples and contacts of a run.


_EARLY = 8


@described(kw_only=True, slots=True, eq=False)
class Run:
    """Clock, samples and contacts of a run, in units of ``1/s``; the clock is exact."""

    rate: Fraction = quantity("``s`` [1/s]")
    times: Array = quantity("Samples", "s")
    stop: Fraction = quantity("The end")
    force: Force | None = quantity("What acts on the end ``x = 0``")
    contact: bool = quantity("Whether the end touches the obstacle")
    clock: Fraction = quantity("How far the motion is known", default=Fraction(0))
    filled: int = quantity("How many samples are", default=0)
    gaps: Array = quantity("``s z`` at the samples [m/s]", init=False)
    waves: Array = quantity("``y_N`` at the samples [m/s]", init=False)
    stretches: list[tuple[Fraction, Fraction]] = quantity("The contacts", default_factory=list)

    def __post_init__(self) -> None:
        self.gaps, self.waves = np.empty(self.times.size), np.empty(self.times.size)

    def moved(self, start: RegisterState) -> RegisterState:
        """The register at the next event, the end of a stretch or of the run."""
        begin, touched = self.clock, self.contact
        free = not touched and self.force is None
        after = self._flown(start) if free else self._stretched(start)
        if touched:
            if self.stretches and self.stretches[-1][1] == begin:
                begin = self.stretches.pop()[0]
            self.stretches.append((begin, self.clock))
        if self.contact is touched:
            return after
        return replace(after, gap=max(after.gap, 0.0) if self.contact else min(after.gap, 0.0))  # rounding has no say

    def closed(self) -> tuple[tuple[float, float], ...]:
        """The contacts in seconds."""
        return tuple((float(begin / self.rate), float(end / self.rate)) for begin, end in self.stretches)

    def _flown(self, start: RegisterState) -> RegisterState:
        """Flight without a force up to the next contact or the end, in one jump."""
        flight = FreeFlight(start=start)
        touch = next_contact(flight, float(self.stop - self.clock))
        end = self.stop if touch is None else self.clock + touch.passed + Fraction(touch.tau)
        if touch is None or end >= self.stop:
            span = self.stop - self.clock
            self._sample(flight, self.stop)
            return flight.after(parted(span))
        self._sample(flight, end)
        self.contact = True
        return touch.flight.after(parted(touch.tau))

    def _stretched(self, start: RegisterState) -> RegisterState:
        """A stretch of contact, or of flight under the force."""
        begin, end, contact = self.clock, self.stop, self.contact
        kappa = start.register.kappa if contact else 0.0
        length = longest(start.register.cells, kappa)
        if self.force is not None:
            end = min(end, self.force.end(begin) or end)
            length = min(length, self.force.reach(begin))
        left = float(end - begin)
        while True:
            entering = None if self.force is None else self.force.entering(begin, poisson_columns(length))
            stretch = EventFreeInterval(start=start, length=length, kappa=kappa, entering=entering)
            gaps = stretch.streams.gap
            search = Crossing(values=-gaps if contact else gaps, floor=FLOOR * stretch.rounding)
            try:
                found = search.first(0.0, min(float(length), left))
            except Undecided:
                length = halved(length)
                continue
            if found is None or length <= _EARLY * max(1.0, found):
                break
            length = math.ceil(2.0 * max(0.5, found))  # seen again where rounding is that of a shorter stretch
        span = min(Fraction(length), end - begin)
        if found is not None and found < span:
            span, self.contact = Fraction(found), not contact
        after = stretch.after(parted(span))
        self._sample(stretch, begin + span)
        return after

    def _sample(self, piece: FreeFlight | EventFreeInterval, end: Fraction) -> None:
        """Fill the samples from the clock to ``end``, and set the clock."""
        while self.filled < self.times.size:
            place = self.rate * Fraction(float(self.times[self.filled]))
            if place > end:
                break
            self.gaps[self.filled], self.waves[self.filled] = piece.end_at(parted(place - self.clock))
            self.filled += 1
        self.clock = end


METHOD = (
    "exact in time by the f-circulant structure of the scheme, from event to event; contact and release located as "
    "events"
)


def scheme_words(scheme: UpwindScheme) -> str:
    """Which object moves, in words."""
    printed = " as printed" if scheme.form == "as-printed" else ""
    return f"the upwind scheme{printed} of {counted(scheme.cells, 'cell')}, whose waves lose more energy than the rod's"


_MOST = 20_000


class SchemeMotion(SampledMotion):
    """A motion of the scheme, known at samples; OBSERVED evidence."""

    _subject: ClassVar[str] = "scheme"

    scheme: UpwindScheme = quantity("What moved", key="rod", plainly=lambda scheme: datasets.rod_dict(scheme.rod))

    @property
    def about(self) -> str:
        """Which object moves, in words."""
        return scheme_words(self.scheme)

    def _attributes(self) -> dict[str, object]:
        more = {"method_cells": self.scheme.cells, "method_form": self.scheme.form}
        return {**super()._attributes(), **datasets.rod_attributes(self.scheme.rod), **more}


class StructuredMotion(SchemeMotion):
    """A motion of the scheme with contact, in jumps from event to event; OBSERVED evidence."""

    _heading: ClassVar[str] = "Motion of the upwind scheme against an obstacle"

    scenario: Scenario | None = quantity(
        "Force and initial data; None where a state was given, without a force",
        plainly=lambda scenario: scenario and datasets.scenario_dict(scenario),
    )
    z: Array = quantity(*datasets.SERIES["z"], dims="t")
    wave: Array = quantity("last forward wave ``y_N``", "m s-1", dims="t")
    contacts: tuple[tuple[float, float], ...] = quantity(
        "Beginning and end of every contact; the last may end with the run", "s"
    )
    state: Array = quantity("(2N+1,) at the end, in the ordering of the scheme", key="")

    @property
    @derived(*datasets.SERIES["stress"][1:], dims="t", name=datasets.STRESS)
    def stress(self) -> Array:
        """The contact stress ``p(z)`` of the obstacle, positive in compression: ``E u_x(t, L) = -p``."""
        return self.scheme.rod.nonlinearity(self.z)

    @property
    def how(self) -> str:
        """How the motion was computed."""
        return METHOD

    def to_dict(self) -> dict[str, Any]:
        """What is said of the motion as plain JSON data; the curves are in :meth:`to_xarray`."""
        return super().to_dict() | {
            "cells": self.scheme.cells,
            "form": self.scheme.form,
            "largest_z_at_samples": float(self.z.max()),
            "z_end": float(self.z[-1]),
            "method": METHOD,
        }

    def _columns(self) -> dict[str, Column]:
        """The motion of the end ``x = L`` along ``t``, and the contacts."""
        rod, (starts, ends) = self.scheme.rod, ([contact[i] for contact in self.contacts] for i in (0, 1))
        more = {"u_end": self.z + rod.gap, "v_end": self.wave - rod.mobility * self.stress}
        return super()._columns() | {
            **datasets.series(more),
            "contact_start": Column(("contact",), starts, "s", "instant of contact"),
            "contact_end": Column(("contact",), ends, "s", "instant of release, or the end"),
        }

    def _attributes(self) -> dict[str, object]:
        return {**super()._attributes(), **(datasets.scenario_attributes(self.scenario) if self.scenario else {})}

    def to_control(self) -> control.TimeResponseData:
        """The motion as python-control has it: output ``sigma = z`` [m], inputs ``mu = -p(z)`` [Pa] and ``g`` [N]."""
        force = self.scenario.force(t=self.t) if self.scenario else 0.0
        return datasets.loop_response(f"the scheme, N = {self.scheme.cells}", self.t, self.z, self.stress, force)

    def _page(self) -> Page:
        rows = [
            ("what moved", self.about),
            ("time", f"0 s to {self.t[-1]:g} s, {self.t.size} samples"),
            ("force g(t) [N]", self.scenario.force if self.scenario else 0),
            ("contacts", len(self.contacts) or "none"),
            ("largest z", f"{self.z.max():.9g} m, at the samples"),
            ("z at the end", f"{self.z[-1]:.9g} m"),
        ]
        return Page(f"motion of the scheme, N = {self.scheme.cells}", rows, verdict="OBSERVED", notes=(self.comment,))


def structured_motion(
    scheme: UpwindScheme, start: Scenario | ArrayLike, until: float, *, samples: int = 2001
) -> StructuredMotion:
    """Motion of the scheme against its obstacle, with a force or without: jumps from event to event.

    Without a force, a jump of any length by :class:`FreeFlight` between contacts; in contact, and with a force in
    flight, the Poisson average of a shift register with the nonlinearity and the force in it, up to 64 round trips at a
    time. Beginning and end of contact are located as by :func:`first_contact`.  There is no time step and no error but
    rounding, which the events amplify as the motion itself does.

    It is a motion of the scheme, whose waves lose more energy than the rod's: for the rod see
    :func:`lure.rod.motion.exact_motion`.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme: linear contact law (``m = 1``), ``k >= 0``, and a few more cells than ``d c_n L/c``.
    start : Scenario or array_like
        Initial data with a force: piece by piece, between rational instants, sums and products of numbers, ``t`` (up to
        ``t**8``), and ``exp``, ``sin`` and ``cos`` of straight lines in ``t``.  Or a state in the ordering of the
        scheme, without a force.
    until : float
        End [s].
    samples : int
        Number of instants kept, evenly spaced from 0 to ``until``.

    Raises
    ------
    InputError
        One of these does not hold, there is a body force, there are more than 20 000 flights and stretches, or contact
        can neither be excluded nor found.

    Notes
    -----
    Memory does not depend on the time.  An event costs ``O(N log N)``, and so does a round trip in contact or under a
    force.

    Examples
    --------
    >>> from lure.rod import Rod, builtin_system, upwind
    >>> rod = Rod(
    ...     youngs_modulus=288e6, density=8, length=1, area=0.25e-4, damping=0.3, compliance=3e-10, gap=1e-5
    ... )
    >>> run = structured_motion(upwind(rod, 2000), builtin_system("paper-rod").scenario, 1e-3)
    >>> len(run.contacts), bool(run.z[-1] < 0)
    (1, True)
    """
    _check(scheme, until, samples)
    force, scenario = None, start if isinstance(start, Scenario) else None
    if isinstance(start, Scenario):
        if not start.body_force.is_zero:
            raise InputError(
                f"force.f is {str(start.body_force)[:60]}; structured_motion takes no body force; "
                "lure.analysis.rod.simulation.simulate takes any load, up to 1000 cells"
            )
        force, start = force_of(scheme, start.force, until), initial_state(scheme, start)
    held = free_flight(scheme, start).start
    times = np.linspace(0.0, until, samples)
    rate = Fraction(scheme.rate)
    run = Run(rate=rate, times=times, stop=rate * Fraction(until), force=force, contact=held.gap > 0.0)
    for _ in range(_MOST):
        if run.clock >= run.stop:
            break
        held = run.moved(held)
    else:
        reached = float(run.clock / run.rate)
        raise InputError(
            f"until is {until:g} s, and {_MOST} flights and stretches of contact end at {reached:.6g} s; give an "
            "earlier end"
        )
    return StructuredMotion(
        scheme=scheme,
        scenario=scenario,
        t=times,
        z=run.gaps / scheme.rate,
        wave=run.waves,
        contacts=run.closed(),
        state=held.state,
    )


def _check(scheme: UpwindScheme, until: float, samples: int) -> None:
    rod = scheme.rod
    demand_seconds("until", until)
    demand_whole("samples", samples, 2)
    if rod.exponent != 1.0:
        raise InputError(f"rod.exponent is {rod.exponent:g}; structured_motion takes the linear contact law, give 1")
    if rod.damping < 0.0:
        raise InputError(f"rod.damping is {rod.damping:g}; structured_motion takes no negative one")
    least = fewest_cells(rod.mobility * rod.nonlinearity.stiffness * rod.travel_time)
    if scheme.cells < least:
        raise InputError(f"the contact is too stiff for {scheme.cells} cells; give at least {least}")
