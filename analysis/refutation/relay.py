"""Periodic orbits of relay loops, the limit of steep saturations: where the search for orbits of laws starts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.deadline import checkpoint

Reals = NDArray[np.float64]
Complexes = NDArray[np.complex128]

NEWTON_STEPS = 30
STARTS = 800


@dataclass(frozen=True, slots=True)
class RelayOrbit:
    """An orbit of ``x' = A x - b sign(c x)``.

    Attributes
    ----------
    times : ndarray
        (m,), times [s] between the switches; ``c x > 0`` at first.
    states : ndarray
        (m, n), the states at the switches, from the one at which it begins.
    half : bool
        Whether the times make half a period, after which the state is the negative of the first.
    """

    times: Reals
    states: Reals
    half: bool


class RelayOrbits:
    """Relay orbits with a given number of switches, by Newton's method from many random times at once.

    In the modes of ``A`` all is explicit: between switches ``z' = lambda z + u beta``, ``u = -+1``, and the first state
    of a periodic motion follows from the times.  Floating point, for ``A`` with a full set of eigenvectors: proposals,
    never proofs.
    """

    def __init__(self, A: Reals, b: Reals, c: Reals) -> None:
        self.rates, self.modes = (part.astype(complex) for part in np.linalg.eig(A))
        self.beta = np.linalg.lstsq(self.modes, b.astype(complex), rcond=None)[0]
        self.gamma = c @ self.modes
        sizes = np.abs(self.rates)
        self.scale = sizes[sizes > 1e-9 * sizes.max()] if sizes.max() > 0 else np.ones(1)

    def with_switches(self, count: int, *, half: bool, seed: int = 0) -> list[RelayOrbit]:
        """Orbits with ``count`` switches in the half or whole period, no two with the same times."""
        fast, slow = float(self.scale.max()), float(self.scale.min())
        draw = np.random.default_rng(seed).uniform(np.log(0.1 / fast), np.log(6 / slow), (STARTS, count))
        times, sign = np.exp(draw), -1.0 if half else 1.0
        with np.errstate(all="ignore"):
            for _ in range(NEWTON_STEPS):
                checkpoint()
                times, change = self._newton(times, sign)
                if len(times) == 0:
                    return []
            times = times[change < 1e-8]
            if len(times) == 0:
                return []
            _, _, states = self._shoot(times, sign)
            valid = self._signs(times, states)
        found: dict[tuple[float, ...], RelayOrbit] = {}
        for i in np.flatnonzero(valid):
            key = tuple(sorted(float(f"{t:.4g}") for t in times[i]))
            real = np.array([(self.modes @ state[i]).real for state in states[:-1]])
            found.setdefault(key, RelayOrbit(times[i], real, half))
        return sorted(found.values(), key=lambda orbit: float(orbit.times.sum()))

    def _newton(self, times: Reals, sign: float) -> tuple[Reals, Reals]:
        """The times after a damped step, without those that left the range, and how much they changed relatively."""
        misses, jacobian, _ = self._shoot(times, sign)
        good = np.isfinite(jacobian).all(axis=(1, 2)) & np.isfinite(misses).all(axis=1)
        times, misses, jacobian = times[good], misses[good], jacobian[good]
        scale = np.abs(jacobian).max(axis=(1, 2), keepdims=True) + 1e-300
        jacobian, misses = jacobian / scale, misses / scale[..., 0]
        regular = np.abs(np.linalg.det(jacobian)) > 1e-12
        times, misses, jacobian = times[regular], misses[regular], jacobian[regular]
        step = np.linalg.solve(jacobian, misses[..., None])[..., 0]
        change = np.abs(step / times).max(axis=1)
        times = times - step * np.minimum(1, 0.4 / np.maximum(change, 1e-300))[:, None]
        kept = np.isfinite(times).all(axis=1)
        kept &= (times > 1e-6 / self.scale.max()).all(axis=1) & (times < 100 / self.scale.min()).all(axis=1)
        return times[kept], change[kept]

    def _shoot(self, times: Reals, sign: float) -> tuple[Reals, Reals, list[Complexes]]:
        """Values of ``c x`` at the switches, their derivative by the times, and the states in modes."""
        batch, m = times.shape
        decay, gain = self._propagators(times)
        force = [self.beta * (-1 if i % 2 == 0 else 1) for i in range(m)]
        whole: Complexes = np.ones((batch, len(self.rates)), complex)
        forced: Complexes = np.zeros((batch, len(self.rates)), complex)
        for i in range(m):
            forced, whole = decay[:, i] * forced + gain[:, i] * force[i], whole * decay[:, i]
        states: list[Complexes] = [forced / (sign - whole)]
        for i in range(m):
            states.append(decay[:, i] * states[-1] + gain[:, i] * force[i])
        jacobian: Reals = np.empty((batch, m, m))
        for j in range(m):
            push = self.rates * states[j + 1] + force[j]
            moved = push
            for i in range(j + 1, m):
                moved = decay[:, i] * moved
            change = moved / (sign - whole)
            jacobian[:, 0, j] = (change @ self.gamma).real
            for i in range(m - 1):
                change = decay[:, i] * change + (push if i == j else 0)
                jacobian[:, i + 1, j] = (change @ self.gamma).real
        return np.stack([(z @ self.gamma).real for z in states[:-1]], axis=1), jacobian, states

    def _propagators(self, times: Reals) -> tuple[Complexes, Complexes]:
        """``e^(lambda t)`` and ``(e^(lambda t) - 1)/lambda`` for every time and mode."""
        exponent = self.rates * times[..., None]
        still = np.abs(self.rates) < 1e-9 * self.scale.min()
        gain = np.where(still, times[..., None] + 0j, np.expm1(exponent) / np.where(still, 1, self.rates))
        return np.exp(exponent), gain

    def _signs(self, times: Reals, states: list[Complexes]) -> NDArray[np.bool_]:
        """Whether ``c x`` has the relay's sign at samples between the switches."""
        valid = np.ones(len(times), bool)
        for i in range(times.shape[1]):
            side = 1 if i % 2 == 0 else -1
            for share in np.linspace(0.02, 0.98, 25):
                decay, gain = self._propagators(times[:, i] * share)
                valid &= ((decay * states[i] - side * gain * self.beta) @ self.gamma).real * side > 0
        return valid
