"""Periodic solutions of a loop with a sine as input by harmonic balance, in floating point: proposals, never proofs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from lure.analysis.deadline import checkpoint
from lure.analysis.forced.loop import ForcedLoop
from lure.arrays import Complexes, Reals, np

_BY_NEWTON, _STEPS, _HALVINGS, _SMALL = 24, 60, 12, 1e-13


@dataclass(frozen=True)
class Wave:
    r"""``w(t) = constant + amplitude sin(omega t)``, looked at over ``periods`` of its periods.

    Attributes
    ----------
    constant, amplitude : tuple of Fraction
        (p,) [unit of w].
    omega : Fraction
        [rad/s]; 0 for a constant input.
    periods : int
        How many periods of the input the solution looked for has: more than 1 for a subharmonic.
    """

    constant: tuple[Fraction, ...]
    amplitude: tuple[Fraction, ...]
    omega: Fraction
    periods: int = 1

    @property
    def base(self) -> Fraction:
        """The frequency [rad/s] of which all are multiples."""
        return self.omega / self.periods

    def harmonics(self, count: int) -> Complexes:
        """(p, count + 1) the ``w_k`` with ``w = Re sum w_k e^(i k base t)``."""
        found = np.zeros((len(self.constant), count + 1), complex)
        found[:, 0] = [float(v) for v in self.constant]
        if self.omega:
            found[:, self.periods] += [-1j * float(v) for v in self.amplitude]
        return found


@dataclass(frozen=True)
class Balanced:
    """Harmonics ``c_k`` of the ``psi_i(sigma_i)`` that nearly balance the loop.

    Attributes
    ----------
    wave : Wave
        The input.
    psi : ndarray
        (m, count + 1) complex, ``psi = Re sum c_k e^(i k base t)``, the first column real.
    residual : float
        By how much the harmonics do not balance.
    missed : float
        Mean square root of what they miss of ``psi(sigma)``, by samples.
    peak : float
        Largest ``|z|``, by samples.
    """

    wave: Wave
    psi: Complexes
    residual: float
    missed: float
    peak: float

    @property
    def count(self) -> int:
        """How many harmonics."""
        return int(self.psi.shape[1]) - 1


def sampled(coefficients: Complexes, points: int) -> Reals:
    """``Re sum c_k e^(2 pi i k j/points)`` for every ``j``.

    Parameters
    ----------
    coefficients : ndarray
        (..., count + 1).
    points : int
        More than twice as many.
    """
    half = coefficients * (points / 2)
    half[..., 0] = coefficients[..., 0].real * points
    return np.asarray(np.fft.irfft(half, points, axis=-1))


def balanced(loop: ForcedLoop, wave: Wave, start: Complexes, count: int) -> Balanced:
    """The harmonics that Newton's method leads to, those above the 24th by substitution.

    Parameters
    ----------
    loop : ForcedLoop
        The loop.
    wave : Wave
        The input.
    start : ndarray
        (m, any) where to begin.
    count : int
        How many harmonics.
    """
    psi = np.zeros((loop.channels, count + 1), complex)
    psi[:, : start.shape[1]] = start
    whole, outer = loop.responses(float(wave.base), count)
    points = 1 << max(4, math.ceil(math.log2(8 * (count + 1))))
    forced = np.einsum("kij,jk->ik", outer, wave.harmonics(count))
    inner, driven = whole[:, : loop.channels], forced[: loop.channels]

    by_channel = (loop.nonlinearities, loop.gains)

    def applied(psi: Complexes) -> tuple[Complexes, Reals]:
        """The harmonics of ``psi(sigma)``, and samples of ``sigma``."""
        sigma = sampled(driven - np.einsum("kij,jk->ik", inner, psi), points)
        values = np.array([np.asarray(phi(s)) - float(g) * s for phi, g, s in zip(*by_channel, sigma, strict=True)])
        found = np.fft.rfft(values, axis=1)[:, : count + 1] * (2 / points)
        found[:, 0] = found[:, 0].real / 2
        return found, sigma

    low = min(count, _BY_NEWTON)
    with np.errstate(all="ignore"):
        found, sigma = applied(psi)
        off = found - psi
        for _ in range(_STEPS):
            checkpoint()
            size = float(np.abs(off).max())
            if not size > _SMALL * max(1.0, float(np.abs(psi).max())):
                break
            step = off.copy()
            step[:, : low + 1] = _newton(loop, inner[: low + 1], sigma, off[:, : low + 1], points)
            length = 1.0
            for _ in range(_HALVINGS):
                trial = psi + length * step
                found, sigma = applied(trial)
                after = found - trial
                if np.isfinite(after).all() and np.abs(after).max() < size * (1 - 0.1 * length):
                    break
                length /= 2
            else:
                break
            psi, off = trial, after
        _, sigma = applied(psi)
    left = np.array([np.asarray(phi(s)) - float(g) * s for phi, g, s in zip(*by_channel, sigma, strict=True)])
    missed = left - sampled(psi, points)
    z = sampled((forced - np.einsum("kij,jk->ik", whole, psi))[loop.channels :], points)
    mean, top = (float(one) for one in ((missed**2).sum(axis=0).mean(), (z**2).sum(axis=0).max()))
    return Balanced(wave, psi, float(np.abs(off).max()), math.sqrt(mean), math.sqrt(top))


def _newton(loop: ForcedLoop, inner: Complexes, sigma: Reals, off: Complexes, points: int) -> Complexes:
    """The step of the low harmonics that balances them to first order."""
    m, size = off.shape
    angles = np.outer(np.arange(points) * (2 * math.pi / points), np.arange(size))
    turning = np.exp(1j * angles)
    # of the unknowns Re c_k and Im c_k of a channel
    moved = np.zeros((m, points, m, size, 2))
    for i in range(m):
        for j in range(m):
            one = -inner[:, i, j] * turning
            moved[i, :, j, :, 0], moved[i, :, j, :, 1] = one.real, -one.imag
    jacobian = np.zeros((m, size, 2, m, size, 2))
    for i, (phi, g) in enumerate(zip(loop.nonlinearities, loop.gains, strict=True)):
        slopes = np.asarray(phi.slope(sigma[i])) - float(g)  # type: ignore[attr-defined]  # what has an enclosure has one
        whole = np.einsum("pk,p,pjhc->kjhc", turning.conj(), slopes, moved[i], optimize=True) * (2 / points)
        whole[0] /= 2
        jacobian[i, :, 0], jacobian[i, :, 1] = whole.real, whole.imag
    left = np.eye(2 * m * size) - jacobian.reshape(2 * m * size, -1)
    right = np.stack([off.real, off.imag], axis=2).ravel()
    real = np.ones((m, size, 2), bool)
    real[:, 0, 1] = False  # of a constant the real part alone
    kept = real.ravel()
    found = np.zeros(2 * m * size)
    found[kept] = np.linalg.lstsq(left[np.ix_(kept, kept)], right[kept], rcond=None)[0]
    step = found.reshape(m, size, 2)
    return np.asarray(step[..., 0] + 1j * step[..., 1])
