r"""Where the rod comes to rest without a load, against how it starts.

Its equilibria are a half-line: at rest anywhere short of the obstacle.  Which of them is taken is decided by

.. math:: \zeta(t) = z(t) - \frac{a}{1 + a} \int_{t - 2T}^{t} V, \qquad V = r_2(\cdot, L), \qquad
    \zeta' = -\frac{A}{k}\,p(z) \le 0,

which free flight keeps: after the last contact the rod comes to rest at ``z = zeta``.  In free flight ``z - zeta`` is
multiplied by ``-a`` in every round trip, so that two round trips in succession without contact and ``zeta <= 0`` mean
that there is none later.
"""

from __future__ import annotations

import math

import numpy as np

from lure.analysis.rod.response.plan import MOST_TRIPS, contact_time, wave_rate
from lure.analysis.rod.response.recording import means
from lure.errors import AssumptionError
from lure.record import Record, quantity
from lure.rod.motion import Boundary, Window, motion_windows
from lure.rod.motion.pieces import basis
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

_TIME_CONSTANTS = 60.0
_FEWEST_TRIPS = 100
_QUIET = 2
_KNOWN = 1e-9


class Rest(Record):
    """Where one motion ends."""

    low: float = quantity("Lower bound of the resting place ``z``", "m")
    high: float = quantity("Upper bound; equal to the lower, to rounding, if no contact follows", "m")
    impacts: int = quantity("Contacts that ended before the motion was left")
    settled: bool = quantity(
        "Whether no contact follows: in two round trips in succession there was none, and ``zeta <= 0``"
    )
    known: bool = quantity(
        "Whether the bounds agree to 1e-9 of the largest ``|z|`` met, whether or not contact follows: a rod may "
        "creep out of the obstacle for ever"
    )
    time: float = quantity("When the motion was left", "s")

    def __str__(self) -> str:
        if self.settled:
            return f"Comes to rest at z = {self.high:.9g} m after {self.impacts} impacts; it does not touch again."
        if self.known:
            return f"Comes to rest at z = {self.high:.9g} m after {self.impacts} impacts; contact may go on till then."
        return (
            f"INCONCLUSIVE: after {self.time:.4g} s and {self.impacts} impacts contact may follow; it comes to rest "
            f"between z = {self.low:.6g} m and {self.high:.6g} m."
        )


def resting_place(rod: Rod, scenario: Scenario, *, rigid: bool = False, until: float | None = None) -> Rest:
    r"""Where the rod comes to rest without a load.

    Parameters
    ----------
    rod : Rod
        The rod, ``k > 0``.
    scenario : Scenario
        Initial data; no loads.
    rigid : bool
        Whether the obstacle is rigid.
    until : float, optional
        Longest time that is followed [s]; by default 60 time constants of the rod, between 100 and 200 000 round
        trips.

    Returns
    -------
    Rest
        ``zeta`` if no contact follows.  Otherwise bounds: ``zeta`` never increases, the resting place is at most 0, and
        after the last release, where ``z = 0``,

        .. math:: \zeta = -\frac{a}{1+a} \int V \ge -\frac{1}{1 + a} \sqrt{8\,T E / Z}, \qquad E' \le 0.

    Raises
    ------
    AssumptionError
        There is a load, or ``k <= 0``: without loss the rod does not come to rest; or the first round trip cannot be
        followed.  Where a later one cannot, the bounds are those before it.
    """
    if not scenario.free:
        raise AssumptionError("a rod under a load does not come to rest; give g = 0 and f = 0, or ask for its response")
    if not rod.damping > 0:
        raise AssumptionError(f"the rod comes to rest for k > 0 only; the damping is {rod.damping:g} N s/m")
    boundary = Boundary(rigid=rigid)
    T = rod.travel_time
    if until is None:
        slow = max(1.0 / wave_rate(rod, boundary), contact_time(rod, boundary) or 0.0)
        until = 2.0 * T * min(max(_TIME_CONSTANTS * slow / (2.0 * T), _FEWEST_TRIPS), MOST_TRIPS)
    until = 2.0 * T * max(math.floor(until / (2.0 * T)), 1)
    one_plus_a = 2.0 * rod.damping * rod.input_gain
    impacts, quiet, scale = 0, 0, abs(scenario.contact_coordinate(rod))
    found = Rest(low=-math.inf, high=0.0, impacts=0, settled=False, known=False, time=0.0)
    try:
        for window in motion_windows(rod, scenario, until, boundary=boundary):
            impacts += len(window.impacts)
            end = float(window.z[-1].sum())
            scale = max(scale, abs(end))
            travelled = T * float(means(window.returned) @ np.diff(window.edges))
            zeta = end - rod.reflection / one_plus_a * travelled
            quiet = quiet + 1 if not window.push.any() and window.end.impact is None else 0
            settled = quiet >= _QUIET and zeta <= 0.0
            reach = math.sqrt(8.0 * T * _energy(rod, window, rigid=rigid) / rod.impedance) / one_plus_a
            high = min(zeta, 0.0)
            low = high if settled else min(high, -reach)
            known = high - low <= _KNOWN * scale
            time = 2.0 * T * (window.number + 1)
            found = Rest(low=low, high=high, impacts=impacts, settled=settled, known=known, time=time)
            if settled or (known and window.end.impact is not None):
                break
    except AssumptionError as error:
        if found.time == 0.0:
            raise error from None
    return found


def _energy(rod: Rod, window: Window, *, rigid: bool) -> float:
    """A bound on the energy after a window: ``Z/4 int V^2 + A P(z)`` [J]."""
    space = basis(window.returned.shape[1] - 1)
    half = 0.5 * rod.travel_time * np.diff(window.edges)[:, None] * space.weights
    waves = 0.25 * rod.impedance * float((half * (window.returned @ space.at_gauss.T) ** 2).sum())
    return waves + (0.0 if rigid else rod.area * float(rod.law.primitive(np.array(window.z[-1].sum()))))
