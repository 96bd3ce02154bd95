"""The rod without a grid: transfer function and poles of the partial differential equation itself."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.rod import Rod


def ring_transfer(
    rod: Rod, s: NDArray[np.complex128], log_round_trip: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    r"""``H = (d/s) (1 - a Q)/(1 + a Q)`` with ``Q = exp(log_round_trip)``, free of cancellation near ``Q = 1``.

    ``1 -+ a Q`` is taken as ``(1 -+ a) -+ a (Q - 1)`` with ``1 + a = 2k/(k+Z)``, ``1 - a = 2Z/(k+Z)``.
    """
    a, total = rod.reflection, rod.damping + rod.impedance
    x, y = log_round_trip.real, log_round_trip.imag
    minus_one = np.expm1(x) * np.cos(y) - 2.0 * np.sin(y / 2.0) ** 2 + 1j * np.exp(x) * np.sin(y)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = (2.0 * rod.impedance / total - a * minus_one) / (2.0 * rod.damping / total + a * minus_one)
        return np.asarray(rod.mobility / s * ratio)


@dataclass(frozen=True, eq=False)
class RodBlock:
    r"""The rod as a block from ``mu = -p`` [Pa] to ``sigma = z = u(t,L) - gap`` [m], with no discretisation.

    .. math:: H_\infty(s) = \frac{d}{s}\,\frac{1 - a e^{-2sT}}{1 + a e^{-2sT}},
        \qquad \text{poles } 0 \text{ and } \frac{\ln(-a) + 2\pi i m}{2T}.

    Parameters
    ----------
    rod : Rod
        The rod.

    Notes
    -----
    All wave poles share one real part, ``ln|a|/(2T)``: ``H`` does not roll off relative to ``1/omega``, so a rational
    approximation of any order misses infinitely many of them.
    """

    rod: Rod

    def transfer(self, s: ArrayLike) -> NDArray[np.complex128]:
        """``H_inf(s)`` [m/Pa] at complex ``s`` [1/s], elementwise; not finite at a pole."""
        points = np.asarray(s, dtype=complex)
        return ring_transfer(self.rod, points, -2.0 * self.rod.travel_time * points)

    def poles(self, modes: int) -> NDArray[np.complex128]:
        r"""Poles with the smallest frequencies, conjugates included.

        Parameters
        ----------
        modes : int
            Wave poles are listed for ``m = -modes .. modes - 1`` (``k > Z``) or ``-modes .. modes`` (``k < Z``).

        Returns
        -------
        ndarray
            The wave poles [1/s] in order of frequency, without the pole at zero.  Empty for ``k = Z``: the matched rod
            has none, every wave leaves within ``2T``.
        """
        a, period = self.rod.reflection, 2.0 * self.rod.travel_time
        if a == 0.0:
            return np.empty(0, dtype=complex)
        turns = np.arange(-modes, modes + 1) if a < 0 else np.arange(-modes, modes) + 0.5
        return np.asarray((self.log_reflection + 2j * math.pi * turns) / period)

    @property
    def log_reflection(self) -> float:
        """``ln|a|`` without cancellation near ``|a| = 1`` [-]; ``-inf`` for ``k = Z``."""
        k, Z = abs(self.rod.damping), self.rod.impedance
        ratio = min(k, Z) / max(k, Z)
        if ratio > 0.5:
            return math.log(abs(self.rod.reflection)) if self.rod.reflection else -math.inf
        magnitude = math.log1p(-ratio) - math.log1p(ratio)
        return magnitude if self.rod.damping >= 0 else -magnitude
