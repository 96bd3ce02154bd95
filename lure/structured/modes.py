r"""The scaled FFT: eigenvectors of the f-circulant ring, and time jumps that lose no digits to their length.

With ``g^{2N} = 1/f`` the matrix ``diag(g)^{-j} S diag(g)^j`` is ``1/g`` times the cyclic shift, so that the FFT of
``g^{-j} y_j`` diagonalises ``S``, with the eigenvalues ``omega = |f|^{1/2N} e^{i theta}``.  In ``e^{tau(omega - 1)}``
the phase ``tau |omega| sin(theta)`` is of size ``1e5`` and more; but with ``n`` the integer next to ``tau``,

.. math:: e^{\tau(\omega - 1)} = e^{\tau (|\omega| \cos\theta - 1)}\; e^{i n \theta}\;
    e^{i [(\tau - n)\theta + \tau(|\omega| - 1) \sin\theta + \tau(\sin\theta - \theta)]},

where ``n theta`` is a whole number of parts of a turn, reduced exactly, and the bracket is small for every mode that is
not yet damped away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from lure.structured.poisson import Mean
from lure.structured.ring import Ring

Array: TypeAlias = NDArray[np.float64]
Complex: TypeAlias = NDArray[np.complex128]

_GONE = 750.0  # exp(-750) is zero
_SMALL = 0.5


@dataclass(frozen=True, kw_only=True, eq=False)
class Modes:
    """Modes of a ring in order of frequency, with the amplitudes of its state at the start.

    Attributes
    ----------
    ring : Ring
        The ring; ``f`` is not zero.
    """

    ring: Ring

    @property
    def size(self) -> int:
        """``2N``."""
        return 2 * self.ring.scheme.cells

    @property
    def log_growth(self) -> float:
        """``ln|omega| = ln|f|/2N``."""
        return self.ring.log_echo / self.size

    @cached_property
    def order(self) -> NDArray[np.int64]:
        """Indices of the FFT, lowest frequency first."""
        turns = np.abs(2 * np.fft.fftfreq(self.size, 1.0 / self.size) - self._odd)
        return np.argsort(turns, kind="stable")

    @cached_property
    def quarters(self) -> NDArray[np.int64]:
        """``theta`` of each mode in units of ``pi/2N``: even for ``f > 0``, odd for ``f < 0``."""
        turns = np.rint(np.fft.fftfreq(self.size, 1.0 / self.size)).astype(np.int64)
        return np.asarray((self._odd - 2 * turns)[self.order])

    @cached_property
    def theta(self) -> Array:
        """Angles of the eigenvalues [rad]."""
        return np.asarray(math.pi * self.quarters / self.size)

    @cached_property
    def rate(self) -> Complex:
        """``omega - 1``, without cancellation."""
        growth, theta = self.log_growth, self.theta
        real = math.expm1(growth) * np.cos(theta) - 2.0 * np.sin(0.5 * theta) ** 2
        return np.asarray(real + 1j * math.exp(growth) * np.sin(theta))

    @cached_property
    def scale(self) -> Complex:
        """(2N,) ``g^{-j}``."""
        j = np.arange(self.size)
        return np.asarray(np.exp(self.log_growth * j) * self._turned(self._odd * j))

    @cached_property
    def amplitudes(self) -> Complex:
        """(2N,) FFT of the scaled waves, in the order of the modes, divided by ``2N``."""
        return np.asarray(np.fft.fft(self.scale * self.ring.waves)[self.order] / self.size)

    @cached_property
    def at_end(self) -> Complex:
        """(2N,) what each mode contributes to ``y_N``."""
        last = self.ring.scheme.cells - 1
        return np.asarray(self.amplitudes * self._turned(2 * self.order * last) / self.scale[last])

    @cached_property
    def spent(self) -> Array:
        """(2N+1,) what the modes from the given one on contribute to ``s z`` when they are damped away."""
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(self.rate == 0.0, 0.0, -self.at_end / self.rate).real
        return np.concatenate((np.cumsum(share[::-1])[::-1], [0.0]))

    def active(self, tau: float) -> int:
        """Number of modes that are left after ``tau``."""
        damping = math.expm1(self.log_growth) + _GONE / tau if tau > 0.0 else math.inf
        half = 0.5 * damping * math.exp(-self.log_growth)  # sin^2(theta/2) up to which a mode is left
        if half >= 1.0:
            return self.size
        if half <= 0.0:
            return 0
        return int(np.searchsorted(np.abs(self.theta), 2.0 * math.asin(math.sqrt(half)), side="right"))

    def factors(self, mean: Mean, count: int) -> Complex:
        """``e^{tau (omega - 1)}`` of the first ``count`` modes."""
        tau, theta, growth = mean.value, self.theta[:count], math.expm1(self.log_growth)
        fading = tau * growth - 2.0 * tau * (1.0 + growth) * np.sin(0.5 * theta) ** 2
        phase = mean.rest * theta + tau * growth * np.sin(theta) + tau * _sine_defect(theta)
        turns = self._turned((mean.whole % (2 * self.size)) * self.quarters[:count])
        return np.asarray(np.exp(fading) * turns * (np.cos(phase) + 1j * np.sin(phase)))

    def waves(self, mean: Mean) -> Array:
        """(2N,) the waves after ``tau``."""
        count = self.active(mean.value)
        spectrum = np.zeros(self.size, dtype=complex)
        spectrum[self.order[:count]] = self.amplitudes[:count] * self.factors(mean, count)
        return np.asarray((np.fft.ifft(spectrum, norm="forward") / self.scale).real)

    def end(self, mean: Mean) -> tuple[float, float]:
        """``s z`` and ``y_N`` after ``tau``."""
        tau, count = mean.value, self.active(mean.value)
        factors, rate, share = self.factors(mean, count), self.rate[:count], self.at_end[:count]
        early = np.abs(rate) * tau < _SMALL
        with np.errstate(divide="ignore", invalid="ignore"):
            grown = np.where(early, np.expm1(np.where(early, rate, 0.0) * tau), factors - 1.0)
            travelled = np.where(rate == 0.0, tau, grown / rate)
        gap = self.ring.gap + float((share * travelled).real.sum()) + float(self.spent[count])
        return gap, float((share * factors).real.sum())

    @property
    def _odd(self) -> int:
        return 0 if self.ring.echo > 0.0 else 1

    def _turned(self, quarters: NDArray[np.int64]) -> Complex:
        """``e^{i pi quarters/2N}``, the angle reduced exactly."""
        angle = math.pi * (quarters % (2 * self.size)) / self.size
        return np.asarray(np.cos(angle) + 1j * np.sin(angle))


def _sine_defect(theta: Array) -> Array:
    """``sin(theta) - theta``, by its series below 1."""
    x = np.where(np.abs(theta) < 1.0, theta, 0.0)
    square, total = x * x, np.ones_like(x)
    for k in range(9, 1, -1):
        total = 1.0 - square / (2 * k * (2 * k + 1)) * total
    return np.where(np.abs(theta) < 1.0, -x * square / 6.0 * total, np.sin(theta) - theta)
