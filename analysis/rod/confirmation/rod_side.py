"""The exact motion of the rod held against what was shown of the rod."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from lure.analysis.rod.confirmation.follow import Followed, follow, momentum_allowance
from lure.analysis.rod.confirmation.functionals import (
    Track,
    lyapunov_theta,
    rod_energy,
    rod_lyapunov,
    rod_zeta,
    track_z,
)
from lure.analysis.rod.confirmation.rest import rest_of_rod
from lure.analysis.rod.confirmation.result import AGREEMENT, Curves, Kind, Quantity, Side
from lure.arrays import Reals as Array
from lure.rod.motion import Window
from lure.rod.motion.fields import of_record
from lure.rod.motion.pieces import right_ends, supremum
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

_SAMPLES = 2001
_ROUNDING, _TRUSTED = 1e-12, 1e-7


def rod_side(rod: Rod, scenario: Scenario, until: float, kind: Kind) -> Side:
    """Follow the rod and collect what is claimed of it.

    Parameters
    ----------
    rod, scenario
        The rod, its loads and initial data.
    until : float
        End of the motion that is shown [s].
    kind : {"decay", "undamped", "growth", "load"}
        What is to be confirmed.

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

    Parameters
    ----------
    side : Side
        The motion.
    kind : {"decay", "undamped", "growth", "load"}
        What was shown.
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
