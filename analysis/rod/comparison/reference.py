"""The exact motion of the rod, sampled, and the first kink of its end or contact."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from lure.arrays import Reals as Array
from lure.record import described, quantity
from lure.rod.motion import Motion, exact_motion
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

_ENERGIES = 201
_ASIDE, _JUMP = 1e-9, 1e-6


@described(frozen=True, kw_only=True, slots=True)
class FirstEvent:
    """Where the motion of the end stops being smooth."""

    t: float = quantity("When", "s")
    kind: str = quantity('``"kink"``, a jump of ``v(t, L)``, or ``"contact"``, the beginning of contact')

    def __str__(self) -> str:
        """As in a sentence."""
        return f"the first {self.kind}, t = {self.t:.4g} s"


@described(frozen=True, kw_only=True, slots=True, eq=False)
class Reference:
    """What every other motion is held against; COMPUTED evidence, about the rod."""

    motion: Motion = quantity("The exact motion")
    t: Array = quantity("(samples,) instants", "s")
    u: Array = quantity("(samples,) ``u(t, L)``", "m")
    amplitude: float = quantity("Half of what ``u(t, L)`` spans over the run", "m")
    places: NDArray[np.intp] = quantity("Indices of the samples at which the energy is compared")
    energy: Array = quantity("(places,) ``A int (rho v^2 + E w^2)/2 dx + A P(z)``", "J")
    event: FirstEvent | None = quantity("The first kink or contact; None if there is none up to the end")
    cpu_seconds: float = quantity("CPU time of the process for the motion", "s")


def reference(rod: Rod, scenario: Scenario, until: float, samples: int) -> Reference:
    """The exact motion at evenly spaced samples.

    ``rod``, ``scenario``, ``until``: the rod, its loads and initial data, and the end [s]; ``samples``: number of
    instants.
    """
    before = time.process_time()
    motion = exact_motion(rod, scenario, until)
    t = np.linspace(0.0, until, samples)
    u = motion.end_displacement(t)
    spent = time.process_time() - before
    places = np.unique(np.linspace(0, samples - 1, min(samples, _ENERGIES)).round().astype(np.intp))
    return Reference(
        motion=motion,
        t=t,
        u=u,
        amplitude=0.5 * float(u.max() - u.min()),
        places=places,
        energy=motion.energies(t[places]),
        event=first_event(motion),
        cpu_seconds=spent,
    )


def first_event(motion: Motion) -> FirstEvent | None:
    """The first jump of ``v(t, L)`` or the first contact, whichever comes first.

    Jumps start at the ends at ``t = 0``, where the data or the force change their formula, or not at all; each is
    looked at when it arrives at ``x = L``, from both sides.  A formula whose breaks are not known is taken for smooth.

    ``motion``: all of it, from ``t = 0`` on.
    """
    rod, scenario, T = motion.rod, motion.scenario, motion.rod.travel_time
    arrivals = {T, 2.0 * T}
    for data in (scenario.displacement, scenario.velocity):
        for place in map(float, data.breakpoints("x", 0, rod.exact["length"]) or ()):
            arrivals |= {T - place / rod.wave_speed, T + place / rod.wave_speed}
    for load, delay in ((scenario.force, T), (scenario.body_force, 0.0)):
        arrivals |= {float(instant) + delay for instant in load.breakpoints("t", 0, motion.until) or ()}
    inside = np.array(sorted(t for t in arrivals if 0.0 < t < motion.until * (1.0 - _ASIDE)))
    found = []
    if inside.size:
        sides = motion.end_velocity(np.add.outer(np.array([-_ASIDE * T, _ASIDE * T]), inside))
        sized = float(np.abs(motion.end_velocity(np.linspace(0.0, motion.until, 257))).max())
        jumps = inside[np.abs(sides[1] - sides[0]) > _JUMP * sized]
        found = [FirstEvent(t=float(jumps[0]), kind="kink")] if jumps.size else []
    if motion.impacts:
        found.append(FirstEvent(t=motion.impacts[0].start, kind="contact"))
    return min(found, key=lambda event: event.t, default=None)
