r"""Harmonic balance in one channel or several: periodic solutions of least factor, in floating point.

``sigma = H mu``, ``mu_i = -phi_i(sigma_i)`` with ``sigma(t) = Re sum_h c_h e^(i h omega t)`` cut off: for every
harmonic ``c_h + H(i h omega) f_h = 0``, ``f_h`` those of ``phi(sigma)``.  Each ``phi_i`` is a staircase: its slope is
the lower or the upper bound of the class in turn, from kink to kink.  Frequency, waves, kinks and the factor ``alpha``
of the upper bounds are unknown together.  From random ones Gauss and Newton's steps lead to a solution; there ``alpha``
is made smaller along the surface of solutions, on which a fold, where orbits of given kinks end, is a minimum and
nothing singular.  Proposals, never proofs.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, islice
from typing import NamedTuple

from lure.analysis.deadline import checkpoint
from lure.arrays import Complexes, Reals, np
from lure.record import described, quantity

SAMPLES = 128
_CORRECTIONS, _DESCENTS, _SMALL, _FINE = 40, 60, 1e-6, 1e-9
_RESONANT, _DETUNED, _SMALLER = 0.6, 0.1, 4.0  # of random waves: at a resonance, how near, how far below
_LARGEST, _ALIKE, _ENOUGH, _KEPT, _POLISHED, _SEED = 1e6, 1e-3, 6, 2, 20, 20261122


class Side(NamedTuple):
    """A staircase to one side of 0: whether it begins with the upper slope, and where its kinks stand."""

    steep: bool
    kinks: Reals


class Wave(NamedTuple):
    """Waves that nearly satisfy the loop.

    Attributes
    ----------
    alpha : float
        Factor of the upper bounds.
    omega : float
        Fundamental frequency [rad/s].
    waves : ndarray
        (m, harmonics) complex.
    sides : tuple of (Side, Side)
        For each nonlinearity the staircase to the right and to the left of 0.
    """

    alpha: float
    omega: float
    waves: Complexes
    sides: tuple[tuple[Side, Side], ...]


@described()
class Balance:
    """Harmonic balance for one plant and classes of slopes ``[l_i, alpha u_i]``."""

    A: Reals = quantity("(n, n) [floating point]")
    B: Reals = quantity("(n, m) [floating point]")
    C: Reals = quantity("(m, n) [floating point]")
    D: Reals = quantity("(m, m) [floating point]")
    lower: Reals = quantity("(m,) lower bounds at ``alpha = 1``")
    upper: Reals = quantity("(m,) upper bounds at ``alpha = 1``")
    blocks: Sequence[Sequence[int]] = quantity("The channels of each nonlinearity")
    odd: Sequence[bool] = quantity("For each nonlinearity whether its class is one of odd ones")
    harmonics: tuple[int, ...] = quantity("Which are kept; odd ones alone for half waves")
    kinks: Sequence[int] = quantity("How many each nonlinearity has to each side; none for a gain")
    samples: int = quantity("Of a period", default=SAMPLES)

    def __post_init__(self) -> None:
        phase = np.arange(self.samples) * (2 * math.pi / self.samples)
        turns = np.exp(1j * np.outer(phase, self.harmonics))
        weight = np.where(np.array(self.harmonics) == 0, 1.0, 2.0) / self.samples
        poles = np.linalg.eigvals(self.A)
        self.turning = np.unique(np.abs(poles.imag[np.abs(poles.imag) > 1e-9 * np.abs(poles).max(initial=0.0)]))
        rates = np.abs(poles)
        rates = rates[rates > 1e-6 * rates.max()] if rates.max() > 0 else np.ones(1)
        self.slowest, self.quickest = float(rates.min()) / 10, float(rates.max()) * 30
        self.synthesis = np.stack([turns.real, -turns.imag], axis=2)  # (q, h, 2)
        self.analysis = turns.conj().T * weight[:, None]  # (h, q)

    def response(self, omega: float) -> tuple[Complexes, Complexes]:
        """``H`` and its derivative by ``ln omega`` at every harmonic, (h, m, m)."""
        s = 1j * omega * np.array(self.harmonics)
        inverse = np.linalg.inv(s[:, None, None] * np.eye(len(self.A)) - self.A)
        moved = inverse @ self.B
        return self.C @ moved + self.D, -s[:, None, None] * (self.C @ (inverse @ moved))

    def sampled(self, wave: Wave) -> Reals:
        """``sigma`` over a period, (m, samples)."""
        parts = np.stack([wave.waves.real, wave.waves.imag], axis=2)
        return np.asarray(parts.reshape(len(parts), -1) @ self.synthesis.reshape(self.samples, -1).T)

    def harmonics_of(self, values: Reals) -> Complexes:
        """(m, harmonics) of signals (m, samples).

        ``values``: the signals over a period.
        """
        return np.asarray(values @ self.analysis.T)

    def residual(self, wave: Wave) -> tuple[Reals, Reals]:
        """What the balance misses, and its derivative by the unknowns.

        These are real and imaginary parts, ``ln omega``, ``ln alpha`` and the logarithms of the kinks.  The last
        equation is that the waves have norm 1.
        """
        m, count = wave.waves.shape
        value, slope, steps = self.nonlinear(wave, self.sampled(wave))
        missed, moved = self.linearised(wave, value, slope)
        by_steps = np.einsum("hij,kjh->ihk", self.response(wave.omega)[0], steps @ self.analysis.T)
        whole = np.concatenate([moved, by_steps.reshape(m * count, -1)], axis=1)
        flat = np.stack([wave.waves.real, wave.waves.imag], axis=2).ravel()
        norm = np.concatenate([2 * flat, np.zeros(whole.shape[1] - len(flat))])
        misses = np.concatenate([missed.real.ravel(), missed.imag.ravel(), [flat @ flat - 1]])
        return misses, np.concatenate([whole.real, whole.imag, norm[None]])

    def linearised(self, wave: Wave, value: Reals, slope: Reals) -> tuple[Complexes, Complexes]:
        """``c_h + H f_h``, (m, harmonics), and its derivative by the parts of the waves and ``ln omega``.

        ``value``, ``slope``: (m, samples) ``phi(sigma)`` and ``phi'(sigma)``.
        """
        m, count = wave.waves.shape
        H, turned = self.response(wave.omega)
        f = self.harmonics_of(value)
        flat_waves = self.synthesis.reshape(self.samples, -1)
        by_wave = np.stack([(self.analysis * row) @ flat_waves for row in slope], axis=1)  # (h, m, 2 h)
        columns = (H[:, :, :, None] * by_wave[:, None]).transpose(1, 0, 2, 3).reshape(m, count, m, count, 2)
        i, h = np.arange(m)[:, None], np.arange(count)[None, :]
        columns[i, h, i, h, 0] += 1
        columns[i, h, i, h, 1] += 1j
        by_omega = np.einsum("hij,jh->ih", turned, f)
        moved = np.concatenate([columns.reshape(m * count, -1), by_omega.reshape(-1, 1)], axis=1)
        return wave.waves + np.einsum("hij,jh->ih", H, f), moved

    def later(self, wave: Wave) -> Reals:
        """How the parts of the waves change with a shift in time: the same solution."""
        turn = 1j * wave.waves * np.array(self.harmonics)
        return np.stack([turn.real, turn.imag], axis=2).ravel()

    def nonlinear(self, wave: Wave, sigma: Reals) -> tuple[Reals, Reals, Reals]:
        """``phi``, its slope, and its derivative by ``ln alpha`` and ``ln`` of every kink.

        ``wave``: the waves, with their staircases; ``sigma``: (m, samples).
        """
        shape, steep, moved = np.zeros_like(sigma), np.zeros_like(sigma), list[Reals]()
        for odd, block, sides in zip(self.odd, self.blocks, wave.sides, strict=True):
            rows, begun = sigma[[*block]], len(moved)
            size, right = np.abs(rows), rows >= 0
            for k, side in enumerate(sides):
                here, way = (right, 1.0) if k == 0 else (~right, -1.0)
                value, up, sign = here * size * side.steep, here * float(side.steep), 1.0 - 2.0 * side.steep
                for i, kink in enumerate(side.kinks):
                    beyond = here & (size > kink)
                    value, up = value + sign * beyond * (size - kink), up + sign * beyond
                    change = np.zeros_like(sigma)
                    change[[*block]] = -way * sign * kink * beyond
                    if k == 1 and odd:
                        moved[begun + i] += change
                    else:
                        moved.append(change)
                    sign = -sign
                shape[[*block]] += way * value
                steep[[*block]] += up
        top, low = wave.alpha * self.upper[:, None], self.lower[:, None]
        width = top - low
        return low * sigma + width * shape, low + width * steep, np.array([top * shape, *(width * v for v in moved)])

    def moved(self, wave: Wave, step: Reals) -> Wave:
        """The waves after a step of the unknowns.

        ``step``: of the unknowns, as in :meth:`residual`.
        """
        m, count = wave.waves.shape
        change, rest = step[: 2 * m * count].reshape(m, count, 2), step[2 * m * count :]
        waves = wave.waves + change[..., 0] + 1j * change[..., 1]
        at, found = 2, list[tuple[Side, Side]]()
        for odd, sides in zip(self.odd, wave.sides, strict=True):
            new = list[Side]()
            for k, side in enumerate(sides):
                if k == 1 and odd:
                    new.append(new[0])
                    continue
                size = len(side.kinks)
                new.append(Side(side.steep, np.sort(side.kinks * np.exp(rest[at : at + size]))))
                at += size
            found.append((new[0], new[1]))
        return Wave(wave.alpha * math.exp(rest[1]), wave.omega * math.exp(rest[0]), waves, tuple(found))

    def corrected(self, wave: Wave) -> Wave | None:
        """The nearest solution that Gauss and Newton's steps lead to; None if to none.

        ``wave``: where to begin.
        """
        damping, (misses, slopes) = 1e-2, self.residual(wave)
        for _ in range(_CORRECTIONS):
            checkpoint()
            if not (np.isfinite(misses).all() and np.isfinite(slopes).all()):
                return None
            square = slopes @ slopes.T + damping * float(misses @ misses) * np.eye(len(misses))
            step = -slopes.T @ np.linalg.lstsq(square, misses, rcond=1e-14)[0]
            largest = float(np.abs(step).max())
            step *= min(1.0, 0.5 / max(largest, 1e-300))
            trial = self.moved(wave, step)
            if not self._sane(trial):
                return None
            after, turned = self.residual(trial)
            if not after @ after < misses @ misses:
                if largest < _SMALL:
                    return wave if float(np.abs(misses).max()) < _SMALL else None
                damping = max(damping, 1e-6) * 8
                if damping > 1e8:
                    return None
                continue
            damping = damping / 5
            wave, misses, slopes = trial, after, turned
            if float(np.abs(misses).max()) < _FINE:
                return wave
        return wave if float(np.abs(misses).max()) < _SMALL else None

    def _sane(self, wave: Wave) -> bool:
        return bool(
            1e-9 < wave.alpha < _LARGEST and self.slowest < wave.omega < self.quickest and np.isfinite(wave.waves).all()
        )

    def lowest(self, wave: Wave, *, steps: int = _DESCENTS) -> Wave:
        """The solution of least factor that is reached downhill.

        ``wave``: a solution; ``steps``: how many steps, at most.
        """
        length, at = 0.1, 2 * wave.waves.size + 1
        for _ in range(steps):
            _, slopes = self.residual(wave)
            goal = np.zeros(slopes.shape[1])
            goal[at] = -1.0
            down = goal - slopes.T @ np.linalg.lstsq(slopes @ slopes.T, slopes @ goal, rcond=1e-14)[0]
            size = float(np.linalg.norm(down))
            if size < 1e-6:
                break
            while length > 1e-7:
                found = self.corrected(self.moved(wave, down * (length / size)))
                if found is not None and found.alpha < wave.alpha * (1 - 0.1 * length * size):
                    break
                length /= 3
            else:
                break
            wave, length = found, min(0.3, 2 * length)
        return wave

    def beside(self, wave: Wave, length: float) -> Wave | None:
        """A solution with the same kinks beside one at a fold, where the factor has grown like the length squared.

        ``wave``: the solution.  ``length``: how far away, in units of the waves; of any sign.
        """
        count = 2 * wave.waves.size
        _, slopes = self.residual(wave)
        still = np.zeros(slopes.shape[1])
        still[:count] = self.later(wave)
        flat = np.vstack([slopes[:, : count + 1], still[: count + 1]])
        step = np.zeros(slopes.shape[1])
        step[: count + 1] = np.linalg.svd(flat)[2][-1]
        return self.corrected(self.moved(wave, length * step))

    def refined(self, wave: Wave) -> tuple[Balance, Wave] | None:
        """The same with twice as many harmonics.

        ``wave``: a solution.
        """
        step = self.harmonics[-1] - self.harmonics[-2]
        more = (*self.harmonics, *(self.harmonics[-1] + step * (i + 1) for i in range(len(self.harmonics))))
        finer = replace(self, harmonics=more, samples=2 * self.samples)
        waves = np.concatenate([wave.waves, np.zeros_like(wave.waves)], axis=1)
        found = finer.corrected(wave._replace(waves=waves))
        return None if found is None else (finer, found)

    def starts(self, count: int, most: float) -> Iterator[Wave]:
        """Random waves: those of cut off random ``mu``, with kinks where ``phi`` has about the size of ``mu``.

        ``count``: how many; ``most``: the largest factor.
        """
        rng, m, order = np.random.default_rng(_SEED), len(self.D), np.maximum(self.harmonics, 1)
        for _ in range(count):
            omega = math.exp(rng.uniform(math.log(3 * self.slowest), math.log(self.quickest / 3)))
            if len(self.turning) and rng.random() < _RESONANT:
                harmonic = rng.choice([h for h in self.harmonics if h])
                omega = float(rng.choice(self.turning) / harmonic * math.exp(_DETUNED * rng.normal()))
            parts = rng.normal(size=(m, len(order), 2)) / order[None, :, None]
            waves = np.einsum("qhp,mhp->mq", self.synthesis, parts)
            waves *= 10 ** rng.uniform(0.5, 2.5, (m, 1)) / np.abs(waves).max(axis=1, keepdims=True)
            mu = 10 ** rng.uniform(-1, 1, (m, 1)) * np.clip(waves, -1, 1)
            found = np.einsum("hij,jh->ih", self.response(omega)[0], self.harmonics_of(mu))
            size = float(np.linalg.norm(found))
            alpha = most * math.exp(-rng.uniform(0, _SMALLER))
            wave = Wave(alpha, omega, found / size, ())
            tops, sizes = np.abs(self.sampled(wave)).max(axis=1), np.abs(mu).max(axis=1) / size
            sides = []
            for block, odd, kinks in zip(self.blocks, self.odd, self.kinks, strict=True):
                i, steep = block[0], [bool(flag) for flag in rng.integers(0, 2, 2)]
                needed = sizes[i] / (alpha * self.upper[i])
                spread = np.sort(rng.uniform(0.1, 1, (2, kinks)), axis=1) * tops[i]
                if kinks and needed < tops[i]:
                    spread[0, 0] = needed if steep[0] else tops[i] - needed
                pair = [Side(up, np.sort(row)) for up, row in zip(steep, spread, strict=True)]
                sides.append((pair[0], pair[0] if odd or not kinks else pair[1]))
            yield wave._replace(sides=tuple(sides))

    def bends(self, wave: Wave) -> bool:
        """Whether some ``sigma_i`` passes a kink, and moves."""
        sigma = self.sampled(wave)
        tops, bottoms = sigma.max(axis=1), sigma.min(axis=1)
        return any(
            bottoms[i] < kink < tops[i]
            for block, (right, left) in zip(self.blocks, wave.sides, strict=True)
            for i in block
            for kink in (*right.kinks, *(-left.kinks))
        )

    def _solutions(self, starts: Iterable[Wave]) -> Iterator[Wave]:
        """Solutions that bend, of those to which the starts lead."""
        found = map(self.corrected, starts)
        return (one for one in found if one is not None and self.bends(one))

    def found(self, count: int, most: float, *, first: Iterable[Wave] = ()) -> list[tuple[Balance, Wave]]:
        """Solutions that bend, the smallest factor first, no two alike, with four times as many harmonics.

        ``count``: how many random waves to begin with; ``most``: the largest factor of interest; ``first``: what to
        begin with besides.
        """
        finer = list[tuple[Balance, Wave]]()
        with np.errstate(all="ignore"):
            try:
                drawn = islice(self._solutions(self.starts(count, most)), _ENOUGH)
                waves = [self.lowest(one) for one in chain(self._solutions(first), drawn)]
            except np.linalg.LinAlgError:  # a pole at a harmonic
                return []
            for wave in sorted(waves, key=lambda one: one.alpha):
                again = any(abs(wave.alpha / other.alpha - 1) < _ALIKE for _, other in finer)
                if again or wave.alpha > most or not self.bends(wave) or len(finer) == _KEPT:
                    continue
                found: tuple[Balance, Wave] | None = (self, wave)
                for _ in range(2):
                    found = found[0].refined(found[1]) if found is not None else None
                    found = None if found is None else (found[0], found[0].lowest(found[1], steps=_POLISHED))
                if found is not None:
                    finer.append(found)
        return sorted(finer, key=lambda one: one[1].alpha)
