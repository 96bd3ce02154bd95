r"""Contact with a linear law: one rank more than the ring, and still a shift register.

In units of ``1/s`` the law adds ``-kappa z`` to ``z'`` and ``-2 kappa z`` to the first backward cell, with
``kappa = d c_n/s``: the ring gets a coupling of rank one, and one step of the register becomes

.. math:: z_{n+1} = (1 - \kappa) z_n + F_n, \qquad \text{entering the backward wave: } F_n - 2 \kappa z_n,

where what leaves the forward wave, ``F_n``, is known ``N`` steps ahead.  The motion is the Poisson average of the
register as in free flight.  Its fastest alternations grow by up to ``(2 + kappa)/(2 - kappa)`` a round trip, which the
average takes away again and rounding remembers: hence one round trip at a time, and cells enough for a small ``kappa``.
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


def fewest_cells(stiffness: float) -> int:
    """The fewest cells with which contact loses at most two digits to its register.

    Parameters
    ----------
    stiffness : float
        ``d c_n L/c = kappa N``.
    """
    cells = max(1, math.ceil(stiffness))
    while _gain(cells, stiffness / cells) > _LARGEST_GAIN:
        cells += max(1, cells // 50)
    return cells


def _gain(cells: int, kappa: float) -> float:
    """Growth of the fastest alternations over the window of a round trip."""
    trips = (window(2.0 * cells)[1] + 4) / (2.0 * cells)
    return float(((2.0 + kappa) / (2.0 - kappa)) ** trips)


@dataclass(frozen=True, kw_only=True, eq=False)
class Press:
    """One stretch of contact, at most a round trip long, from the state of a ring.

    Attributes
    ----------
    ring : Ring
        The scheme and its state where the stretch begins; ``s z >= 0``.
    length : int
        Cell crossings covered, at most ``2N``.
    """

    ring: Ring
    length: int

    @property
    def kappa(self) -> float:
        """``d c_n/s``: how much of ``z`` the law takes back per cell crossing [-]."""
        scheme = self.ring.scheme
        return scheme.rod.mobility * scheme.rod.law.stiffness / scheme.rate

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
        columns = window(float(self.length))[1] + 4
        forward, backward = np.empty(N + columns - 1), np.empty(N + columns - 1)
        gap = np.empty(columns)
        forward[:N], backward[:N], gap[0] = waves[N - 1 :: -1], waves[: N - 1 : -1], self.ring.gap
        for start in range(0, columns - 1, N):
            stop = min(start + N, columns - 1)
            leaving = forward[start:stop]
            carried = np.array([(1.0 - kappa) * gap[start]])
            gap[start + 1 : stop + 1] = lfilter([1.0], [1.0, kappa - 1.0], leaving, zi=carried)[0]
            backward[N + start : N + stop] = leaving - 2.0 * kappa * gap[start:stop]
            forward[N + start : N + stop] = self.ring.echo * backward[start:stop]
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
        N = self.ring.scheme.cells
        read = stream[: N + weights.size - 1]
        size = read.size
        product = np.fft.rfft(read, size) * np.conj(np.fft.rfft(weights, size))
        return np.asarray(np.fft.irfft(product, size)[:N][::-1])
