"""The exact motion of the rod held against what was shown of the rod.

Where it comes to rest, and where its scheme does, is predicted from momentum and shown by the motion.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from lure.analysis.rod.confirmation.follow import Followed, closed_form_error, follow, momentum_allowance, ringing
from lure.analysis.rod.confirmation.follow import trips_to_settle as settling_trips
from lure.analysis.rod.confirmation.functionals import (
    Track,
    lyapunov_theta,
    rod_energy,
    rod_lyapunov,
    rod_zeta,
    track_z,
)
from lure.analysis.rod.confirmation.result import AGREEMENT, Curves, Kind, Quantity, Rest, Side
from lure.analysis.rod.simulation import Trajectory
from lure.arrays import Reals as Array
from lure.errors import InputError
from lure.expressions import Expression
from lure.rod.discretisation import UpwindScheme
from lure.rod.motion import Window
from lure.rod.motion.fields import of_record
from lure.rod.motion.pieces import basis, distinct, fitted, right_ends, supremum
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario
from lure.rod.scheme import structured_motion
from lure.rod.transfer import RodPlant

_LEFT = math.log(1e13)
_DEGREE = 16
_SAMPLES = 2001
_ROUNDING, _TRUSTED = 1e-12, 1e-7


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

    ``rod``, ``scenario``: ``k > 0``, without loads; ``largest``: largest ``|z|`` along the motion [m].
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

    ``scheme``: ``k > 0``; ``scenario``: its initial data, no loads; ``run``: the simulation.
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


def rod_side(rod: Rod, scenario: Scenario, until: float, kind: Kind) -> Side:
    """Follow the rod and collect what is claimed of it.

    ``until``: end of the motion that is shown [s]; ``kind``: what is to be confirmed.

    Raises
    ------
    InputError, AssumptionError
        The exact solver refuses.
    """
    followed = follow(rod, scenario, until)
    track = Track(rod=rod, scenario=scenario, windows=followed.windows)
    t = np.linspace(0.0, min(until, track.reached), _SAMPLES)
    highest = supremum(np.concatenate([window.z for window in track.windows]))[1]
    free, decays = kind != "load", kind == "decay"
    with np.errstate(over="ignore", invalid="ignore"):
        curves = Curves(
            t=t,
            z=track_z(track, t),
            zeta=rod_zeta(track, t) if decays else None,
            energy=rod_energy(track, t) if free else None,
            lyapunov=rod_lyapunov(track, t) if decays else None,
        )
        ends = np.concatenate((t, 2.0 * rod.travel_time * np.arange(1, len(track.windows) + free)))
        ends = np.unique(ends[ends <= track.reached])
        energy = _energy(track, ends, kind) if free else None
    side = Side(
        model="rod",
        until=track.reached,
        contacts=_contacts(followed.windows),
        highest=highest,
        energy_residual=balance(track),
        energy=energy,
        lyapunov=None,
        lyapunov_theta=None,
        zeta=None,
        momentum=None,
        rest=None,
        open_end=followed.shortened,
        curves=curves,
    )
    return _decaying(side, track, followed, ends) if decays else side


def _decaying(side: Side, track: Track, followed: Followed, t: Array) -> Side:
    """With what falls for ``k > 0``, and the resting place."""
    rod = track.rod
    zeta, functional = rod_zeta(track, t), rod_lyapunov(track, t)
    size = float(np.abs(zeta).max())
    largest = max(float(np.abs(track_z(track, t)).max()), size)
    allowed = momentum_allowance(rod, followed.windows)
    rest = rest_of_rod(rod, track.scenario, followed, largest)
    reason = side.open_end
    if rest is None and reason is None:
        reason = (
            f"contact is going on or can still come after {len(followed.windows)} round trips, at t = "
            f"{track.reached:.4g} s"
        )
    top = float(functional.max())
    return replace(
        side,
        zeta=_falling(zeta, size, allowed),
        lyapunov=_falling(functional, top, 1e-11 * top + 4.0 * size * allowed / rod.residue_at_zero),
        lyapunov_theta=lyapunov_theta(rod),
        momentum=_momentum(track) / largest if largest > 0.0 else 0.0,
        rest=rest,
        open_end=reason,
    )


def _falling(values: Array, scale: float, allowed: float) -> Quantity:
    return Quantity.of(values, max(0.0, float(np.diff(values).max(initial=0.0))), allowed, scale)


def _energy(track: Track, t: Array, kind: Kind) -> Quantity:
    """Energy: never up for ``k > 0``, never down for ``k < 0``, the same for ``k = 0``."""
    values, rod = rod_energy(track, t), track.rod
    top = float(values.max())
    unit = top if top > 0.0 else 1.0
    wave = max(float(np.abs(window.wave).sum(axis=1).max()) for window in track.windows)
    error = math.fsum(window.error for window in track.windows)
    allowed = _ROUNDING * (1.0 + len(track.windows) ** 0.5) + 8.0 * rod.impedance * wave * error / unit
    if kind == "growth":
        before = np.maximum(np.abs(values[:-1]), 1e-300)
        against = max(0.0, float((-np.diff(values) / before).max(initial=0.0)))
    elif kind == "undamped":
        against = float(np.abs(values - values[0]).max()) / unit
    else:
        against = max(0.0, float(np.diff(values).max(initial=0.0)) / unit)
    return Quantity(start=float(values[0]), end=float(values[-1]), against=against, allowance=allowed, scale=top)


def balance(track: Track) -> float:
    """Largest error of the balance of energy at ``x = L``, relative to the largest energy that passes there.

    ``Z/4 int (W^2 - V^2) dt = A [P(z)]``: what the waves bring and do not take away is in the obstacle.  The rest of
    the balance, ``E' = -k v(t, 0)^2 + g v(t, 0) + int f v dx``, holds identically for waves that are shifted.

    ``track``: the motion, with or without loads.
    """
    rod, start = track.rod, 2.0 * np.arange(len(track.windows), dtype=np.float64)
    stop = np.append(start[1:], start[-1] + track.record.stop)
    brought, taken = (of_record(track.record, start, stop, returned=returned) for returned in (False, True))
    share = 0.25 * rod.impedance * rod.travel_time
    z = np.array([track.scenario.contact_coordinate(rod), *(float(right_ends(w.z)[-1]) for w in track.windows)])
    stored = rod.area * rod.nonlinearity.primitive(z)
    miss = np.cumsum(share * (brought - taken)) - (stored[1:] - stored[0])
    scale = max(share * float(brought.max()), float(stored.max()))
    return float(np.abs(miss).max()) / scale if scale > 0.0 else 0.0


def _momentum(track: Track) -> float:
    """Largest ``|zeta - zeta(0) + impulse/k|`` at the ends of the round trips [m]."""
    rod = track.rod
    ends = 2.0 * rod.travel_time * np.arange(len(track.windows) + 1)
    zeta = rod_zeta(track, np.minimum(ends, track.reached))
    impulses, passed = [0.0], 0.0
    for window in track.windows:
        passed += math.fsum(impact.impulse for impact in window.impacts)
        going = window.end.impact
        impulses.append(passed + (0.0 if going is None else going.impulse))
    return float(np.abs(zeta - zeta[0] + np.array(impulses) / rod.damping).max())


def _contacts(windows: tuple[Window, ...]) -> int:
    return sum(len(window.impacts) for window in windows) + (windows[-1].end.impact is not None)


def contradictions_of_rod(side: Side, kind: Kind) -> tuple[str, ...]:
    """Sentences for the ways in which the motion of the rod contradicts what was shown of it, beyond rounding.

    ``kind``: what was shown.
    """
    energy_rule = {"growth": "falls", "undamped": "changes"}.get(kind, "rises")
    found = []
    for name, quantity, verb in (
        ("energy", side.energy, energy_rule),
        ("Popov-Lyapunov functional", side.lyapunov, "rises"),
        ("deflated coordinate zeta", side.zeta, "rises"),
    ):
        if quantity is not None and not quantity.holds:
            found.append(
                f"the {name} of the rod {verb} by {quantity.against:.3g} of itself between two samples, where it must "
                f"not; rounding explains {quantity.allowance:.1g}"
            )
    for name, quantity in (("energy", side.energy), ("Popov-Lyapunov functional", side.lyapunov)):
        if quantity is not None and quantity.end < -quantity.allowance * quantity.scale:
            found.append(f"the {name} of the rod falls to {quantity.end:.3g}, and none of its terms can be negative")
    if side.momentum is not None and side.zeta is not None and not side.momentum <= max(1e-9, side.zeta.allowance):
        found.append(f"zeta of the rod changes by {side.momentum:.3g} of itself otherwise than by the impulse over k")
    if not side.energy_residual <= max(_TRUSTED, 0.0 if side.energy is None else side.energy.allowance):
        found.append(
            f"the energy balance of the rod is off by {side.energy_residual:.2g}: the motion cannot be trusted"
        )
    return (*found, *contradictions_of_rest(side))


def contradictions_of_rest(side: Side) -> tuple[str, ...]:
    """Sentences for a resting place that is inside the obstacle or is not the one that was predicted."""
    rest, found = side.rest, []
    if rest is None:
        return ()
    if not rest.difference <= max(AGREEMENT, rest.allowance):
        found.append(
            f"the {side.model} was predicted to rest at z = {rest.predicted:.12g} m and goes to {rest.shown:.12g} m; "
            f"rounding explains {rest.allowance:.1g} of {rest.scale:.3g} m"
        )
    if not rest.shown <= rest.scale * max(AGREEMENT, rest.allowance):
        found.append(f"the {side.model} comes to rest at z = {rest.shown:.6g} m, inside the obstacle")
    return tuple(found)
