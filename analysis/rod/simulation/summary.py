"""From the record of a run to what is said of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.energy import deflated_coordinate, discrete_energy, energy_theta, lyapunov_function, zeta_weights
from lure.analysis.rod.simulation.plan import Plan
from lure.analysis.rod.simulation.record import Record
from lure.analysis.rod.simulation.rest import highest_ever
from lure.analysis.rod.simulation.trajectory import Trajectory

Array = NDArray[np.float64]

_ROUNDING, _SMALLEST = 1e-12, 1e-250


def summary(record: Record, plan: Plan, again: Array, ended: str | None) -> Trajectory:
    """The trajectory of a finished record.

    Parameters
    ----------
    record : Record
        The run.
    plan : Plan
        Its steps.
    again : ndarray
        (times,) ``z`` of the second run [m].
    ended : str or None
        Why it stopped early.
    """
    sampled, framed = np.isin(record.times, record.t), np.isin(record.times, record.t_frames)
    scheme, rod, loads = record.scheme, record.scheme.rod, record.loads
    k, exact = rod.damping, rod.law.exponent == 1.0 and plan.longest_contact > 0.0
    share = _ROUNDING if exact or not record.contacts else max(_ROUNDING, 1e2 * plan.tolerance)
    t, states = record.times[sampled], record.states[sampled]
    z = states[:, -1].copy()
    energy = discrete_energy(scheme, states)
    zeta = lyapunov = theta = bound = rest = None
    zeta_allowance = lyapunov_allowance = 0.0
    if k != 0:
        zeta = deflated_coordinate(scheme, states)
        zeta_allowance = share * float((np.abs(states) @ np.abs(zeta_weights(scheme))).max()) + _SMALLEST
    if k > 0 and loads.free and zeta is not None:
        rest = float(deflated_coordinate(scheme, _last_state(record)))
    start = float(energy[0])
    # the Lyapunov function holds squares of the ratio of k and Z: outside these sizes they leave the doubles
    if rest is not None and zeta is not None and _tame(k / rod.impedance, 100) and _tame(start, 250):
        theta = energy_theta(scheme)
        lyapunov = lyapunov_function(scheme, states, theta)
        residue = rod.residue_at_zero
        spread = 2.0 * float(np.abs(zeta).max()) + zeta_allowance
        lyapunov_allowance = share * float(lyapunov.max()) + spread * zeta_allowance / residue
        start = float(lyapunov[0])
        weights = float(np.linalg.norm(zeta_weights(scheme)[:-1]))
        bound = np.sqrt(residue * start) + weights * np.sqrt(2.0 * scheme.rate * rod.mobility * start / theta)
    final = rest is not None and not _touching(record) and highest_ever(record.ring, _scaled(record)) < 0.0
    r1, r2 = _waves(record, framed)
    return Trajectory(
        scheme=scheme,
        cells=scheme.cells,
        form=scheme.form,
        damping=k,
        loaded=not loads.free,
        t=_fixed(t),
        z=_fixed(z),
        u_end=_fixed(z + rod.gap),
        p=_fixed(rod.law(z)),
        force=_fixed(np.broadcast_to(loads.force_at(t), t.shape)),
        energy=_fixed(energy),
        zeta=None if zeta is None else _fixed(zeta),
        lyapunov=None if lyapunov is None else _fixed(lyapunov),
        lyapunov_theta=theta,
        contacts=tuple(record.contacts),
        max_gap_coordinate=record.peak.value() / record.ring.rate,
        energy_residual=record.residual / record.scale if record.scale != 0.0 else 0.0,
        energy_increase=_rise(energy) if k >= 0 and loads.free else None,
        zeta_increase=_rise(zeta) if k > 0 and loads.free and zeta is not None else None,
        lyapunov_increase=None if lyapunov is None else _rise(lyapunov),
        energy_allowance=share * float(energy.max()) + _SMALLEST,
        zeta_allowance=zeta_allowance,
        lyapunov_allowance=lyapunov_allowance,
        bound=None if bound is None else float(bound),
        rest_position=rest,
        rest_limit=None if rest is None else min(0.0, rest),
        rest_is_final=final,
        event_resolution=record.resolution,
        error_estimate=_largest(np.abs(again - record.states[:, -1])),
        method=_method(record, plan),
        ended_early=ended,
        frames_t=_fixed(record.times[framed]),
        frames_x=_fixed(rod.length * np.arange(scheme.cells + 1) / scheme.cells if framed.any() else np.empty(0)),
        frames_r1=_fixed(r1),
        frames_r2=_fixed(r2),
        frames_v=_fixed(0.5 * (r1 + r2)),
    )


def _waves(record: Record, framed: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Both waves (frames, N+1) along the rod, with the boundary conditions at the ends."""
    N, rod = record.scheme.cells, record.scheme.rod
    states, t = record.states[framed], record.times[framed]
    if not t.size:
        return np.empty((0, 0)), np.empty((0, 0))
    sent = record.ring.echo * states[:, -2] + record.ring.force_gain * record.loads.force_at(t)
    back = states[:, N - 1] - 2.0 * rod.mobility * rod.law(states[:, -1])
    forward = np.column_stack((sent, states[:, :N]))
    return forward, np.column_stack((states[:, -2 : N - 1 : -1], back))


def _last_state(record: Record) -> Array:
    state = _scaled(record)
    state[-1] /= record.ring.rate
    return state


def _scaled(record: Record) -> Array:
    assert record.last is not None
    return record.last.end.copy()


def _touching(record: Record) -> bool:
    last = record.last
    return last is not None and last.contact and last.event is None


def _largest(values: Array) -> float:
    """Largest of the numbers that are known; nan if none is."""
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else float("nan")


def _tame(size: float, decades: int) -> bool:
    return 10.0**-decades < size < 10.0**decades


def _rise(values: Array) -> float:
    rise = float(np.diff(values).max())
    return 0.0 if rise <= 0.0 else rise  # a nan is not a fall


def _fixed(values: Array) -> Array:
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array


def _method(record: Record, plan: Plan) -> str:
    exact = plan.longest_contact > 0.0
    law = "in contact with the linear law, too" if exact else "in contact by Radau collocation of the stress, order 15"
    shallow = f"; only a touch shallower than {record.floor:.1g} m counts as none" if record.floor > 0.0 else ""
    loads = (
        " Loads are polynomials on each step, checked at points one cell-crossing time apart; what they do between two "
        "checks is not seen."
    )
    return (
        f"Exact in time in free flight (Poisson average of a shift register, {record.segments} steps), {law}. No "
        "contact or release is missed: on each piece of each step z is bounded through its chord and a bound on z'' "
        f"over the whole piece, and pieces whose sign that leaves open are cut until it does not{shallow}."
        f"{'' if record.loads.free else loads}"
    )
