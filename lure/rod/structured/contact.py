"""The first contact of a free flight: excluded for ever, or located."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from lure.errors import InputError
from lure.rod.structured.flight import FreeFlight, later
from lure.rod.structured.ring import Mean, Ring, parted, poisson_weights, window

# A stretch of motion, in contact or under a force: more than the ring, and still a shift register.
#
# In units of ``1/s`` the linear law adds ``-kappa z`` to ``z'`` and ``-2 kappa z`` to the first backward cell, with
# ``kappa = d c_n/s``, and a force adds ``2 b g`` to the first forward cell: one step of the register becomes
#
# .. math:: z_{n+1} = (1 - \kappa) z_n + F_n, \qquad \text{entering the backward wave: } F_n - 2 \kappa z_n, \qquad
#     \text{entering the forward wave: } f B_n + 2 b g_n,
#
# where what leaves the waves, ``F_n`` and ``B_n``, is known ``N`` steps ahead.  The motion is the Poisson average of
# the
# register as in free flight.  In contact its fastest alternations grow by up to ``(2 + kappa)/(2 - kappa)`` a round
# trip,
# which the average takes away again and rounding remembers: hence stretches of limited length, and cells enough for a
# small ``kappa``.

Array: TypeAlias = NDArray[np.float64]

_LARGEST_GAIN = 100.0
_MOST_TRIPS = 64
_MOST_COLUMNS = 2_000_000


def fewest_cells(stiffness: float) -> int:
    """The fewest cells with which contact loses at most two digits to its register.

    Parameters
    ----------
    stiffness : float
        ``d c_n L/c = kappa N``.
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
    seen = (window(2.0 * cells * trips)[1] + 4) / (2.0 * cells)
    return seen * math.log((2.0 + kappa) / (2.0 - kappa))


@dataclass(frozen=True, kw_only=True, eq=False)
class Stretch:
    """One stretch of motion from the state of a ring.

    Attributes
    ----------
    ring : Ring
        The scheme and its state where the stretch begins.
    length : int
        Cell crossings covered.
    kappa : float
        ``d c_n/s`` in contact, how much of ``z`` the law takes back per cell crossing; 0 in flight [-].
    entering : ndarray or None
        What a force adds to the first forward cell at each step [m/s], at least as many as :meth:`columns_of` says.
    """

    ring: Ring
    length: int
    kappa: float
    entering: Array | None = None

    @staticmethod
    def columns_of(length: int) -> int:
        """Steps of the register that the averages over a stretch read."""
        return window(float(length))[1] + 4

    @cached_property
    def rounding(self) -> float:
        """Largest average of ``|s z_n|`` over the stretch: what rounding of ``s z`` is relative to."""
        sizes = Crossing(values=np.abs(self.streams[2]), floor=0.0)
        return max(sizes.at(share * self.length / 8.0) for share in range(9))

    @cached_property
    def streams(self) -> tuple[Array, Array, Array]:
        """What leaves the forward wave, what leaves the backward wave (columns + N - 1,), and ``s z`` (columns,)."""
        from scipy.signal import lfilter

        N, waves, kappa = self.ring.scheme.cells, self.ring.waves, self.kappa
        columns = self.columns_of(self.length)
        forward, backward = np.empty(N + columns - 1), np.empty(N + columns - 1)
        gap = np.empty(columns)
        forward[:N], backward[:N], gap[0] = waves[N - 1 :: -1], waves[: N - 1 : -1], self.ring.gap
        for start in range(0, columns - 1, N):
            stop = min(start + N, columns - 1)
            leaving = forward[start:stop]
            if kappa > 0.0:
                carried = np.array([(1.0 - kappa) * gap[start]])
                gap[start + 1 : stop + 1] = lfilter([1.0], [1.0, kappa - 1.0], leaving, zi=carried)[0]
                backward[N + start : N + stop] = leaving - 2.0 * kappa * gap[start:stop]
            else:
                gap[start + 1 : stop + 1] = gap[start] + np.cumsum(leaving)
                backward[N + start : N + stop] = leaving
            forward[N + start : N + stop] = self.ring.echo * backward[start:stop]
            if self.entering is not None:
                forward[N + start : N + stop] += self.entering[start:stop]
        return forward, backward, gap

    def after(self, mean: Mean) -> Ring:
        """The ring at the time ``mean`` from the beginning, in units of ``1/s``."""
        forward, backward, gap = self.streams
        first, weights = poisson_weights(mean)
        waves = [self._averaged(stream[first:], weights) for stream in (forward, backward)]
        return Ring(
            scheme=self.ring.scheme,
            waves=np.concatenate(waves),
            gap=float(weights @ gap[first : first + weights.size]),
        )

    def end_at(self, mean: Mean) -> tuple[float, float]:
        """``s z`` and ``y_N`` [m/s] at the time ``mean`` from the beginning."""
        forward, _, gap = self.streams
        first, weights = poisson_weights(mean)
        inside = slice(first, first + weights.size)
        return float(weights @ gap[inside]), float(weights @ forward[inside])

    def _averaged(self, stream: Array, weights: Array) -> Array:
        """The cells of a wave, first cell first: a correlation, by FFT."""
        from scipy.fft import next_fast_len

        N = self.ring.scheme.cells
        read = stream[: N + weights.size - 1]
        size = int(next_fast_len(read.size, real=True))
        product = np.fft.rfft(read, size) * np.conj(np.fft.rfft(weights, size))
        return np.asarray(np.fft.irfft(product, size)[:N][::-1])


