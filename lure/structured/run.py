"""From event to event: clock, samples and contacts of a run."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from lure.structured.contact import FLOOR, Crossing, Undecided, halved, next_contact
from lure.structured.flight import FreeFlight, free_flight
from lure.structured.force import Force
from lure.structured.poisson import Mean, parted
from lure.structured.ring import Ring
from lure.structured.stretch import Stretch, longest

Array: TypeAlias = NDArray[np.float64]

_EARLY = 8


@dataclass(kw_only=True, slots=True, eq=False)
class Run:
    """Clock, samples and contacts of a run, in units of ``1/s``; the clock is exact.

    Attributes
    ----------
    rate : Fraction
        ``s`` [1/s].
    times : ndarray
        Samples [s].
    stop : Fraction
        The end.
    force : Force or None
        What acts on the end ``x = 0``.
    contact : bool
        Whether the end touches the obstacle.
    clock : Fraction
        How far the motion is known.
    filled : int
        How many samples are.
    gaps, waves : ndarray
        ``s z`` and ``y_N`` at the samples [m/s].
    stretches : list of (Fraction, Fraction)
        The contacts.
    """

    rate: Fraction
    times: Array
    stop: Fraction
    force: Force | None
    contact: bool
    clock: Fraction = Fraction(0)
    filled: int = 0
    gaps: Array = field(init=False)
    waves: Array = field(init=False)
    stretches: list[tuple[Fraction, Fraction]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.gaps, self.waves = np.empty(self.times.size), np.empty(self.times.size)

    def moved(self, ring: Ring) -> Ring:
        """The ring at the next event, the end of a stretch or of the run."""
        begin, touched = self.clock, self.contact
        free = not touched and self.force is None
        ring = self._flown(ring) if free else self._stretched(ring)
        if touched:
            if self.stretches and self.stretches[-1][1] == begin:
                begin = self.stretches.pop()[0]
            self.stretches.append((begin, self.clock))
        if self.contact is touched:
            return ring
        return replace(ring, gap=max(ring.gap, 0.0) if self.contact else min(ring.gap, 0.0))  # rounding has no say

    def closed(self) -> tuple[tuple[float, float], ...]:
        """The contacts in seconds."""
        return tuple((float(begin / self.rate), float(end / self.rate)) for begin, end in self.stretches)

    def _flown(self, ring: Ring) -> Ring:
        """Flight without a force up to the next contact or the end, in one jump."""
        flight = FreeFlight(ring=ring)
        touch = next_contact(flight, float(self.stop - self.clock))
        end = self.stop if touch is None else self.clock + touch.passed + Fraction(touch.tau)
        if touch is None or end >= self.stop:
            span = self.stop - self.clock
            self._sample(flight, self.stop)
            return _after(flight, _mean(span))
        self._sample(flight, end)
        self.contact = True
        return _after(touch.flight, parted(touch.tau))

    def _stretched(self, ring: Ring) -> Ring:
        """A stretch of contact, or of flight under the force."""
        begin, end, scheme, contact = self.clock, self.stop, ring.scheme, self.contact
        kappa = scheme.rod.mobility * scheme.rod.law.stiffness / scheme.rate if contact else 0.0
        length = longest(scheme.cells, kappa)
        if self.force is not None:
            end = min(end, self.force.end(begin) or end)
            length = min(length, self.force.reach(begin))
        left = float(end - begin)
        while True:
            entering = None if self.force is None else self.force.entering(begin, Stretch.columns_of(length))
            stretch = Stretch(ring=ring, length=length, kappa=kappa, entering=entering)
            gaps = stretch.streams[2]
            search = Crossing(values=-gaps if contact else gaps, floor=FLOOR * stretch.rounding)
            try:
                found = search.first(0.0, min(float(length), left))
            except Undecided:
                length = halved(length)
                continue
            if found is None or length <= _EARLY * max(1.0, found):
                break
            length = math.ceil(2.0 * max(0.5, found))  # seen again where rounding is that of a shorter stretch
        span = min(Fraction(length), end - begin)
        if found is not None and found < span:
            span, self.contact = Fraction(found), not contact
        after = stretch.after(_mean(span))
        self._sample(stretch, begin + span)
        return after

    def _sample(self, piece: FreeFlight | Stretch, end: Fraction) -> None:
        """Fill the samples from the clock to ``end``, and set the clock."""
        while self.filled < self.times.size:
            place = self.rate * Fraction(float(self.times[self.filled]))
            if place > end:
                break
            self.gaps[self.filled], self.waves[self.filled] = piece.end_at(_mean(place - self.clock))
            self.filled += 1
        self.clock = end


def _mean(span: Fraction) -> Mean:
    whole = round(span)
    return Mean(whole=whole, rest=float(span - whole))


def _after(flight: FreeFlight, mean: Mean) -> Ring:
    """The ring at the end of a flight."""
    scheme = flight.ring.scheme
    return free_flight(scheme, flight.jumped(mean)).ring
