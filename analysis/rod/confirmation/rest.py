"""Where the rod and where its scheme come to rest: predicted from momentum, and shown by the motion."""

from __future__ import annotations

import math

import numpy as np

from lure.analysis.rod.confirmation.follow import Followed, closed_form_error, momentum_allowance, ringing
from lure.analysis.rod.confirmation.follow import trips_to_settle as settling_trips
from lure.analysis.rod.confirmation.result import Rest
from lure.analysis.rod.simulation import Trajectory
from lure.errors import InputError
from lure.expressions import Expression
from lure.rod.discretisation import UpwindScheme
from lure.rod.motion import Window
from lure.rod.motion.pieces import Array, basis, distinct, fitted, right_ends
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario
from lure.rod.scheme import structured_motion
from lure.rod.transfer import RodPlant

_LEFT = math.log(1e13)
_DEGREE = 16


def initial_zeta(rod: Rod, scenario: Scenario) -> float:
    r"""``zeta(0)`` from the initial data, without the waves.

    .. math:: \zeta(0) = u_0(L) - \mathrm{gap} - \int_0^L u_0'\,dx + \frac{\rho A}{k} \int_0^L u_1\,dx ,

    the position of the dashpot and the momentum over ``k``.

    ``rod``: the rod, ``k != 0``.

    Returns
    -------
    float
        [m].
    """
    momentum = rod.density * rod.area * _mean(scenario.velocity, scenario.velocity, rod) * rod.length
    stretch = _mean(scenario.displacement.derivative("x"), scenario.displacement, rod) * rod.length
    return scenario.contact_coordinate(rod) - stretch + momentum / rod.damping


def _mean(data: Expression, kinks: Expression, rod: Rod) -> float:
    """Mean over the rod, between the kinks of another expression by series."""
    L = rod.length

    def sampled(s: Array) -> tuple[Array, Array]:
        """The data at ``x = L s``."""
        return np.asarray(data(x=L * s), dtype=float), np.zeros(len(s))

    edges = distinct([float(place) / L for place in kinks.breakpoints("x", 0.0, L) or ()], 0.0, 1.0)
    pieces, _ = fitted(sampled, edges, _DEGREE, 0.0)
    return float((0.5 * pieces.widths) @ right_ends(pieces.series @ basis(_DEGREE).integral.T))


def impulse_of(windows: tuple[Window, ...]) -> float:
    """``A int p dt`` over the round trips [N s]; ``windows``: from the start on."""
    done = [impact.impulse for window in windows for impact in window.impacts]
    going = windows[-1].end.impact
    return math.fsum(done) + (0.0 if going is None else going.impulse)


def rest_of_rod(rod: Rod, scenario: Scenario, followed: Followed, largest: float) -> Rest | None:
    """The resting place of the rod, if its final free flight was reached.

    Predicted from the initial data and the impulses; shown by the motion when its ringing has decayed: followed step by
    step if that takes few round trips, else continued from the last contact (from the start if there was none) by the
    closed form of free flight, a multiplication by ``-a`` per round trip, with which the steps that were taken agree.

    Parameters
    ----------
    rod, scenario
        The rod, ``k > 0``, without loads.
    followed : Followed
        Its motion.
    largest : float
        Largest ``|z|`` along it [m].
    """
    if followed.flight is None and not followed.leans:
        return None
    flight, T = followed.flight, rod.travel_time
    predicted = initial_zeta(rod, scenario) - impulse_of(followed.windows) / rod.damping
    taken, needed = len(followed.windows) - followed.flight_from, settling_trips(rod)
    if flight is None or taken >= needed:
        shown = float(right_ends(followed.windows[-1].z)[-1])
        at, way = 2.0 * T * len(followed.windows), "followed until the ringing had decayed"
        if flight is None:
            way = "followed until the waves had decayed, leaning on the obstacle ever more lightly"
    else:
        trips = min(needed, 1e300)
        shown = flight.zeta + ringing(rod, trips) * (flight.start - flight.zeta)
        at = 2.0 * T * (followed.flight_from + trips)
        way = (
            f"followed for {len(followed.windows)} round trips, of which the last {taken} agree with the closed form "
            f"of free flight within {closed_form_error(rod, followed):.1g} m, then by that form"
        )
    return Rest.of((predicted, shown), at, way, momentum_allowance(rod, followed.windows), largest)


def rest_of_scheme(scheme: UpwindScheme, scenario: Scenario, run: Trajectory) -> Rest | str:
    """The resting place of the scheme, or why there is none to compare.

    Predicted from the first state and the impulses of the simulation; shown by a second solver of the scheme, from
    event to event by its eigenvectors, at a time when the ringing has decayed.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme that was simulated, ``k > 0``.
    scenario : Scenario
        Its initial data; no loads.
    run : Trajectory
        The simulation.
    """
    if not run.rest_is_final or run.zeta is None or run.rest_position is None:
        return f"contact is going on or can still come at t = {float(run.t[-1]):.4g} s"
    predicted = float(run.zeta[0]) - math.fsum(contact.impulse for contact in run.contacts) / scheme.rod.damping
    at = float(run.t[-1]) + _decay_time(scheme)
    try:
        shown = float(structured_motion(scheme, scenario, at, samples=2).z[-1])
        way = "a second solver, from event to event, until the ringing had decayed"
    except InputError:
        # a power law, or contact too stiff for the cells: one solver only
        shown, at, way = run.rest_position, float(run.t[-1]), "zeta at the end of the simulation"
    allowance = 10.0 * run.zeta_allowance + 2.0 * run.error_estimate
    return Rest.of((predicted, shown), at, way, allowance, float(np.abs(run.z).max()))


def _decay_time(scheme: UpwindScheme) -> float:
    """Time in which the waves of the scheme fall by ``1e13``: the slowest mode, or enough echoes.

    The motion is an average of the shift register with Poisson weights of mean ``s t``: after ``M`` round trips and ten
    standard deviations all of the weight is on echoes ``a^M``.
    """
    N, rate = scheme.cells, -RodPlant(scheme.rod).log_reflection
    trips = 1.0 + (_LEFT / rate if rate > 0.0 else math.inf)
    slow = -math.expm1(-rate / (2.0 * N)) if math.isfinite(rate) else 1.0
    mean = 2.0 * N * trips + 10.0 * math.sqrt(2.0 * N * trips) + 100.0
    return max(mean, _LEFT / slow if slow > 0.0 else math.inf) / scheme.rate