_PIECES = 8
_LONGEST = 64  # round trips looked at in one piece
_MOST = 1_000_000_000  # cell crossings looked at in all
FLOOR = 1e-12
_NARROW = 1e-12
_EFFORT = 400
_SHORT = 2.0
_LEFT_OUT = 1e-15


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
    >>> from lure import builtin_system, upwind
    >>> from lure.rod.structured import free_flight
    >>> system = builtin_system("paper-rod")
    >>> print(first_contact(free_flight(upwind(system.rod, 100_000), system.scenario), until=1e6))
    None
    """
    if not 0.0 < until < math.inf:
        raise InputError(f"until is {until!r}; give a positive number of seconds")
    rate = flight.ring.scheme.rate
    found = next_contact(flight, until * rate)
    time = math.inf if found is None else (found.passed + found.tau) / rate
    return time if time <= until else None


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Touch:
    """A contact found: ``tau`` after ``passed`` whole cell crossings, where the flight had come to ``flight``."""

    flight: FreeFlight
    passed: int
    tau: float


def next_contact(flight: FreeFlight, until: float) -> Touch | None:
    """:func:`first_contact` in units of ``1/s``, possibly a little later than ``until``.

    Parameters
    ----------
    flight : FreeFlight
        Free flight.
    until : float
        End of the search, in units of ``1/s``.

    Raises
    ------
    InputError
        As for :func:`first_contact`.
    """
    passed, length = 0, 2 * flight.ring.scheme.cells
    longest = _LONGEST * length
    if flight.ring.gap > 0.0:
        return Touch(flight=flight, passed=0, tau=0.0)
    while passed < until:
        ring = flight.ring
        scale = abs(ring.gap) + float(np.abs(ring.sums).max())
        remaining = (until - passed) / (2 * ring.scheme.cells)
        if ring.largest_gap(math.ceil(2.0 * remaining) + 60.0) <= FLOOR * scale:
            return None
        if passed + length > _MOST:
            raise InputError(
                f"contact is neither excluded nor found in {_MOST} cell crossings; give an end before "
                f"{_MOST / ring.scheme.rate:.3g} s, or fewer cells"
            )
        gaps = ring.gaps(np.arange(window(float(length))[1] + 1))
        try:
            found = Crossing(values=gaps, floor=FLOOR * scale).first(0.0, float(length))
        except Undecided:
            length = halved(length)
            continue
        if found is not None:
            return Touch(flight=flight, passed=passed, tau=found)
        flight = later(flight, length)
        passed, length = passed + length, min(2 * length, longest)
    return None


class Undecided(Exception):
    """The sequence is so much larger than its average that bounds of it settle nothing."""


def halved(length: int) -> int:
    """A shorter stretch, after which the register is filled anew with values of the size of the motion.

    Parameters
    ----------
    length : int
        Cell crossings of the stretch that was not decided.

    Raises
    ------
    InputError
        It was a single one.
    """
    if length == 1:
        raise InputError("beginning or end of contact cannot be told from rounding; move the gap a little")
    return length // 2


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Crossing:
    """The first crossing above zero of the Poisson average of a sequence.

    Attributes
    ----------
    values : ndarray
        The sequence, as far as the windows of the weights reach.
    floor : float
        What counts as zero.
    effort : list of int
        How many more intervals may be looked at.
    """

    values: Array
    floor: float
    effort: list[int] = field(default_factory=lambda: [_EFFORT])

    def at(self, tau: float, differences: int = 0) -> float:
        """The average at ``tau``, or that of the first difference, which is its slope."""
        first, weights = poisson_weights(parted(tau))
        values = self.values[first : first + weights.size + differences]
        weights = weights[: values.size - differences]
        return float(weights @ (np.diff(values, differences) if differences else values))

    def first(self, left: float, right: float) -> float | None:
        """The first crossing in ``[left, right]``; raises :class:`Undecided` if that takes too long."""
        self.effort[0] -= 1
        if self.effort[0] < 0:
            raise Undecided
        start, stop = window(left)[0], window(right)[1] + 3
        inside = self.values[start:stop]
        if inside.max() <= self.floor:
            return None
        width = right - left
        chord = 0.125 * width * width
        at_left, at_right = self.at(left), self.at(right)
        if max(at_left, at_right) + chord * self.bend(left, right, 2) <= self.floor:
            return None
        if width <= _NARROW * max(1.0, right):
            return right if at_right > self.floor else None
        if at_right > self.floor and at_left <= self.floor:
            slope = min(self.at(left, 1), self.at(right, 1))
            if slope - chord * self.bend(left, right, 3) > 0.0:
                return self.zero(left, right)
        edges = np.linspace(left, right, _PIECES + 1)
        for low, high in pairwise(edges.tolist()):
            found = self.first(low, high)
            if found is not None:
                return found
        return None

    def bend(self, left: float, right: float, order: int) -> float:
        """Bound of the derivative of that order on ``[left, right]``: no average of differences exceeds the largest.

        On short intervals also ``e^{right - left}`` times their average at ``right``, since no weight exceeds its value
        there by more; what the window leaves out of it is below rounding of the largest.
        """
        largest = float(np.abs(np.diff(self.values[window(left)[0] : window(right)[1] + 3], order)).max(initial=0.0))
        if right - left > _SHORT:
            return largest
        first, weights = poisson_weights(parted(right))
        sizes = np.abs(np.diff(self.values[first : first + weights.size + order], order))
        average = float(weights[: sizes.size] @ sizes) + _LEFT_OUT * largest
        return min(largest, math.exp(right - left) * average)

    def zero(self, left: float, right: float) -> float:
        """The one zero between a value that is not positive and one that is, by Newton's method kept in its bracket."""
        tau = right
        for _ in range(100):
            value = self.at(tau)
            left, right = (left, tau) if value > 0.0 else (tau, right)
            if abs(value) <= 0.1 * self.floor or right - left <= _NARROW * max(1.0, right):
                break
            tau -= value / self.at(tau, 1)
            if not left < tau < right:
                tau = 0.5 * (left + right)
        return tau
