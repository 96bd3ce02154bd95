"""The account of a run, samples, contacts, peaks and energy, and what is said of it at the end."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.energy import (
    deflated_coordinate,
    discrete_energy,
    energy_balance,
    energy_theta,
    lyapunov_function,
    zeta_weights,
)
from lure.analysis.rod.simulation.trajectory import Trajectory
from lure.arrays import Reals as Array
from lure.rod.datasets import Contact
from lure.rod.discretisation import UpwindScheme
from lure.rod.scheme.flow import Segment
from lure.rod.scheme.loads import Loads
from lure.rod.scheme.register import RegisterState, ShiftRegister
from lure.rod.scheme.steps import Plan, states_at

_BATCH = 2**21  # numbers held before the energy account is brought up to date
_ROUNDING, _SMALLEST = 1e-12, 1e-250


@dataclass(kw_only=True, slots=True)
class Peak:
    """The largest coordinate over all instants; segments that cannot hold it are let go."""

    best: float
    rivals: list[tuple[float, Segment]] = field(default_factory=list)

    def add(self, segment: Segment) -> None:
        """Take a segment into account."""
        reached, bound = segment.bounds()
        if not bound <= self.best:
            self.best = max(self.best, reached)
            self.rivals = [rival for rival in (*self.rivals, (bound, segment)) if rival[0] > self.best]

    def value(self) -> float:
        """The peak, to rounding."""
        for bound, segment in sorted(self.rivals, key=lambda rival: -rival[0]):
            if bound > self.best:
                self.best = segment.peak(self.best)
        self.rivals = []
        return self.best


@dataclass(kw_only=True, slots=True)
class Account:
    """Account of a run on a scheme in the ordering (39)."""

    scheme: UpwindScheme  # what moves, with what holds it and acts on it
    register: ShiftRegister
    loads: Loads
    t: Array  # samples asked for [s]
    t_frames: Array  # frames asked for [s]
    times: Array  # all of them, ascending, up to an early end
    states: Array  # (times, 2N+1) the states there, in SI units
    peak: Peak
    energy: float
    filled: int = 0
    stop: float = 0.0
    segments: int = 0
    resolution: float = 0.0
    closeness: float = 0.0
    floor: float = 0.0
    residual: float = 0.0
    scale: float = 0.0
    lost: float = 0.0
    given: float = 0.0
    last: Segment | None = None
    contacts: list[Contact] = field(default_factory=list)
    _contact: Peak | None = None
    _start: float = 0.0
    _before: float = 0.0
    _impulses: list[float] = field(default_factory=list)
    _held: list[tuple[Array, Array, Array, Array, int]] = field(default_factory=list)
    _size: int = 0

    def add(self, segment: Segment) -> None:
        """Take the next segment into account."""
        stop = segment.stop(self.register.rate)
        self._sample(segment, stop)
        self.peak.add(segment)
        if segment.contact:
            if self._contact is None:
                self._contact = self._open()
            self._contact.add(segment)
        self._hold(segment)
        if segment.event is not None:
            known = segment.event.resolution / self.register.rate
            # two events may be one if they are closer than both are known
            self.closeness, self._before = self._before + known, known
            self.resolution = max(self.resolution, known)
            if segment.contact:
                self._close(stop, still=False)
        self.floor = max(self.floor, segment.floor / self.register.rate)
        self.stop, self.last, self.segments = stop, segment, self.segments + 1

    def finish(self, until: float, *, most: int) -> str | None:
        """Close what is open; a sentence if the run has not reached ``until`` [s] in ``most`` steps."""
        self._settle()
        if self._contact is not None:
            self._close(self.stop, still=True)
        self.contacts = [
            replace(contact, impulse=impulse) for contact, impulse in zip(self.contacts, self._impulses, strict=True)
        ]
        if self.stop >= until * (1.0 - 1e-12):
            self._sample(self.last, np.inf) if self.last is not None else None
            return None
        self.times, self.states = self.times[: self.filled], self.states[: self.filled]
        if self.segments >= most:
            return f"after {most} steps the run is at {self.stop:.6g} s only: loads or contacts change too fast for it"
        return f"the motion has grown beyond 1e30 times its start at {self.stop:.6g} s"

    def _sample(self, segment: Segment, stop: float) -> None:
        first, self.filled = self.filled, max(self.filled, int(np.searchsorted(self.times, stop, side="right")))
        if self.filled > first:
            tau = segment.tau(self.times[first : self.filled], self.register.rate)
            self.states[first : self.filled] = self._si(states_at(self.register, segment.step, segment.rows(tau)))

    def _open(self) -> Peak:
        """Begin a contact, or go on with the last one if that ended just before, closer than events are known."""
        if self.contacts and self.stop - self.contacts[-1].end <= self.closeness:
            before = self.contacts.pop()
            self._start = before.start
            return Peak(best=before.peak_penetration * self.register.rate)
        self._start = self.stop
        self._impulses.append(0.0)
        return Peak(best=0.0)

    def _close(self, stop: float, *, still: bool) -> None:
        assert self._contact is not None
        depth = self._contact.value() / self.register.rate
        stress = float(self.scheme.rod.nonlinearity(depth))
        self.contacts.append(
            Contact(start=self._start, end=stop, peak_penetration=depth, peak_stress=stress, closed=not still)
        )
        self._contact = None

    def _hold(self, segment: Segment) -> None:
        if segment.length == 0.0:
            return
        points, weights, rows = segment.gauss()
        states = self._si(states_at(self.register, segment.step, rows))
        t = (segment.clock[0] + (segment.clock[1] + points)) / self.register.rate
        contact = len(self._impulses) - 1 if segment.contact else -1
        self._held.append((t, weights / self.register.rate, states, self._si(segment.end[None, :].copy()), contact))
        self._size += states.size
        if self._size > _BATCH:
            self._settle()

    def _settle(self) -> None:
        """Bring the energy account and the impulses up to date."""
        if not self._held:
            return
        t, weights = (np.concatenate([held[i] for held in self._held]) for i in (0, 1))
        states, ends = (np.concatenate([held[i] for held in self._held]) for i in (2, 3))
        first = np.cumsum([0, *(held[0].size for held in self._held[:-1])])
        body = None if self.loads.body_force is None else self.loads.body_at(t)
        lost, given = energy_balance(self.scheme, states, self.loads.force_at(t), body)
        rod = self.scheme.rod
        push = np.add.reduceat(weights * rod.area * rod.nonlinearity(states[:, -1]), first)
        for held, amount in zip(self._held, push, strict=True):
            if held[4] >= 0:
                self._impulses[held[4]] += float(amount)
        sums = self.lost + np.cumsum(np.add.reduceat(weights * lost, first))
        gains = self.given + np.cumsum(np.add.reduceat(weights * given, first))
        energies = discrete_energy(self.scheme, ends)
        with np.errstate(invalid="ignore"):
            self.residual = _larger(self.residual, energies - self.energy + sums - gains)
        self.scale = _larger(max(self.scale, self.energy), np.concatenate((energies, sums, gains)))
        self.lost, self.given = float(sums[-1]), float(gains[-1])
        self._held, self._size = [], 0

    def _si(self, states: Array) -> Array:
        states[:, -1] /= self.register.rate
        return states


def _larger(value: float, entries: Array) -> float:
    """The largest size in sight; a nan in sight stays in sight."""
    largest = float(np.abs(entries).max())
    return value if largest <= value else largest


def summary(account: Account, plan: Plan, again: Array, ended: str | None) -> Trajectory:
    """The trajectory of a finished account.

    ``again``: (times,) ``z`` of the second run [m]; ``ended``: why it stopped early.
    """
    sampled, framed = np.isin(account.times, account.t), np.isin(account.times, account.t_frames)
    scheme, rod, loads = account.scheme, account.scheme.rod, account.loads
    k, exact = rod.damping, rod.nonlinearity.exponent == 1.0 and plan.longest_contact > 0.0
    share = _ROUNDING if exact or not account.contacts else max(_ROUNDING, 1e2 * plan.tolerance)
    t, states = account.times[sampled], account.states[sampled]
    z = states[:, -1].copy()
    energy = discrete_energy(scheme, states)
    zeta = lyapunov = theta = bound = rest = None
    zeta_allowance = lyapunov_allowance = 0.0
    if k != 0:
        zeta = deflated_coordinate(scheme, states)
        zeta_allowance = share * float((np.abs(states) @ np.abs(zeta_weights(scheme))).max()) + _SMALLEST
    if k > 0 and loads.free and zeta is not None:
        rest = float(deflated_coordinate(scheme, _end(account).state))
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
    final = rest is not None and not _touching(account) and _end(account).largest_gap() < 0.0
    r1, r2 = _waves(account, framed)
    return Trajectory(
        scheme=scheme,
        cells=scheme.cells,
        form=scheme.form,
        damping=k,
        loaded=not loads.free,
        t=_fixed(t),
        z=_fixed(z),
        u_end=_fixed(z + rod.gap),
        p=_fixed(rod.nonlinearity(z)),
        force=_fixed(np.broadcast_to(loads.force_at(t), t.shape)),
        energy=_fixed(energy),
        zeta=None if zeta is None else _fixed(zeta),
        lyapunov=None if lyapunov is None else _fixed(lyapunov),
        lyapunov_theta=theta,
        contacts=tuple(account.contacts),
        max_gap_coordinate=account.peak.value() / account.register.rate,
        energy_residual=account.residual / account.scale if account.scale != 0.0 else 0.0,
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
        event_resolution=account.resolution,
        error_estimate=_largest(np.abs(again - account.states[:, -1])),
        method=_method(account, plan),
        ended_early=ended,
        frames_t=_fixed(account.times[framed]),
        frames_x=_fixed(rod.length * np.arange(scheme.cells + 1) / scheme.cells if framed.any() else np.empty(0)),
        frames_r1=_fixed(r1),
        frames_r2=_fixed(r2),
        frames_v=_fixed(0.5 * (r1 + r2)),
    )


def _waves(account: Account, framed: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Both waves (frames, N+1) along the rod, with the boundary conditions at the ends."""
    N, rod = account.scheme.cells, account.scheme.rod
    states, t = account.states[framed], account.times[framed]
    if not t.size:
        return np.empty((0, 0)), np.empty((0, 0))
    sent = account.register.echo * states[:, -2] + account.register.force_gain * account.loads.force_at(t)
    back = states[:, N - 1] - 2.0 * rod.mobility * rod.nonlinearity(states[:, -1])
    forward = np.column_stack((sent, states[:, :N]))
    return forward, np.column_stack((states[:, -2 : N - 1 : -1], back))


def _end(account: Account) -> RegisterState:
    assert account.last is not None
    end = account.last.end
    return RegisterState(register=account.register, waves=end[:-1], gap=float(end[-1]))


def _touching(account: Account) -> bool:
    last = account.last
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


def _method(account: Account, plan: Plan) -> str:
    exact = plan.longest_contact > 0.0
    nonlinearity = (
        "in contact with the linear contact law, too"
        if exact
        else "in contact by Radau collocation of the stress, order 15"
    )
    shallow = f"; only a touch shallower than {account.floor:.1g} m counts as none" if account.floor > 0.0 else ""
    loads = (
        " Loads are polynomials on each step, checked at points one cell-crossing time apart; what they do between two "
        "checks is not seen."
    )
    return (
        f"Exact in time in free flight (Poisson average of a shift register, {account.segments} steps), "
        f"{nonlinearity}. No contact or release is missed: on each piece of each step z is bounded through its chord "
        "and a bound on z'' over the whole piece, and pieces whose sign that leaves open are cut until it does "
        f"not{shallow}.{'' if account.loads.free else loads}"
    )
