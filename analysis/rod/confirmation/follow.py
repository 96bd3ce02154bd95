"""The exact motion of the rod followed as far as is needed, and whether it can still reach the obstacle after that."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from lure.analysis.rod.confirmation.functionals import zeta_gain
from lure.errors import AssumptionError, InputError
from lure.record import described, quantity
from lure.rod.motion import Window, motion_windows
from lure.rod.motion.pieces import Array, basis, right_ends, supremum
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario
from lure.rod.transfer import RodPlant

# Whether a rod that moves freely can still reach the obstacle: bounds on whole intervals, not on samples.

_ROUNDING = 32.0 * np.finfo(float).eps


@described(frozen=True, kw_only=True, slots=True)
class Flight:
    """Free flight for ever, from the end of a round trip on."""

    start: float = quantity("Contact coordinate at its beginning", "m")
    zeta: float = quantity("Where it goes", "m")
    highest_low: float = quantity("Lower bound on the supremum of ``z`` over all later times", "m")
    highest_high: float = quantity("Upper bound on it", "m")

    @property
    def final(self) -> bool:
        """Whether no contact can follow."""
        return self.highest_high < 0.0


def flight_after(rod: Rod, window: Window) -> Flight:
    r"""Free flight after a round trip at the end of which the obstacle is not touched.

    The next round trip brings ``W(tau) = -a V`` of the last one, and with ``C(tau) = int_0^tau W``,
    ``D = C - (zeta - z_0)``, ``zeta = z_0 + C(2T)/(1 + a)``, the flight is known for ever:

    .. math:: z(2T m + \tau) = \zeta + (-a)^m D(\tau), \qquad m = 0, 1, 2, \ldots

    As ``|a| < 1`` its supremum is the largest of ``zeta`` (in the limit), ``zeta + sup D`` (in the first round trip)
    and ``zeta - a inf D`` (for ``a > 0``, in the second).  ``sup D`` is bracketed: from below by values, from above by
    bounds on Chebyshev series over whole pieces, which are halved until both ends agree to rounding.  It is the
    continuous counterpart of the bound on the shift register of the scheme.

    ``rod``: the rod, ``k > 0``; ``window``: the whole round trip before.

    Notes
    -----
    COMPUTED: floating point; the upper end of the bracket contains an allowance for rounding.
    """
    a = rod.reflection
    space = basis(window.returned.shape[1] - 1)
    widths = np.diff(window.edges)
    travel = (-0.5 * a * rod.travel_time * widths)[:, None] * (window.returned @ space.integral.T)
    passed = np.concatenate(([0.0], np.cumsum(right_ends(travel))))
    travel[:, 0] += passed[:-1]
    start = float(right_ends(window.z)[-1])
    away = float(passed[-1]) * zeta_gain(rod) / rod.travel_time
    departures = travel.copy()
    departures[:, 0] -= away
    low, high = supremum(departures)
    if a > 0.0:
        low_again, high_again = (a * end for end in supremum(-departures))
        low, high = max(low, low_again), max(high, high_again)
    size = float(np.abs(departures).sum(axis=1).max()) + abs(away) + abs(start)
    zeta = start + away
    return Flight(
        start=start,
        zeta=zeta,
        highest_low=zeta + max(0.0, low),
        highest_high=zeta + max(0.0, high) + _ROUNDING * size,
    )


# The exact motion of the rod followed as far as is needed, and no further than is quick.

MOST_TRIPS = 1900  # so few that nothing is compiled for them: the report does not depend on what is installed
_MOST_WORK = 1500.0
_CHECKED_TRIPS = 16
_DECAYED, _RESOLVED = 1e-13, 1e-10
_SETTLED, _GROWN = math.log(1e-14), math.log(1e60)


@described(frozen=True, kw_only=True, eq=False, slots=True)
class Followed:
    """The round trips of a motion that were followed."""

    windows: tuple[Window, ...] = quantity("From the start on")
    flight: Flight | None = quantity("The free flight that is final; None if there is none yet, or none to look for")
    flight_from: int = quantity("Number of round trips before it")
    leans: bool = quantity(
        "Whether the waves have decayed and the end is at the obstacle: it leans on it, ever more lightly"
    )
    shortened: str | None = quantity("Why the motion was not followed further")


def follow(rod: Rod, scenario: Scenario, until: float) -> Followed:
    """Follow the rod up to ``until``, and without loads and for ``k > 0`` on until no contact can follow.

    After that it is followed until the ringing has decayed to ``1e-14``, if that takes few round trips, else for 16
    more, along which the closed form of free flight can be compared.  At most 1900 round trips, fewer where contacts
    make them dear; for ``k < 0`` at most until the waves have grown by ``1e60``.

    ``until``: end of the motion that is asked for [s].

    Raises
    ------
    InputError
        The exact solver refuses in the first round trip: see :func:`lure.rod.motion.exact_motion`.
    AssumptionError
        Likewise.
    """
    round_trip = 2.0 * rod.travel_time
    asked = max(1, math.ceil(min(until / round_trip, 1e9) * (1.0 - 1e-15)))
    most = MOST_TRIPS if rod.damping >= 0 else min(MOST_TRIPS, _until_grown(rod))
    watch = _Watch(rod=rod, settles=scenario.free and rod.damping > 0, stop=min(asked, most), most=most)
    # a quarter of a round trip more, so that the last one is whole; loads are not asked for beyond the end
    end = round_trip * ((most if watch.settles else watch.stop) + 0.25)
    shortened = None
    try:
        for window in motion_windows(rod, scenario, end if scenario.free else min(end, until)):
            if watch.windows and not watch.resolves(window):
                shortened = (
                    f"after {len(watch.windows)} round trips the estimated error of the exact motion exceeds 1e-10 of "
                    "its size, and it is followed no further"
                )
                break
            watch.add(window)
            if watch.done:
                break
    except (InputError, AssumptionError) as refusal:
        if not watch.windows:
            raise
        shortened = f"after {len(watch.windows)} round trips the exact solver stops: {refusal}"
    if shortened is None and len(watch.windows) < asked:
        shortened = (
            f"the exact motion was followed for {len(watch.windows)} round trips, up to "
            f"{len(watch.windows) * round_trip:.4g} s of the {until:.4g} s asked for, to keep the report quick"
        )
    return Followed(
        windows=tuple(watch.windows),
        flight=watch.flight,
        flight_from=watch.flight_from,
        leans=watch.leans,
        shortened=shortened,
    )


@dataclass(kw_only=True, eq=False, slots=True)
class _Watch:
    """Round trips so far, and whether there are enough of them."""

    rod: Rod
    settles: bool
    stop: int
    most: int
    windows: list[Window] = field(default_factory=list)
    flight: Flight | None = None
    flight_from: int = 0
    leans: bool = False
    work: float = 0.0
    wave: float = 0.0
    depth: float = 0.0
    error: float = 0.0

    def add(self, window: Window) -> None:
        """Enter the next round trip."""
        self.windows.append(window)
        self.error += window.error
        self.work += 0.3 + window.crossings + len(window.wave) * (0.05 if self.rod.exponent == 1.0 else 1.0)
        wave, depth = max(_size(window.wave), _size(window.returned)), _size(window.z)
        self.wave, self.depth = max(self.wave, wave), max(self.depth, depth)
        self.leans = self.settles and wave <= _DECAYED * self.wave and depth <= _DECAYED * self.depth
        if not self.settles or self.flight is not None or len(self.windows) < self.stop:
            return
        if self.leans or window.end.impact is not None:
            return
        found = flight_after(self.rod, window)
        if found.final:
            self.flight, self.flight_from = found, len(self.windows)
            needed = trips_to_settle(self.rod)
            self.stop = len(self.windows) + (int(needed) if needed <= MOST_TRIPS else _CHECKED_TRIPS)

    @property
    def done(self) -> bool:
        """Whether nothing more is to be learnt, or it would take too long."""
        if len(self.windows) >= self.most or self.work > _MOST_WORK:
            return True
        return len(self.windows) >= self.stop and (not self.settles or self.leans or self.flight is not None)

    def resolves(self, window: Window) -> bool:
        """Whether the estimates of all errors stay below ``1e-10`` of the motion."""
        return self.error + window.error <= _RESOLVED * max(self.depth, self.wave * self.rod.travel_time)


def _size(series: Array) -> float:
    return float(np.abs(series).sum(axis=1).max())


def ringing(rod: Rod, trips: float) -> float:
    """``(-a)^m`` after ``m`` round trips, which is what is left of the departure from rest.

    ``rod``: the rod, ``k > 0``; ``trips``: whole number ``m``.
    """
    if rod.reflection == 0.0:
        return 1.0 if trips == 0 else 0.0
    size = math.exp(trips * RodPlant(rod).log_reflection)
    return size if rod.reflection < 0 or trips % 2 == 0 else -size


def trips_to_settle(rod: Rod) -> float:
    """Round trips until the ringing is below ``1e-14`` of what it was; ``inf`` where doubles see no damping.

    ``rod``: the rod, ``k > 0``.
    """
    rate = -RodPlant(rod).log_reflection
    return 1.0 + math.ceil(-_SETTLED / rate) if rate > 0.0 and -_SETTLED / rate < 1e300 else math.inf


def _until_grown(rod: Rod) -> int:
    """Round trips in which the waves grow by ``1e60``, for ``k < 0``."""
    growth = math.log(abs(rod.reflection))
    return max(1, int(min(_GROWN / growth, 1e9))) if growth > 0.0 else MOST_TRIPS


def closed_form_error(rod: Rod, followed: Followed) -> float:
    """Largest difference between the closed form of the final free flight and its continuation step by step [m]."""
    assert followed.flight is not None
    flight, later = followed.flight, followed.windows[followed.flight_from :]
    stepped = np.array([float(right_ends(window.z)[-1]) for window in later])
    closed = [flight.zeta + ringing(rod, m + 1) * (flight.start - flight.zeta) for m in range(len(later))]
    return float(np.abs(stepped - np.array(closed)).max(initial=0.0))


def momentum_allowance(rod: Rod, windows: tuple[Window, ...]) -> float:
    """What rounding and the errors of the series may be expected to add to ``zeta`` [m].

    ``rod``: the rod, ``k != 0``.
    """
    gain = abs(zeta_gain(rod))
    wave, z = max(_size(window.returned) for window in windows), max(_size(window.z) for window in windows)
    error = math.fsum(window.error for window in windows)
    return 1e-13 * (z + 4.0 * gain * wave) * (1.0 + math.sqrt(len(windows))) + 4.0 * error * (
        1.0 + gain / rod.travel_time
    )
