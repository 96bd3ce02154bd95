"""The scheme with its contacts, event to event, for very many cells."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import InputError
from lure.scenario import Scenario
from lure.structured.contact import FLOOR, Crossing, Undecided, halved, next_contact
from lure.structured.flight import FreeFlight, free_flight
from lure.structured.poisson import Mean, parted
from lure.structured.press import Press, fewest_cells
from lure.structured.ring import Ring
from lure.upwind import UpwindScheme

Array: TypeAlias = NDArray[np.float64]

_MOST = 20_000


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class StructuredMotion:
    """A motion of the scheme with contact, known at samples; OBSERVED evidence.

    Attributes
    ----------
    t : ndarray
        (k,) samples [s].
    z, wave : ndarray
        (k,) contact coordinate [m] and last forward wave ``y_N`` [m/s].
    contacts : tuple of (float, float)
        Beginning and end of every contact [s]; the last may end with the run.
    state : ndarray
        (2N+1,) at the end, in the ordering of the scheme.
    """

    t: Array
    z: Array
    wave: Array
    contacts: tuple[tuple[float, float], ...]
    state: Array


def structured_motion(
    scheme: UpwindScheme, start: Scenario | ArrayLike, until: float, *, samples: int = 2001
) -> StructuredMotion:
    """Motion of the scheme against its obstacle, without loads: jumps from event to event.

    Between contacts a jump of any length by :class:`FreeFlight`; in contact the Poisson average of a shift register
    with the law in it, a round trip or less at a time.  Beginning and end of contact are located as by
    :func:`first_contact`.  There is no time step and no error but rounding, which the events amplify as the motion
    itself does.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme: linear law (``m = 1``), ``k >= 0``, and a few more cells than ``d c_n L/c``.
    start : Scenario or array_like
        Initial data without loads, or a state in the ordering of the scheme.
    until : float
        End [s].
    samples : int
        Number of instants kept, evenly spaced from 0 to ``until``.

    Raises
    ------
    InputError
        One of these does not hold, there are more than 20 000 flights and stretches of contact, or contact can neither
        be excluded nor found.

    Notes
    -----
    Memory does not depend on the time.  An event costs ``O(N log N)``.

    Examples
    --------
    >>> from lure import Rod, builtin_system, upwind
    >>> rod = Rod(
    ...     youngs_modulus=288e6, density=8, length=1, area=0.25e-4, damping=0.3, compliance=3e-10, gap=1e-5
    ... )
    >>> run = structured_motion(upwind(rod, 2000), builtin_system("paper-rod").scenario, 1e-3)
    >>> len(run.contacts), bool(run.z[-1] < 0)
    (1, True)
    """
    _check(scheme, until, samples)
    ring = free_flight(scheme, start).ring
    times = np.linspace(0.0, until, samples)
    run = _Run(rate=Fraction(scheme.rate), times=times, stop=Fraction(scheme.rate) * Fraction(until))
    contact = ring.gap > 0.0
    for _ in range(_MOST):
        if run.clock >= run.stop:
            break
        ring, contact = run.pressed(ring) if contact else run.flown(ring)
    else:
        reached = float(run.clock / run.rate)
        raise InputError(
            f"until is {until:g} s, and {_MOST} flights and stretches of contact end at {reached:.6g} s; give an "
            "earlier end"
        )
    state = np.append(ring.waves, ring.gap / scheme.rate)[scheme.permutation]
    return StructuredMotion(
        t=times, z=run.gaps / scheme.rate, wave=run.waves, contacts=run.closed(), state=np.asarray(state)
    )


def _check(scheme: UpwindScheme, until: float, samples: int) -> None:
    rod = scheme.rod
    if not 0.0 < until < math.inf:
        raise InputError(f"until is {until!r}; give a positive number of seconds")
    if isinstance(samples, bool) or not isinstance(samples, int) or samples < 2:
        raise InputError(f"samples is {samples!r}; give a whole number of at least 2")
    if rod.exponent != 1.0:
        raise InputError(f"rod.exponent is {rod.exponent:g}; structured_motion takes the linear law, give 1")
    if rod.damping < 0.0:
        raise InputError(f"rod.damping is {rod.damping:g}; structured_motion takes no negative one")
    least = fewest_cells(rod.mobility * rod.law.stiffness * rod.travel_time)
    if scheme.cells < least:
        raise InputError(f"the contact is too stiff for {scheme.cells} cells; give at least {least}")


@dataclass(kw_only=True, slots=True, eq=False)
class _Run:
    """Clock, samples and contacts of a run, in units of ``1/s``; the clock is exact."""

    rate: Fraction
    times: Array
    stop: Fraction
    clock: Fraction = Fraction(0)
    filled: int = 0
    gaps: Array = field(init=False)
    waves: Array = field(init=False)
    stretches: list[tuple[Fraction, Fraction]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.gaps, self.waves = np.empty(self.times.size), np.empty(self.times.size)

    def flown(self, ring: Ring) -> tuple[Ring, bool]:
        """Free flight up to the next contact or the end."""
        flight = FreeFlight(ring=ring)
        touch = next_contact(flight, float(self.stop - self.clock))
        end = self.stop if touch is None else self.clock + touch.passed + Fraction(touch.tau)
        if touch is None or end >= self.stop:
            span = self.stop - self.clock
            self._sample(flight, self.stop)
            return _after(flight, _mean(span)), False
        self._sample(flight, end)
        return replace(_after(touch.flight, parted(touch.tau)), gap=0.0), True

    def pressed(self, ring: Ring) -> tuple[Ring, bool]:
        """Contact up to its end, the end of a round trip or of the run."""
        begin, length = self.clock, 2 * ring.scheme.cells
        while True:
            press = Press(ring=ring, length=length)
            search = Crossing(values=-press.streams[2], floor=FLOOR * press.rounding)
            try:
                found = search.first(0.0, float(length))
            except Undecided:
                length = halved(length)
            else:
                break
        span = Fraction(length) if found is None else Fraction(found)
        released = found is not None and begin + span < self.stop
        span = min(span, self.stop - begin)
        after = press.after(_mean(span))
        self._sample(press, begin + span)
        if self.stretches and self.stretches[-1][1] == begin:
            begin = self.stretches.pop()[0]
        self.stretches.append((begin, self.clock))
        return (replace(after, gap=0.0), False) if released else (after, True)

    def closed(self) -> tuple[tuple[float, float], ...]:
        """The contacts in seconds."""
        return tuple((float(begin / self.rate), float(end / self.rate)) for begin, end in self.stretches)

    def _sample(self, piece: FreeFlight | Press, end: Fraction) -> None:
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
