r"""A stretch of motion, in contact or under a force: more than the ring, and still a shift register.

In units of ``1/s`` the linear law adds ``-kappa z`` to ``z'`` and ``-2 kappa z`` to the first backward cell, with
``kappa = d c_n/s``, and a force adds ``2 b g`` to the first forward cell: one step of the register becomes

.. math:: z_{n+1} = (1 - \kappa) z_n + F_n, \qquad \text{entering the backward wave: } F_n - 2 \kappa z_n, \qquad
    \text{entering the forward wave: } f B_n + 2 b g_n,

where what leaves the waves, ``F_n`` and ``B_n``, is known ``N`` steps ahead.  The motion is the Poisson average of the
register as in free flight.  In contact its fastest alternations grow by up to ``(2 + kappa)/(2 - kappa)`` a round trip,
which the average takes away again and rounding remembers: hence stretches of limited length, and cells enough for a
small ``kappa``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from lure.structured.contact import Crossing
from lure.structured.poisson import Mean, poisson_weights, window
from lure.structured.ring import Ring

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
