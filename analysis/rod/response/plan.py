r"""How long to wait and to watch: the plan of a long run, and the times in which a rod forgets its start.

Between impacts every wave mode of the rod, and the slow drift of the whole rod among them, decays at one rate,

.. math:: \lambda_w = \frac{\ln(1/|a|)}{2T} = \frac{1}{T}\,\mathrm{artanh}\,\frac{\min(k, Z)}{\max(k, Z)}
    \approx \frac{k}{M} \quad (k \ll Z, \; M = A \rho L).

On an obstacle of stiffness ``A/eps`` the rod as a whole moves like a mass on a spring with the dashpot: the slower root
of ``M s^2 + k s + A/eps = 0`` is the rate ``lambda_c``.  For the paper's rod ``1/lambda_w`` is 1 s, 3000 round trips,
and ``1/lambda_c`` is 6.8 s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from lure.errors import AssumptionError, InputError
from lure.record import Record, finite, quantity
from lure.rod.motion import Boundary
from lure.rod.parameters import Rod

TIME_CONSTANTS = 12.0
MOST_TRIPS = 200_000
_FEWEST = 10
_MOST_SAMPLES = 20_000_000


@dataclass(frozen=True, kw_only=True, slots=True)
class Plan:
    """How a long run is made.

    Attributes
    ----------
    settle : float or None
        Time before the watch begins [s], rounded up to whole periods; None for 12 times the slowest time constant of
        the rod, at least 10 periods and at most 200 000 round trips.
    run : int
        Periods of the force that are watched, from 8 on.
    period : float or None
        Period of the loads [s]; None to find it from the formulas.
    samples : int
        Samples of the motion in a period, from 8 on; the spectrum reaches to half as many times the forcing frequency.
    tolerance : float
        How closely a motion must repeat to count as periodic, relative to its range.
    separation : bool
        Whether to follow a second motion, pushed a little when the watch begins.
    boundary : Boundary
        What happens at the ends of the rod.
    """

    settle: float | None = None
    run: int = 64
    period: float | None = None
    samples: int = 64
    tolerance: float = 1e-6
    separation: bool = False
    boundary: Boundary = field(default_factory=Boundary)

    def __post_init__(self) -> None:
        if self.settle is not None and not 0.0 <= self.settle < math.inf:
            raise InputError(f"settle is {self.settle!r}; give a number of seconds from 0 on")
        for name, is_ in (("run", "run, the periods watched,"), ("samples", "samples")):
            number = getattr(self, name)
            if isinstance(number, bool) or not isinstance(number, int) or not 8 <= number <= 1_000_000:
                raise InputError(f"{is_} is {number!r}; give a whole number from 8 to 1000000")
        if self.run * self.samples > _MOST_SAMPLES:
            raise InputError(f"run * samples is {self.run * self.samples}; give at most {_MOST_SAMPLES}")
        if not 0.0 < self.tolerance < 1.0:
            raise InputError(f"tolerance is {self.tolerance!r}; give a number between 0 and 1")


class Settling(Record):
    """How long was waited, and how long the rod remembers."""

    time: float = quantity("Time before the watch begins", "s", key="settle_s")
    periods: int = quantity("The same in periods of the force", key="settle_periods")
    wave_time: float = quantity(
        "``1/lambda_w`` [s]; infinite without a dashpot, 0 for a matched one",
        key="wave_time_constant_s",
        plainly=finite,
    )
    contact_time: float | None = quantity(
        "``1/lambda_c`` of the rod as one mass on its obstacle, an estimate [s]; None for an obstacle without a "
        "stiffness of its own (rigid, power law, another law) and for a clamped rod",
        key="contact_time_constant_s",
    )
    note: str = quantity("What was cut short, or nothing", default="", key="settle_note")

    @property
    def constants(self) -> float:
        """``time`` in units of the slower time constant."""
        slow = max(self.wave_time, self.contact_time or 0.0)
        return self.time / slow if slow > 0.0 else math.inf

    def __str__(self) -> str:
        about = f"{self.constants:.3g} times the slowest time constant of the rod"
        about = about if self.constants < math.inf else "a rod that forgets its start in one round trip"
        return f"Watched after {self.periods} periods ({self.time:.6g} s), {about}. {self.note}".rstrip()


def settling(rod: Rod, plan: Plan, period: float) -> Settling:
    """Time to wait before a motion is looked at.

    Parameters
    ----------
    rod : Rod
        The rod.
    plan : Plan
        Its ``settle`` and boundary conditions.
    period : float
        Of the force [s].

    Raises
    ------
    AssumptionError
        The rod forgets nothing (no dashpot) or gains energy (``k < 0``), and no time is given.
    """
    rate = wave_rate(rod, plan.boundary)
    contact = contact_time(rod, plan.boundary)
    slow = max(1.0 / rate if rate > 0.0 else math.inf, contact or 0.0)
    wanted, note = plan.settle, ""
    if wanted is None:
        if rod.damping < 0 and not plan.boundary.clamped:
            raise AssumptionError(
                f"rod.damping is {rod.damping:g}, so that motions grow; give the time to wait, settle, to watch one"
            )
        if math.isinf(slow):
            raise AssumptionError(
                "no dashpot takes energy out, so that the rod never forgets its start; give the time to wait, settle"
            )
        wanted, most = TIME_CONSTANTS * slow, 2.0 * rod.travel_time * MOST_TRIPS
        if wanted > most:
            note = (
                f"{TIME_CONSTANTS:g} time constants would be {wanted:.4g} s; cut to {MOST_TRIPS} round trips, give "
                "settle for more."
            )
            wanted = most
        wanted = max(wanted, _FEWEST * period)
    periods = math.ceil(wanted / period * (1.0 - 1e-12))
    wave_time = 1.0 / rate if rate > 0.0 else math.inf
    return Settling(time=periods * period, periods=periods, wave_time=wave_time, contact_time=contact, note=note)


def wave_rate(rod: Rod, boundary: Boundary) -> float:
    """``lambda_w = ln(1/|a a_L|)/2T`` with the echoes ``a``, ``a_L`` of both ends [1/s]; 0 if nothing is lost."""
    echoes = [0.0 if boundary.clamped else rod.damping, boundary.end_damping]
    total = 0.0
    for damping in echoes:
        ratio = damping / rod.impedance
        ratio = 1.0 / ratio if abs(ratio) > 1.0 else ratio
        total += math.copysign(math.inf, ratio) if abs(ratio) == 1.0 else math.atanh(ratio)
    return max(total, 0.0) / rod.travel_time


def contact_time(rod: Rod, boundary: Boundary) -> float | None:
    """``1/lambda_c`` of the mass of the rod on a linear obstacle [s]; None if the obstacle has no stiffness."""
    damping = rod.damping + boundary.end_damping
    if boundary.clamped or boundary.rigid or boundary.law is not None or rod.exponent != 1.0 or not damping > 0.0:
        return None
    mass, stiffness = rod.area * rod.density * rod.length, rod.area / rod.compliance
    half, product = 0.5 * damping / mass, stiffness / mass
    if half * half <= product:
        return 1.0 / half
    return (half + math.sqrt(half * half - product)) / product
