"""A multiplier ``M = Gamma - sum c_k h_k`` with kernels, and Popov's terms, in floating point."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from lure.arrays import NDArray, np


class Kernel(NamedTuple):
    """``sign (rate/(rate + side s))^order`` in a row and a column; rate 0: ``sign`` alone, beside the diagonal.

    Side 0: the mean of both sides, on the diagonal of ``row`` and of the other channels of an operator, ``also``.
    ``mirrored``: its conjugate stands in the row ``column`` and the column ``row``.
    """

    row: int
    column: int
    sign: int
    rate: Fraction
    order: int
    side: int
    also: tuple[int, ...] = ()
    mirrored: bool = False

    def at(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """The value at ``i omega`` without the sign, 0 at infinity; in floating point.

        Parameters
        ----------
        omega : ndarray
            (k,) frequencies [rad/s].
        """
        if not self.rate:
            return np.ones(len(omega), dtype=complex)
        finite = np.isfinite(omega)
        lag = (self.side or 1) * np.where(finite, omega, 0.0) / float(self.rate)
        found = np.where(finite, (1 + 1j * lag) ** -float(self.order), 0)
        return np.asarray(found if self.side else found.real + 0j)

    def masses(self, rate: float) -> tuple[float, float]:
        """What it takes in its row and in its column at a rate: ``h(rate)`` and ``h(-rate)``.

        Parameters
        ----------
        rate : float
            The rate [1/s], less than that of the kernel.
        """
        lag = self.side * rate / float(self.rate) if self.rate else 0.0
        return (1 + lag) ** -self.order, (1 - lag) ** -self.order

    def integrated(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """``(h - 1)/(i omega)``, likewise: ``h`` of a kernel with a side, less its value at 0, after an integrator."""
        rate = self.side * float(self.rate) if self.rate else np.inf
        lag = 1 / (1 + 1j * np.where(np.isfinite(omega), omega, 0.0) / rate)
        return np.asarray(np.where(np.isfinite(omega), -sum(lag**k for k in range(1, self.order + 1)) / rate, 0) + 0j)


class Found(NamedTuple):
    """A multiplier, and the factor up to which it serves."""

    factor: float
    gamma: NDArray[np.float64]
    theta: NDArray[np.float64]
    kernels: list[Kernel]
    masses: NDArray[np.float64]

    @classmethod
    def none(cls, m: int) -> Found:
        """The multiplier 1, which serves for nothing.

        Parameters
        ----------
        m : int
            Channels.
        """
        return cls(0.0, np.ones(m), np.zeros(m), [], np.zeros(0))

    def at(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """``M`` at ``i omega``: (k, m, m).

        Parameters
        ----------
        omega : ndarray
            (k,) frequencies [rad/s].
        """
        m = len(self.gamma)
        M = np.zeros((len(omega), m, m), dtype=complex)
        M[:, range(m), range(m)] = self.gamma
        for mass, kernel in zip(self.masses, self.kernels, strict=True):
            value = mass * kernel.sign * kernel.at(omega)
            for i in (kernel.row, *kernel.also):
                M[:, i, kernel.column if i == kernel.row else i] -= value
            if kernel.mirrored:
                M[:, kernel.column, kernel.row] -= value.conj()
        return M

    def integrated(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """The diagonal of ``(M(i omega) - M(0))/(i omega)``: (k, m)."""
        N = np.zeros((len(omega), len(self.gamma)), dtype=complex)
        for mass, kernel in zip(self.masses, self.kernels, strict=True):
            N[:, kernel.row] -= mass * kernel.sign * kernel.integrated(omega)
        return N

    def without(self, share: float) -> Found:
        """The multiplier without its small kernels; those without rate stay.

        Parameters
        ----------
        share : float
            Of the greatest ``gamma``: the least mass that is kept.
        """
        least = share * float(self.gamma.max())
        kept = [
            k
            for k, (one, mass) in enumerate(zip(self.kernels, self.masses, strict=True))
            if mass > least or not one.rate
        ]
        return self._replace(kernels=[self.kernels[k] for k in kept], masses=np.maximum(self.masses[kept], 0.0))
