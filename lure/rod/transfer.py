"""The rod without a grid: transfer function and poles of the partial differential equation itself."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from lure.arrays import ArrayLike, NDArray, np
from lure.errors import InputError
from lure.plants.block import StructuredPlant
from lure.record import Record, quantity
from lure.rod.parameters import Rod


def ring_transfer(
    rod: Rod, s: NDArray[np.complex128], log_round_trip: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    r"""``H = (d/s) (1 - a Q)/(1 + a Q)`` with ``Q = exp(log_round_trip)``, free of cancellation near ``Q = 1``.

    ``1 -+ a Q`` is taken as ``(1 -+ a) -+ a (Q - 1)`` with ``1 + a = 2 k b``, ``1 - a = 2 Z b``, and ``1/Q -+ a``
    likewise where ``|Q| > 1``, so that nothing overflows.  For ``k = Z`` no wave comes back and ``H = d/s``.

    In double precision the value is right to a few roundings of ``a`` and of the phase of ``Q``: they cost about
    ``2 |s| T`` units off resonance and ``1/(1 - |a|)`` times as many at one.  Near ``s = 0`` the real part alone is
    right to a few roundings too, however large the imaginary part.
    """
    a, one_plus, one_minus = rod.reflection, 2.0 * rod.damping * rod.input_gain, 2.0 * rod.impedance * rod.input_gain
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        integrator = rod.mobility / s
        if a == 0.0:
            return np.asarray(integrator)
        left = log_round_trip.real > 0
        x, y = -np.abs(log_round_trip.real), np.where(left, -log_round_trip.imag, log_round_trip.imag)
        minus_one = np.expm1(x) * np.cos(y) - 2.0 * np.sin(y / 2.0) ** 2 + 1j * np.exp(x) * np.sin(y)
        wave = np.where(left, minus_one, a * minus_one)
        top, bottom = np.where(left, one_minus + wave, one_minus - wave), one_plus + wave
        # 1/Q and a may both be small
        far, inverse = left & (x < -1.0), np.exp(x) * (np.cos(y) + 1j * np.sin(y))
        return np.asarray(integrator * (np.where(far, inverse - a, top) / np.where(far, inverse + a, bottom)))


LETTERS = {"E": "youngs_modulus", "rho": "density", "L": "length", "A": "area", "k": "damping"}


def certificate_parameters(rod: Rod) -> dict[str, str | int]:
    """The exact parameters of a rod as a certificate states them, as text ``p/q`` by the letters of the formulas."""
    return {letter: str(rod.exact[name]) for letter, name in LETTERS.items()}


class RodPlant(Record, StructuredPlant, kw_only=False):
    r"""The rod as a block from ``mu = -p`` [Pa] to ``sigma = z = u(t,L) - gap`` [m], with no discretisation.

    .. math:: H_\infty(s) = \frac{d}{s}\,\frac{1 - a e^{-2sT}}{1 + a e^{-2sT}},
        \qquad \text{poles } 0 \text{ and } \frac{\ln(-a) + 2\pi i m}{2T}.

    Notes
    -----
    All wave poles share one real part, ``ln|a|/(2T)``: ``H`` does not roll off relative to ``1/omega``, so a rational
    approximation of any order misses infinitely many of them.
    """

    rod: Rod = quantity("The rod")
    response_units: ClassVar[tuple[str, str]] = ("m/Pa", "m/(Pa s)")  # of H and of omega H
    gain_letter: ClassVar[str] = "κ"  # of the sector's upper end: k is the dashpot
    _kind = "rod"
    _title = "H(s) = (d/s) (1 - a exp(-2 s T))/(1 + a exp(-2 s T))"
    _notes = ("The rod itself, without a grid. In a loop mu = -p(sigma).",)

    @property
    def name(self) -> str:
        """``the rod``."""
        return "the rod"

    @property
    def order(self) -> None:
        """None: a wave has infinitely many modes."""
        return None

    def certificate_system(self) -> dict[str, str | int]:
        """The kind ``rod`` and the exact parameters that the loop depends on."""
        return {"kind": "rod", **certificate_parameters(self.rod)}

    def transfer(self, s: ArrayLike) -> NDArray[np.complex128]:
        """``H_inf(s)`` [m/Pa] at complex ``s`` [1/s], elementwise; not finite at a pole."""
        points = np.asarray(s, dtype=complex)
        return ring_transfer(self.rod, points, np.asarray(-2.0 * self.rod.travel_time * points))

    def poles(self, modes: int) -> NDArray[np.complex128]:
        r"""Poles with the smallest frequencies, conjugates included.

        Parameters
        ----------
        modes : int
            At least 1.  Wave poles are listed for ``m + 1/2``, ``m = -modes .. modes - 1``, in place of ``m`` in the
            formula (``a > 0``) or for ``m = -modes .. modes`` (``a < 0``).

        Returns
        -------
        ndarray
            The wave poles [1/s] in order of frequency, without the pole at zero.  Empty for ``k = Z``: the matched rod
            has none, every wave leaves within ``2T``.

        Raises
        ------
        InputError
            ``modes`` is less than 1.
        """
        if modes < 1:
            raise InputError(f"RodPlant.poles was asked for {modes} modes; ask for at least 1")
        a, period = self.rod.reflection, 2.0 * self.rod.travel_time
        if a == 0.0:
            return np.empty(0, dtype=complex)
        turns = np.arange(-modes, modes + 1) if a < 0 else np.arange(-modes, modes) + 0.5
        return np.asarray((self.log_reflection + 2j * math.pi * turns) / period)

    @property
    def speeds_at_infinity(self) -> tuple[float, ...]:
        """Lower and upper limit of ``-omega Im H(i omega)`` as ``omega`` grows [m/(Pa s)]; none without damping."""
        a, d = abs(self.rod.reflection), self.rod.mobility
        return (d * (1 - a) / (1 + a), d * (1 + a) / (1 - a)) if a < 1 else ()

    @property
    def log_reflection(self) -> float:
        """``ln|a|`` without cancellation near ``|a| = 1`` [-]; ``-inf`` for ``k = Z``."""
        k, Z = abs(self.rod.damping), self.rod.impedance
        ratio = min(k, Z) / max(k, Z)
        if ratio > 0.5:
            return math.log(abs(self.rod.reflection)) if self.rod.reflection else -math.inf
        magnitude = math.log1p(-ratio) - math.log1p(ratio)
        return magnitude if self.rod.damping >= 0 else -magnitude

    def _rows(self) -> Iterator[tuple[object, ...]]:
        yield "a", f"{self.rod.reflection:.6g}"
        yield "d = 1/sqrt(rho E)", f"{self.rod.mobility:.6g} m/(Pa s)"
        yield "T = L/c", f"{self.rod.travel_time:.6g} s"
