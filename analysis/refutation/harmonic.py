"""Orbits by harmonic balance with several harmonics, many starts at once: where the search for exact orbits begins."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.deadline import checkpoint
from analysis.refutation.following import Orbit

Reals = NDArray[np.float64]
Complexes = NDArray[np.complex128]

HARMONICS = np.arange(1, 8, 2)
SAMPLES = 128
STARTS = 600
STEPS = 40
FINE_SAMPLES = 4096


@dataclass(frozen=True, slots=True)
class Balance:
    """A wave ``y = Re sum c_h e^(i h w t)``, ``h = 1, 3, 5, 7``, that nearly satisfies the loop.

    Attributes
    ----------
    omega : float
        Fundamental frequency [rad/s].
    amplitudes : ndarray
        (4,) complex ``c_h``.
    """

    omega: float
    amplitudes: Complexes


class HarmonicBalance:
    """Harmonic balance for ``y = H mu``, ``mu = -psi(y)``, ``psi`` odd with kinks at ``y = -1`` and 1.

    Floating point, and cut off after the seventh harmonic: proposals for Newton's method on the flow, never proofs.

    Parameters
    ----------
    numerator, denominator : ndarray
        Of the strictly proper ``H``, descending powers.
    slopes : tuple of float
        Slope of ``psi`` between the kinks and outside them.
    """

    def __init__(self, numerator: Reals, denominator: Reals, slopes: tuple[float, float]) -> None:
        self.numerator, self.denominator = numerator, denominator
        self.inner, self.outer = slopes
        self.waves = np.exp(1j * np.outer(np.arange(SAMPLES) * (2 * math.pi / SAMPLES), HARMONICS))
        # apart, since products with complex matrices take ten times as long
        self.cosines, self.sines = self.waves.real.copy(), self.waves.imag.copy()

    def solutions(self, *, seed: int = 0) -> list[Balance]:
        """Balanced waves that pass the kinks, by Newton's method from random waves, no two alike."""
        rates = np.abs(np.roots(self.denominator))
        rates = rates[rates > 1e-6 * rates.max()] if rates.max() > 0 else np.ones(1)
        low, high = math.log(rates.min() / 5), math.log(rates.max() * 2)
        draw = np.random.default_rng(seed)
        size = 2 * len(HARMONICS)
        first = draw.uniform([low, 0.0], [high, math.log(30)], (STARTS, 2))
        unknowns = np.concatenate([first, draw.normal(size=(STARTS, size - 2)) / 2], axis=1)
        with np.errstate(all="ignore"):
            for _ in range(STEPS):
                checkpoint()
                unknowns, change = self._newton(unknowns)
                inside = (unknowns[:, 0] > low - 1) & (unknowns[:, 0] < high + 1) & (np.abs(unknowns[:, 1]) < 8)
                inside &= (np.abs(unknowns[:, 2:]) < 10).all(axis=1)
                unknowns, change = unknowns[inside], change[inside]
                if len(unknowns) == 0:
                    return []
        unknowns = unknowns[change < 1e-6]
        found: dict[tuple[str, str], Balance] = {}
        for row in unknowns:
            omega, amplitudes = self._wave(row[None, :])
            if np.abs((self.waves @ amplitudes[0]).real).max() > 1.0001:
                key = f"{omega[0]:.4g}", f"{abs(amplitudes[0, 0]):.3g}"
                found.setdefault(key, Balance(float(omega[0]), amplitudes[0]))
        return list(found.values())

    def orbit(self, wave: Balance) -> Orbit | None:
        """The wave as half an orbit in the companion form; None if it does not split into two halves at the kinks."""
        points, omega = wave.amplitudes, wave.omega
        phase = np.arange(FINE_SAMPLES) * (2 * math.pi / FINE_SAMPLES)
        y = (np.exp(1j * np.outer(phase, HARMONICS)) @ points).real
        piece = np.where(y < -1, 0, np.where(y > 1, 2, 1))
        switches = np.flatnonzero(np.diff(piece) != 0)
        if len(switches) == 0:
            return None
        first = int(switches[0])
        half = [int(i) for i in switches if i < first + FINE_SAMPLES // 2]
        step = 2 * math.pi / omega / FINE_SAMPLES
        durations = np.diff([*half, first + FINE_SAMPLES // 2]) * step
        s = 1j * omega * HARMONICS
        inner = points / np.polyval(self.numerator, s) * np.exp(1j * HARMONICS * phase[first])
        state = np.array([(inner * s**j).sum().real for j in range(len(self.denominator) - 1)])
        if len(half) < 2 or not np.isfinite(state).all():
            return None
        return Orbit(tuple(int(piece[(i + 1) % FINE_SAMPLES]) for i in half), state, durations, half=True)

    def _wave(self, unknowns: Reals) -> tuple[Reals, Complexes]:
        """Frequencies and amplitudes: the first is real and positive, the others are relative to it."""
        rest = len(HARMONICS) - 1
        ratio = unknowns[:, 2 : 2 + rest] + 1j * unknowns[:, 2 + rest :]
        first = np.exp(unknowns[:, 1:2])
        return np.exp(unknowns[:, 0]), first * np.concatenate([np.ones_like(first), ratio], axis=1)

    def _residual(self, unknowns: Reals) -> Reals:
        """``d c + n f`` for every harmonic, relative, ``f`` those of ``psi(y)``."""
        omega, c = self._wave(unknowns)
        y = c.real @ self.cosines.T - c.imag @ self.sines.T
        psi = self.outer * y + (self.inner - self.outer) * np.clip(y, -1, 1)
        f = 2 * (psi @ self.cosines - 1j * (psi @ self.sines)) / SAMPLES
        s = 1j * omega[:, None] * HARMONICS
        n, d = np.polyval(self.numerator, s), np.polyval(self.denominator, s)
        top = max(self.inner, self.outer)
        r = (d * c + n * f) / ((np.abs(d) + top * np.abs(n)) * np.abs(c[:, :1]))
        return np.concatenate([r.real, r.imag], axis=1)

    def _newton(self, unknowns: Reals) -> tuple[Reals, Reals]:
        """The unknowns after a damped step, those that have one, and the largest change."""
        residual = self._residual(unknowns)
        columns = []
        for j in range(unknowns.shape[1]):
            moved = unknowns.copy()
            moved[:, j] += 1e-7
            columns.append((self._residual(moved) - residual) / 1e-7)
        jacobian = np.stack(columns, axis=2)
        jacobian[~np.isfinite(jacobian).all(axis=(1, 2))] = 0.0
        good = np.flatnonzero(np.abs(np.linalg.det(jacobian)) > 1e-200)
        step = np.linalg.solve(jacobian[good], residual[good][..., None])[..., 0]
        change = np.abs(step).max(axis=1)
        return unknowns[good] - step * np.minimum(1, 0.3 / np.maximum(change, 1e-300))[:, None], change
