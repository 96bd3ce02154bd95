"""Periodic solutions of a loop with a sine as input by harmonic balance, in floating point: proposals, never proofs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

from lure.analysis.deadline import checkpoint
from lure.analysis.forced.loop import ForcedLoop
from lure.arrays import Complexes, Reals, np
from lure.record import described, quantity

_BY_NEWTON, _STEPS, _TRIED, _HALVINGS, _SMALL = 24, 60, 25, 12, 1e-13


@described(frozen=True)
class Wave:
    r"""``w(t) = constant + amplitude sin(omega t)``, looked at over ``periods`` of its periods."""

    constant: tuple[Fraction, ...] = quantity("(p,)", "unit of w")
    amplitude: tuple[Fraction, ...] = quantity("(p,)", "unit of w")
    omega: Fraction = quantity("[rad/s]; 0 for a constant input")
    periods: int = quantity(
        "How many periods of the input the solution looked for has: more than 1 for a subharmonic", default=1
    )

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


@described(frozen=True)
class Balanced:
    """Harmonics ``c_k`` of the ``psi_i(sigma_i)`` that nearly balance the loop."""

    wave: Wave = quantity("The input")
    psi: Complexes = quantity("(m, count + 1) complex, ``psi = Re sum c_k e^(i k base t)``, the first column real")
    residual: float = quantity("By how much the harmonics do not balance")
    missed: float = quantity("Mean square root of what they miss of ``psi(sigma)``, by samples")
    peak: float = quantity("Largest ``|z|``, by samples")

    @property
    def count(self) -> int:
        """How many harmonics."""
        return int(self.psi.shape[1]) - 1


def sampled(coefficients: Complexes, points: int) -> Reals:
    """``Re sum c_k e^(2 pi i k j/points)`` for every ``j``.

    ``coefficients``: (..., count + 1); ``points``: more than twice as many.
    """
    half = coefficients * (points / 2)
    half[..., 0] = coefficients[..., 0].real * points
    return np.asarray(np.fft.irfft(half, points, axis=-1))


def balanced(loop: ForcedLoop, wave: Wave, start: Complexes, count: int, steps: int = _STEPS) -> Balanced:
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
    steps : int
        How many steps at most.
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
        for _ in range(steps):
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
    z = sampled((forced - np.einsum("kij,jk->ik", whole, psi))[loop.channels :], PEAK * points)
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


# Several steady solutions of one loop: by simulation from many starts and harmonic balance, in floating point.

_STARTS, _PERIODS, _PER_PERIOD, _FASTEST, _LONGEST, _FORGOTTEN, _STILL = 24, (24, 160), 48, 8.0, 3, 6.0, 1e-5
PEAK = 16  # samples for a peak of z, in place of one for the balance: between two of 128 it hides 3e-4 of itself
_COUNT, _FINER, _MISSED, _ALIKE, _SETTLED, _SEED, _RANDOM = 20, (64, 192), 1e-9, 1e-3, 0.02, 20261123, 16
_FAR = 1e100


def solutions(loop: ForcedLoop, wave: Wave) -> list[Balanced]:
    """Steady solutions with up to three periods of the input, no two alike, the smallest first.

    ``loop``: the loop, in continuous time.
    """
    found = list[Balanced]()
    for start in (*_settled(loop, wave), *_random(loop, wave)):
        checkpoint()
        if any(_alike(start, other) for other in found):
            continue
        first = balanced(loop, start.wave, start.psi, _COUNT * start.wave.periods, _TRIED)
        if not _good(first) or any(_alike(first, other) for other in found):
            continue
        first = _shortened(first)
        finer = balanced(loop, first.wave, first.psi, _FINER[0])
        if finer.missed > _MISSED * finer.peak:
            finer = balanced(loop, first.wave, finer.psi, _FINER[1])
        if _good(finer) and not any(_alike(finer, other) for other in found):
            found.append(finer)
    return sorted(found, key=lambda one: one.peak)


def multiplier(loop: ForcedLoop, found: Balanced) -> float:
    """The largest modulus of the Floquet multipliers over a period: below 1 the solution attracts what is near."""
    A, B, C, _, _, _ = loop.doubles
    m = loop.channels
    T = 2 * math.pi / float(found.wave.base)
    steps = 2 * math.ceil(max(256.0 * found.wave.periods, 4 * T * _fastest(A)))
    sigma = _signal(loop, found, steps)
    slopes = [
        np.asarray(phi.slope(s)) - float(g)  # type: ignore[attr-defined]  # what has an enclosure has one
        for phi, s, g in zip(loop.nonlinearities, sigma, loop.gains, strict=True)
    ]
    a = np.array(slopes)

    def inner(k: int) -> Reals:
        """The matrix of the linearised equation at one step of the period."""
        return np.asarray(A - (B[:, :m] * a[:, k % steps]) @ C[:m])

    whole, step = np.eye(len(A)), 2 * T / steps
    with np.errstate(all="ignore"):
        for k in range(0, steps, 2):
            first, middle, last = inner(k), inner(k + 1), inner(k + 2)
            one = first @ whole
            two = middle @ (whole + step / 2 * one)
            three = middle @ (whole + step / 2 * two)
            whole = whole + step / 6 * (one + 2 * two + 2 * three + last @ (whole + step * three))
        return float(np.abs(np.linalg.eigvals(whole)).max()) if np.isfinite(whole).all() else math.inf


def _fastest(A: Reals) -> float:
    return float(np.abs(np.linalg.eigvals(A)).max())


def _signal(loop: ForcedLoop, found: Balanced, points: int) -> Reals:
    """Samples of ``sigma``."""
    inner, outer = loop.responses(float(found.wave.base), found.count)
    rows = np.einsum("kij,jk->ik", outer, found.wave.harmonics(found.count)) - np.einsum("kij,jk->ik", inner, found.psi)
    return sampled(rows[: loop.channels], points)


def _good(found: Balanced) -> bool:
    return bool((np.abs(found.psi) < _FAR).all()) and found.residual < _MISSED * max(
        1.0, float(np.abs(found.psi).max())
    )


def _alike(one: Balanced, other: Balanced) -> bool:
    """Whether they are the same, perhaps some periods of the input later."""
    if one.wave.periods != other.wave.periods:
        short, long = sorted((one, other), key=lambda each: each.wave.periods)
        n, spread = long.wave.periods, np.zeros_like(long.psi)
        kept = min(long.count // n, short.count)
        spread[:, : n * kept + 1 : n] = short.psi[:, : kept + 1]
        return short.wave.periods == 1 and _near(long.psi, spread)
    n, size = one.wave.periods, min(one.count, other.count) + 1
    turn = np.exp(2j * math.pi * np.arange(size) / n)
    return any(_near(one.psi[:, :size], other.psi[:, :size] * turn**k) for k in range(n))


def _shortened(one: Balanced) -> Balanced:
    """The same over one period of the input, if it repeats with it."""
    n, rest = one.wave.periods, one.psi.copy()
    rest[:, ::n] = 0
    if n == 1 or np.linalg.norm(rest) > _ALIKE * np.linalg.norm(one.psi):
        return one
    return replace(one, wave=replace(one.wave, periods=1), psi=one.psi[:, ::n])


def _near(one: Complexes, other: Complexes) -> bool:
    return float(np.linalg.norm(one - other)) <= _ALIKE * max(float(np.linalg.norm(side)) for side in (one, other))


def _settled(loop: ForcedLoop, wave: Wave) -> Iterator[Balanced]:
    """What simulations from many starts come to, as harmonics of ``psi``."""
    A, B, C, _, E, F = loop.doubles
    m, T = loop.channels, 2 * math.pi / float(wave.omega)
    fast = max(1.0, _fastest(A) * T / _FASTEST)
    steps = 2 ** math.ceil(math.log2(_PER_PERIOD * fast))
    constant, amplitude = (np.array([float(v) for v in side]) for side in (wave.constant, wave.amplitude))
    inputs = constant + np.sin(np.arange(2 * steps) * (math.pi / steps))[:, None] * amplitude
    pushed, seen = inputs @ E.T, inputs @ F[:m].T
    decay = -float(np.linalg.eigvals(A).real.max())
    length = int(np.clip(_FORGOTTEN / max(decay * T, 1e-9), *_PERIODS))
    x = _starts(loop, wave)
    kept = np.empty((_LONGEST, steps, len(x), m))
    step, gains = T / steps, np.array([float(g) for g in loop.gains])

    def psi(x: Reals, k: int) -> Reals:
        """``phi(sigma) - g sigma`` at one step of the period."""
        sigma = x @ C[:m].T + seen[k]
        values = -gains * sigma
        for i, phi in enumerate(loop.nonlinearities):
            values[:, i] += phi(sigma[:, i])
        return np.asarray(values)

    def rate(x: Reals, k: int) -> Reals:
        """``dx/dt`` of all states in one step."""
        return np.asarray(x @ A.T - psi(x, k) @ B.T + pushed[k])

    states, period = list[Reals](), 0
    with np.errstate(all="ignore"):
        for period in range(length):
            checkpoint()
            states = [*states[-_LONGEST:], x]
            for j in range(steps):
                k = 2 * j
                one = rate(x, k)
                two = rate(x + step / 2 * one, k + 1)
                three = rate(x + step / 2 * two, k + 1)
                kept[period % _LONGEST, j] = psi(x, k)
                x = x + step / 6 * (one + 2 * two + 2 * three + rate(x + step * three, (k + 2) % (2 * steps)))
            moved, size = (np.linalg.norm(one, axis=1) for one in (x - states[-1], x))
            if period > _LONGEST and ((moved <= _STILL * size) | ~(size < _FAR)).all():
                break
    kept = np.roll(kept, -period - 1, axis=0).reshape(_LONGEST * steps, len(x), m)
    ended = (np.abs(x) < _FAR).all(axis=1) & (np.abs(kept) < _FAR).all(axis=(0, 2))
    for i in np.flatnonzero(ended):
        sizes = [float(np.linalg.norm(x[i] - states[-n][i])) for n in range(1, _LONGEST + 1)]
        n = next(
            (n for n, off in enumerate(sizes, 1) if off < _SETTLED * np.linalg.norm(x[i])), int(np.argmin(sizes)) + 1
        )
        whole = np.fft.rfft(kept[-n * steps :, i], axis=0).T * (2 / (n * steps))
        psi_of = whole[:, : _COUNT * n + 1].copy()
        psi_of[:, 0] = psi_of[:, 0].real / 2
        yield Balanced(Wave(wave.constant, wave.amplitude, wave.omega, n), psi_of, 0.0, 0.0, 0.0)


def _starts(loop: ForcedLoop, wave: Wave) -> Reals:
    """States of the sizes that the input makes of the loop, and larger and smaller ones."""
    A, _, _, _, E, _ = loop.doubles
    rng = np.random.default_rng(_SEED)
    at = 1j * float(wave.omega) * np.eye(len(A)) - A
    size = np.abs(np.linalg.solve(at, E @ np.array([float(v) for v in wave.amplitude]).astype(complex))) + 1e-3
    return np.asarray(rng.normal(size=(_STARTS, len(A))) * size * 10 ** rng.uniform(-1.5, 1.5, (_STARTS, 1)))


def _random(loop: ForcedLoop, wave: Wave) -> Iterator[Balanced]:
    """Random first harmonics of ``sigma``, and what ``psi`` makes of them: for solutions that attract nothing."""
    rng, points = np.random.default_rng(_SEED), 256
    _, outer = loop.responses(float(wave.base), _COUNT)
    driven = np.einsum("kij,jk->ik", outer, wave.harmonics(_COUNT))[: loop.channels]
    size = max(float(np.abs(driven).max()), 1e-3)
    angle = np.exp(2j * math.pi * np.arange(points) / points)
    for _ in range(_RANDOM):
        first = size * 10 ** rng.uniform(-1.5, 1.0) * np.exp(2j * math.pi * rng.random(loop.channels))
        sigma = (first[:, None] * angle).real + driven[:, :1].real
        values = np.array(
            [np.asarray(p(s)) - float(g) * s for p, g, s in zip(loop.nonlinearities, loop.gains, sigma, strict=True)]
        )
        psi = np.fft.rfft(values, axis=1)[:, : _COUNT + 1] * (2 / points)
        psi[:, 0] = psi[:, 0].real / 2
        yield Balanced(wave, psi, 0.0, 0.0, 0.0)
