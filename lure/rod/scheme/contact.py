"""Contact and force as stretches of the shift register, and the first contact of a free flight.

The motion in contact with a linear contact law is the Poisson average of the register as in free flight.  Its fastest
alternations grow by up to ``(2 + kappa)/(2 - kappa)`` a round trip, which the average takes away again and rounding
remembers: hence stretches of limited length, and cells enough for a small ``kappa``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lure.arrays import Reals as Array
from lure.errors import InputError
from lure.record import described, quantity
from lure.rod.scheme.crossing import FLOOR, Crossing, Undecided
from lure.rod.scheme.flight import FreeFlight
from lure.rod.scheme.poisson import Mean, poisson_columns, poisson_weights, window
from lure.rod.scheme.register import Inputs, RegisterState, Streams, shifted

_LARGEST_GAIN = 100.0
_MOST_TRIPS = 64
_MOST_COLUMNS = 2_000_000
_LONGEST = 64  # round trips looked at in one piece
_MOST = 1_000_000_000  # cell crossings looked at in all


def fewest_cells(stiffness: float) -> int:
    """The fewest cells with which contact loses at most two digits to its register.

    ``stiffness``: ``d c_n L/c = kappa N``.
    """
    cells = max(1, math.ceil(stiffness))
    while _log_gain(cells, stiffness / cells, 1) > math.log(_LARGEST_GAIN):
        cells += max(1, cells // 50)
    return cells


def longest(cells: int, kappa: float) -> int:
    """Cell crossings of the longest stretch that loses at most two digits, in whole round trips."""
    trips = max(1, min(_MOST_TRIPS, _MOST_COLUMNS // (2 * cells)))
    while trips > 1 and _log_gain(cells, kappa, trips) > math.log(_LARGEST_GAIN):
        trips //= 2
    return 2 * cells * trips


def _log_gain(cells: int, kappa: float, trips: int) -> float:
    """Growth of the fastest alternations over the window of some round trips, as a logarithm."""
    seen = poisson_columns(2.0 * cells * trips) / (2.0 * cells)
    return seen * math.log((2.0 + kappa) / (2.0 - kappa))


@described(frozen=True, kw_only=True, eq=False)
class EventFreeInterval:
    """A stretch of motion in contact with a linear contact law, or under a force: still a shift register."""

    start: RegisterState = quantity("The scheme and its state where the stretch begins")
    length: int = quantity("Cell crossings covered")
    kappa: float = quantity(
        "``d c_n/s`` in contact, how much of ``z`` the nonlinearity takes back per cell crossing; 0 in flight [-]"
    )
    entering: Array | None = quantity(
        "What a force adds to the first forward cell at each step [m/s], at least :func:`.poisson_columns` of the "
        "length",
        default=None,
    )

    @cached_property
    def rounding(self) -> float:
        """Largest average of ``|s z_n|`` over the stretch: what rounding of ``s z`` is relative to."""
        sizes = Crossing(values=np.abs(self.streams.gap), floor=0.0)
        return max(sizes.at(share * self.length / 8.0) for share in range(9))

    @cached_property
    def streams(self) -> Streams:
        """What leaves the waves (columns + N - 1,), and ``s z`` (columns,)."""
        state = np.append(self.start.waves, self.start.gap)[:, None]
        inflow = None if self.entering is None else self.entering[:, None]
        inputs = Inputs(kappa=self.kappa, inflow=inflow)
        return shifted(self.start.register, state, poisson_columns(self.length), inputs).single

    def after(self, mean: Mean) -> RegisterState:
        """What the register holds at the time ``mean`` from the beginning, in units of ``1/s``."""
        first, weights = poisson_weights(mean)
        waves = [self._averaged(stream[first:], weights) for stream in (self.streams.forward, self.streams.backward)]
        gap = float(weights @ self.streams.gap[first : first + weights.size])
        return RegisterState(register=self.start.register, waves=np.concatenate(waves), gap=gap)

    def end_at(self, mean: Mean) -> tuple[float, float]:
        """``s z`` and ``y_N`` [m/s] at the time ``mean`` from the beginning."""
        first, weights = poisson_weights(mean)
        inside = slice(first, first + weights.size)
        return float(weights @ self.streams.gap[inside]), float(weights @ self.streams.forward[inside])

    def _averaged(self, stream: Array, weights: Array) -> Array:
        """The cells of a wave, first cell first: a correlation, by FFT."""
        from scipy.fft import next_fast_len

        N = self.start.register.cells
        read = stream[: N + weights.size - 1]
        size = int(next_fast_len(read.size, real=True))
        product = np.fft.rfft(read, size) * np.conj(np.fft.rfft(weights, size))
        return np.asarray(np.fft.irfft(product, size)[:N][::-1])


def first_contact(flight: FreeFlight, until: float) -> float | None:
    r"""Time at which ``z`` first rises above zero, or None if it does not before ``until``.

    ``z(tau)`` is an average, with Poisson weights of mean ``tau``, of the values ``z_n`` of the shift register.  So it
    never exceeds the largest of them, which often settles the question for all times at once; on ``[l, r]`` it does not
    exceed the largest in the window of the weights; and, as ``z'' = sum w_n Delta^2 z_n``, it stays within
    ``(r - l)^2/8 max |z''|`` of its chord.  What none of these decides is cut in eight.

    Parameters
    ----------
    flight : FreeFlight
        Free flight of a scheme.
    until : float
        End of the search [s].

    Returns
    -------
    float or None
        The time [s], to about ``1e-12`` of ``z`` in units of its largest value; 0 if contact holds at the start.  None
        says so up to that rounding: a touch shallower than it is not seen.

    Raises
    ------
    InputError
        ``until`` is not a positive number, or contact can neither be excluded nor found within a billion cell
        crossings.

    Examples
    --------
    >>> from lure.rod import builtin_system, upwind
    >>> from lure.rod.scheme import free_flight
    >>> system = builtin_system("paper-rod")
    >>> print(first_contact(free_flight(upwind(system.rod, 100_000), system.scenario), until=1e6))
    None
    """
    if not 0.0 < until < math.inf:
        raise InputError(f"until is {until!r}; give a positive number of seconds")
    rate = flight.register.rate
    found = next_contact(flight, until * rate)
    time = math.inf if found is None else (found.passed + found.tau) / rate
    return time if time <= until else None


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class NextContact:
    """A contact found: ``tau`` after ``passed`` whole cell crossings, where the flight had come to ``flight``."""

    flight: FreeFlight
    passed: int
    tau: float


def next_contact(flight: FreeFlight, until: float) -> NextContact | None:
    """:func:`first_contact` in units of ``1/s``, possibly a little later than ``until``.

    ``until``: end of the search, in units of ``1/s``.

    Raises
    ------
    InputError
        As for :func:`first_contact`.
    """
    passed, length = 0, 2 * flight.register.cells
    longest = _LONGEST * length
    if flight.start.gap > 0.0:
        return NextContact(flight=flight, passed=0, tau=0.0)
    while passed < until:
        start = flight.start
        scale = abs(start.gap) + float(np.abs(start.sums).max())
        remaining = (until - passed) / start.waves.size
        if start.largest_gap(math.ceil(2.0 * remaining) + 60.0) <= FLOOR * scale:
            return None
        if passed + length > _MOST:
            raise InputError(
                f"contact is neither excluded nor found in {_MOST} cell crossings; give an end before "
                f"{_MOST / start.register.rate:.3g} s, or fewer cells"
            )
        gaps = start.gaps(np.arange(window(length)[1] + 1))
        try:
            found = Crossing(values=gaps, floor=FLOOR * scale).first(0.0, float(length))
        except Undecided:
            length = halved(length)
            continue
        if found is not None:
            return NextContact(flight=flight, passed=passed, tau=found)
        flight = FreeFlight(start=flight.after(Mean(whole=length, rest=0.0)))
        passed, length = passed + length, min(2 * length, longest)
    return None


def halved(length: int) -> int:
    """A shorter stretch, after which the register is filled anew with values of the size of the motion.

    ``length``: cell crossings of the stretch that was not decided.

    Raises
    ------
    InputError
        It was a single one.
    """
    if length == 1:
        raise InputError("beginning or end of contact cannot be told from rounding; move the gap a little")
    return length // 2
