"""What is written down along a run: samples, contacts, peaks and the energy account."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.energy import discrete_energy, energy_balance
from lure.analysis.rod.simulation.loads import Loads
from lure.analysis.rod.simulation.ring import Ring
from lure.analysis.rod.simulation.segment import Segment
from lure.analysis.rod.simulation.steps import states_at
from lure.analysis.rod.simulation.trajectory import Contact
from lure.rod.upwind import UpwindScheme

Array = NDArray[np.float64]

_BATCH = 2**21  # numbers held before the energy account is brought up to date


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
class Record:
    """Account of a run on a scheme in the ordering (39).

    Attributes
    ----------
    scheme, ring, loads
        What moves.
    t, t_frames : ndarray
        Samples and frames asked for [s].
    times : ndarray
        All of them, ascending, up to an early end.
    states : ndarray
        (times, 2N+1) the states there, in SI units.
    """

    scheme: UpwindScheme
    ring: Ring
    loads: Loads
    t: Array
    t_frames: Array
    times: Array
    states: Array
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
        stop = segment.stop(self.ring.rate)
        self._sample(segment, stop)
        self.peak.add(segment)
        if segment.contact:
            if self._contact is None:
                self._contact = self._open()
            self._contact.add(segment)
        self._hold(segment)
        if segment.event is not None:
            known = segment.event.resolution / self.ring.rate
            # two events may be one if they are closer than both are known
            self.closeness, self._before = self._before + known, known
            self.resolution = max(self.resolution, known)
            if segment.contact:
                self._close(stop, still=False)
        self.floor = max(self.floor, segment.floor / self.ring.rate)
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
            tau = segment.tau(self.times[first : self.filled], self.ring.rate)
            self.states[first : self.filled] = self._si(states_at(self.ring, segment.step, segment.rows(tau)))

    def _open(self) -> Peak:
        """Begin a contact, or go on with the last one if that ended just before, closer than events are known."""
        if self.contacts and self.stop - self.contacts[-1].end <= self.closeness:
            before = self.contacts.pop()
            self._start = before.start
            return Peak(best=before.peak_penetration * self.ring.rate)
        self._start = self.stop
        self._impulses.append(0.0)
        return Peak(best=0.0)

    def _close(self, stop: float, *, still: bool) -> None:
        assert self._contact is not None
        depth = self._contact.value() / self.ring.rate
        seen_in_part = still or self._start == 0.0
        self.contacts.append(
            Contact(start=self._start, end=stop, peak_penetration=depth, impulse=0.0, open=seen_in_part)
        )
        self._contact = None

    def _hold(self, segment: Segment) -> None:
        if segment.length == 0.0:
            return
        points, weights, rows = segment.gauss()
        states = self._si(states_at(self.ring, segment.step, rows))
        t = (segment.clock[0] + (segment.clock[1] + points)) / self.ring.rate
        contact = len(self._impulses) - 1 if segment.contact else -1
        self._held.append((t, weights / self.ring.rate, states, self._si(segment.end[None, :].copy()), contact))
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
        push = np.add.reduceat(weights * rod.area * rod.law(states[:, -1]), first)
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
        states[:, -1] /= self.ring.rate
        return states


def _larger(value: float, entries: Array) -> float:
    """The largest size in sight; a nan in sight stays in sight."""
    largest = float(np.abs(entries).max())
    return value if largest <= value else largest
