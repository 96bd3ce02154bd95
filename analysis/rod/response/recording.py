r"""A motion watched while it is computed: samples and exact integrals, in memory that the run before does not touch.

How long to wait and to watch: the plan of a long run, and the times in which a rod forgets its start.

Between impacts every wave mode of the rod, and the slow drift of the whole rod among them, decays at one rate,

.. math:: \lambda_w = \frac{\ln(1/|a|)}{2T} = \frac{1}{T}\,\mathrm{artanh}\,\frac{\min(k, Z)}{\max(k, Z)}
    \approx \frac{k}{M} \quad (k \ll Z, \; M = A \rho L).

On an obstacle of stiffness ``A/eps`` the rod as a whole moves like a mass on a spring with the dashpot: the slower root
of ``M s^2 + k s + A/eps = 0`` is the rate ``lambda_c``.  For the paper's rod ``1/lambda_w`` is 1 s, 3000 round trips,
and ``1/lambda_c`` is 6.8 s.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from lure.arrays import Reals as Array
from lure.errors import AssumptionError, InputError, Reason, demand_whole
from lure.record import Record, described, finite, quantity
from lure.rod.motion import Boundary, Contact, Motion, Numerics, Window, exact_motion
from lure.rod.motion.fields import of_pieces
from lure.rod.motion.pieces import Pieces
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

TIME_CONSTANTS = 12.0
MOST_TRIPS = 200_000
_FEWEST = 10
_MOST_SAMPLES = 20_000_000


@described(frozen=True, kw_only=True, slots=True)
class Plan:
    """How a long run is made."""

    settle: float | None = quantity(
        "Time before the watch begins [s], rounded up to whole periods; None for 12 times the slowest time "
        "constant of the rod, at least 10 periods and at most 200 000 round trips",
        default=None,
    )
    run: int = quantity("Periods of the force that are watched, from 8 on", default=64)
    period: float | None = quantity("Period of the loads [s]; None to find it from the formulas", default=None)
    samples: int = quantity(
        "Samples of the motion in a period, from 8 on; the spectrum reaches to half as many times the forcing "
        "frequency",
        default=64,
    )
    tolerance: float = quantity(
        "How closely a motion must repeat to count as periodic, relative to its range", default=1e-6
    )
    separation: bool = quantity(
        "Whether to follow a second motion, pushed a little when the watch begins", default=False
    )
    boundary: Boundary = quantity("What happens at the ends of the rod", default_factory=Boundary)

    def __post_init__(self) -> None:
        if self.settle is not None and not 0.0 <= self.settle < math.inf:
            raise InputError(f"settle is {self.settle!r}; give a number of seconds from 0 on")
        demand_whole("run, the periods watched,", self.run, 8, 1_000_000)
        demand_whole("samples", self.samples, 8, 1_000_000)
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
        "stiffness of its own (rigid, power law, another nonlinearity) and for a clamped rod",
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

    ``plan``: its ``settle`` and boundary conditions; ``period``: of the force [s].

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
                f"rod.damping is {rod.damping:g}, so that motions grow; give the time to wait, settle, to watch one",
                code=Reason.UNDAMPED,
            )
        if math.isinf(slow):
            raise AssumptionError(
                "no dashpot takes energy out, so that the rod never forgets its start; give the time to wait, settle",
                code=Reason.UNDAMPED,
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
    if (
        boundary.clamped
        or boundary.rigid
        or boundary.nonlinearity is not None
        or rod.exponent != 1.0
        or not damping > 0.0
    ):
        return None
    mass, stiffness = rod.area * rod.density * rod.length, rod.area / rod.compliance
    half, product = 0.5 * damping / mass, stiffness / mass
    if half * half <= product:
        return 1.0 / half
    return (half + math.sqrt(half * half - product)) / product


Progress = Callable[[str, float], None]
_EVERY = 32


@described(frozen=True, kw_only=True, eq=False)
class Recording:
    """What is kept of a watch."""

    rod: Rod = quantity("The rod")
    boundary: Boundary = quantity("What happens at its ends")
    t: Array = quantity("(n+1,) times, equally spaced from the start of the watch to its end", "s")
    z: Array = quantity("(n+1,) contact coordinate", "m")
    v: Array = quantity("(n+1,) end velocity ``z'`` [m/s]")
    contact_impulses: Array = quantity("(R,) ``A int p dt`` over each period of the watch [N s]")
    returned: Array = quantity("(R,) ``int V dt`` over each, one transit earlier: what reaches ``x = 0``", "m")
    touched: tuple[Contact, ...] = quantity("Every contact that lies in the watch or reaches into it, in order")

    @property
    def impacts(self) -> tuple[Contact, ...]:
        """The contacts that begin during the watch."""
        return tuple(impact for impact in self.touched if self.t[0] <= impact.start < self.t[-1])

    @property
    def contacts(self) -> tuple[tuple[float, float], ...]:
        """Start and end of contact, cut to the watch [s]."""
        low, high = float(self.t[0]), float(self.t[-1])
        ends = (each.end if each.closed else high for each in self.touched)
        spans = ((max(each.start, low), min(end, high)) for each, end in zip(self.touched, ends, strict=True))
        return tuple((start, end) for start, end in spans if start < end)


class Watch:
    """Takes the windows of a motion as they come, and keeps what happens from the first of its times to the last.

    Parameters
    ----------
    rod : Rod
        The rod.
    boundary : Boundary
        What happens at its ends.
    times : ndarray
        (n+1,) ascending [s].
    samples : int
        Samples in a period; ``n`` is a multiple of it.

    Attributes
    ----------
    boundary : Boundary
        As given.
    t : ndarray
        The times.
    """

    def __init__(self, rod: Rod, boundary: Boundary, times: Array, samples: int) -> None:
        self._rod, self.boundary, self.t = rod, boundary, times
        self._times = times / rod.travel_time
        self._next = 0
        self._z, self._v = np.empty(times.size), np.empty(times.size)
        self._periods = self._times[::samples]
        self._pushed, self._returned = np.zeros(self._periods.size - 1), np.zeros(self._periods.size - 1)
        self._touched: list[Contact] = []
        self._open: Contact | None = None

    @property
    def done(self) -> bool:
        """Whether all of its times have passed."""
        return self._next == self._times.size

    def see(self, window: Window) -> None:
        """Keep what the watch wants of a window."""
        origin, span = 2.0 * window.number, float(window.edges[-1])
        if origin + span < float(self._times[0]) - 1.0 or self.done:
            return
        start = float(self.t[0])
        self._touched += [impact for impact in window.impacts if impact.end > start]
        self._open = window.end.impact
        self._add(self._pushed, window.edges, window.push, origin)
        self._add(self._returned, window.edges, window.returned, origin + 1.0)
        self._sample(window, origin, span)

    def record(self) -> Recording:
        """What was kept, once it is done."""
        assert self.done, "a watch is read when all of its times have passed"
        rod, loss = self._rod, 1.0 + self.boundary.end_damping / self._rod.impedance
        begun = [*self._touched] if self._open is None else [*self._touched, self._open]
        return Recording(
            rod=rod,
            boundary=self.boundary,
            t=self.t,
            z=self._z,
            v=self._v,
            contact_impulses=rod.area * loss / rod.mobility * self._pushed,
            returned=self._returned,
            touched=tuple(impact for impact in begun if impact.start < self.t[-1]),
        )

    def _sample(self, window: Window, origin: float, span: float) -> None:
        is_last = origin + span >= self._times[-1] * (1.0 - 1e-15)
        stop = self._times.size if is_last else int(np.searchsorted(self._times, origin + span))
        chosen = slice(self._next, stop)
        if stop > self._next:
            local = np.clip(self._times[chosen] - origin, 0.0, span)
            self._z[chosen] = Pieces(window.edges, window.z)(local)
            self._v[chosen] = Pieces(window.edges, 0.5 * (window.wave + window.returned))(local)
            self._next = stop

    def _add(self, sums: Array, edges: Array, series: Array, origin: float) -> None:
        """Add the integral of a series that starts at an instant to the periods it reaches into."""
        at = np.clip(self._periods - origin, edges[0], edges[-1])
        (reached,) = np.nonzero(at[1:] > at[:-1])
        sums[reached] += self._rod.travel_time * of_pieces(Pieces(edges, series), at[reached], at[reached + 1])


def follow(rod: Rod, scenario: Scenario, watches: Sequence[Watch], progress: Progress | None = None) -> Motion:
    """Follow a motion to the end of the last watch; every watch has seen what went by if it is interrupted.

    ``watches``: in the order of their times, one at least; ``progress``: called as ``progress(text, share)``.
    """
    until = float(watches[-1].t[-1])
    first, trip = float(watches[0].t[0]), 2.0 * rod.travel_time

    def see(window: Window) -> None:
        """Show the window to all."""
        if progress is not None and window.number % _EVERY == 0:
            now = trip * window.number
            progress("waiting for transients" if now < first else "watching", min(now / until, 1.0))
        for watch in watches:
            watch.see(window)

    return exact_motion(rod, scenario, until, boundary=watches[0].boundary, numerics=Numerics(keep=2, on_window=see))
